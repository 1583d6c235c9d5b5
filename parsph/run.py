"""A whole run: folder, start summary, the run itself, end summary."""

import json
import platform
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import __version__, parallel
from .analysis import mean_height
from .errors import Interrupted
from .io.folder import output_folder, write_whole
from .jit import compilations
from .moments import Moments
from .observers import InterruptGuard
from .parallel import Communicator
from .progress import ProgressLog, console, duration, phase_table, size_text
from .scene.build import build, cuts_of
from .scene.check_waves import doubts_of
from .scene.load import load_scene, scene_name, scene_text
from .scene.movers import expected_height
from .scene.plan import costs
from .scene.solids import fillings_of
from .scene.zones import relaxed_height
from .traffic import traffic, traffic_text
from .walls import INTERPOLATORS


@dataclass
class Finished:
    """What a run leaves: the simulation (gauges hold their records), its folder, and the summary that was printed."""

    simulation: object
    folder: Path
    summary: dict


def run(source="pool", overrides=(), out=None, overwrite=False, ranks_info=False, communicator=None):
    """Run a scene from beginning to end, with files and summaries.

    Parameters
    ----------
    source, overrides
        As `parsph.load_scene`.
    out : path, optional
        Output folder; default ``runs/<scene>-<NNN>``.
    overwrite : bool
        Whether `out` may be emptied.
    ranks_info : bool
        Whether to print what each rank owns.
    communicator : Communicator, optional

    Returns
    -------
    Finished

    Raises
    ------
    SceneError
        Bad input; nothing was written.
    RunError
        The run went wrong; the last good snapshot is kept.
    """
    communicator = communicator or parallel.start()
    scene = load_scene(source, overrides)
    cuts_of(scene, communicator.size)  # whatever speaks against it must do so before a folder is made
    name = scene_name(source)
    folder = communicator.on_root(lambda: output_folder(name, out, overwrite))
    communicator.on_root(lambda: (folder / "scene.json").write_text(scene_text(scene), encoding="utf-8"))
    loading = time.perf_counter()
    compiled = load_code(scene, communicator)
    loading = time.perf_counter() - loading
    simulation = build(scene, communicator, folder)
    log = ProgressLog(scene.log_interval, scene.time.end)
    guard = InterruptGuard()
    simulation.observers += [log, guard]
    if communicator.rank == 0:
        _print_start(scene, simulation, folder, name, loading, compiled)
    if ranks_info:
        _print_ranks(simulation)
    begin, processor = time.perf_counter(), time.process_time()
    try:
        simulation.run()
    except KeyboardInterrupt:
        why = "what was written up to here is complete"
        raise Interrupted(f"interrupted at t = {simulation.time:.6g} s", where=str(folder), why=why) from None
    finally:
        guard.close()
        log.close()
    spent = time.perf_counter() - begin, time.process_time() - processor
    summary = _summary(scene, simulation, folder, name, *spent, log.total)
    if communicator.rank == 0:
        write_whole(folder / "summary.json", json.dumps(summary, indent=1))  # its presence says that the run has finished
    _print_end(simulation, summary)
    return Finished(simulation, folder, summary)


def load_code(scene, communicator):
    """Compile what the scene needs, or load it from the cache: first one rank per node, then the others.

    Returns
    -------
    int
        How many functions this rank had to compile.
    """
    before = compilations()
    if communicator.node_rank == 0:
        _touch_code(scene)
    communicator.barrier()
    if communicator.node_rank != 0:
        _touch_code(scene)
    return compilations() - before


def _touch_code(scene):
    """Make a step with a handful of particles of the same scene, all kinds of walls, zones and gauges included."""
    dx = scene.numerics.dx
    corner = [float(x) - 0.5 * dx for x in fillings_of(scene)[0].first]
    tiny = {"low": corner, "high": [low + 1.01 * dx for low in corner], "depth": scene.fluid.blocks[0].depth}
    keys = json.loads(scene_text(scene))
    keys["fluid"] = {**keys["fluid"], "blocks": [tiny], "level": scene.level}
    keys["numerics"]["c0"] = scene.c0
    keys["numerics"]["density_range"] = [0.0, 1e3]  # so few particles have no density worth the name once it is summed
    keys["time"]["settle"] = 0.0
    keys["relaxation"] = [{**zone, "theory": "airy"} for zone in keys["relaxation"]]  # the same code, and waves of any depth
    keys["gauges"] = [_moved(gauge, corner) for gauge in keys["gauges"]]
    model = type(scene).model_validate(keys)
    simulation = build(model, Communicator())
    simulation.prepare()
    simulation.step(1e-9)
    if model.output.snapshots.moments:
        with simulation.present():
            Moments(simulation.sweep)(simulation.particles, simulation.domain.starts, simulation.domain.slab)
    if simulation.density_filter:
        simulation.filter_densities()


def _moved(gauge, place):
    """Return a gauge's keys with its place where the handful of particles is."""
    point = {"point": place} if "point" in gauge else {}
    return {**gauge, **point, **{key: place[d] for d, key in enumerate("xy") if gauge.get(key) is not None}}


def _print_start(scene, simulation, folder, name, loading, compiled):
    layout, out = simulation.particles.layout, console()
    total = costs(scene)["particles"]
    size = total * layout.bytes_per_particle()
    step = simulation.first_step()
    how = f"compiled {compiled} functions in" if compiled else "compiled code loaded in"
    out.print(f"parsph {__version__}: {name} - {scene.title or 'no title'}")
    out.print(
        f"  {total:,} particles, dx = {scene.numerics.dx:g} m, h = {scene.h:g} m, c0 = {scene.c0:.4g} m/s, {scene.dim}D; "
        f"{layout.bytes_per_particle()} bytes per particle, {size_text(size)}"
    )
    settling = f" after {scene.time.settle:g} s of settling" if scene.time.settle else ""
    out.print(
        f"  to t = {scene.time.end:g} s{settling}: about {scene.time.end / step:,.0f} steps of {step:.3g} s "
        f"({simulation.integrator.name}), {simulation.communicator.size} rank(s) on {platform.node()}, {how} {loading:.1f} s"
    )
    out.print(f"  output: {folder}")
    for doubt in doubts_of(scene):
        out.print(f"note: {doubt}", markup=False)


def _print_ranks(simulation):
    slab, p = simulation.domain.slab, simulation.particles
    mine = f"columns {slab.first}:{slab.last}, {len(p.fluid):,} particles, node rank {simulation.communicator.node_rank}"
    lines = simulation.communicator.gather(f"{platform.node()}, {mine}")
    if simulation.communicator.rank == 0:
        for rank, line in enumerate(lines):
            print(f"  rank {rank}: {line}", flush=True)


def _summary(scene, simulation, folder, name, wall, processor, particles):
    comm = simulation.communicator
    evaluations = particles * simulation.evaluations
    summary = {
        "scene": name,
        "version": __version__,
        "particles": particles,
        "ranks": comm.size,
        "time [s]": simulation.time,
        "steps": simulation.steps,
        "wall [s]": wall,
        "cpu [s]": sum(comm.allgather(processor)),
        "evaluations": evaluations,
        "evaluations per second and rank": evaluations / wall / comm.size if wall else 0.0,
        "phases [s]": simulation.timers.over_ranks(comm),
        "folder": str(folder),
    }
    if comm.size > 1:
        summary.update(traffic(simulation))
    walls = _walls_summary(simulation)
    if walls:
        summary["walls"] = walls
    if simulation.correction:
        plain = sum(comm.allgather(simulation.correction.plain)) / simulation.evaluations
        summary["kernel correction"] = {"plain kernel per evaluation": plain}
    if comm.rank == 0:
        summary["files"] = 1 + sum(1 for path in folder.rglob("*") if path.is_file())  # and the summary itself
        summary["bytes written"] = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
        summary.update(wave_heights(scene, simulation))
    return summary


def _walls_summary(simulation):
    """Return what walls are made of and what they did, {} where there is nothing to tell; collective."""
    domain, comm, told = simulation.domain, simulation.communicator, {}
    if domain.ghosts:
        counts = np.sum(comm.allgather(domain.ghosts.methods_used), axis=0) / simulation.evaluations
        names = ["dry", *(each.name for each in sorted(INTERPOLATORS.values(), key=lambda each: each.code))]
        told["ghosts"] = domain.ghosts.count
        told["methods per evaluation"] = dict(zip(names, counts.tolist(), strict=True))
    if domain.barrier:
        told["stopped"] = int(sum(comm.allgather(domain.barrier.stopped)))
    if domain.markers:
        told["markers"] = domain.markers.count
    if domain.exchanging:
        counts = np.sum(comm.allgather([wall.exchanged for wall in domain.walls]), axis=0)
        told["exchanged"] = {wall.name: int(count) for wall, count in zip(domain.walls, counts, strict=True)}
    return told


def wave_heights(scene, simulation):
    """Return the height at each level gauge over the last two periods, and the one that was asked for or is expected.

    Expected: what is asked for, or Biesel's transfer function times the stroke at the still-water level. Empty when the
    scene has no wavemaker, nor relaxation zone, that makes waves of one period without end, no level gauge, or is shorter than
    the start-up and two periods.
    """
    gauges = [g for g in simulation.observers if getattr(g, "columns", ()) == ("level [m]",)]
    expected = expected_height(scene) if scene.wavemaker else relaxed_height(scene)
    period = scene.wave_period
    if expected is None or not gauges or scene.time.end < 6 * period:
        return {}
    heights = {}
    for gauge in gauges:
        t, level = gauge.record().T
        heights[f"{gauge.name} (x = {gauge.place[0]:g} m)"] = mean_height(t, level, period, 2)
    return {"wave height, expected [m]": expected, "wave height [m]": heights}


def _print_end(simulation, summary):
    table = phase_table(simulation.timers, simulation.communicator, summary["wall [s]"])
    if simulation.communicator.rank:
        return
    out = console()
    out.print(table)
    rate = summary["evaluations per second and rank"] / 1e6
    out.print(
        f"{summary['steps']:,} steps, {duration(summary['wall [s]'])}, {rate:.2f} M evaluations/s per core; "
        f"{summary['files']} files, {size_text(summary['bytes written'])} in {summary['folder']}"
    )
    if "communication" in summary:
        out.print(traffic_text(summary))
    if "walls" in summary:
        walls, told = summary["walls"], []
        if "ghosts" in walls:
            used = ", ".join(f"{name} {count:,.1f}" for name, count in walls["methods per evaluation"].items() if count)
            told += [f"{walls['ghosts']:,} ghosts", f"per evaluation {used}", f"{walls['stopped']:,} times a particle stopped"]
        if "markers" in walls:
            told.append(f"{walls['markers']:,} markers")
        if "exchanged" in walls:
            counts = ", ".join(f"{name} {count:,}" for name, count in walls["exchanged"].items())
            told.append(f"times a particle changed places with its image: {counts or 'no mirrors'}")
        out.print(f"walls: {'; '.join(told)}")
    if "kernel correction" in summary:
        plain = summary["kernel correction"]["plain kernel per evaluation"]
        out.print(f"kernel correction: {plain:,.1f} particles with the plain kernel per evaluation")
    if "wave height [m]" in summary:
        out.print(f"wave height: expected {summary['wave height, expected [m]']:.4f} m")
        for gauge, height in summary["wave height [m]"].items():
            out.print(f"  {gauge}: {height:.4f} m")
