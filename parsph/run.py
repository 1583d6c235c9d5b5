"""A whole run: folder, start summary, the run itself, end summary."""

import json
import platform
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass
from functools import reduce
from pathlib import Path

import numpy as np

from . import __version__, parallel
from .analysis import mean_height
from .errors import SceneError
from .io.checkpoints import Checkpoints, latest
from .io.folder import Claim, output_folder, write_whole
from .io.results import SCENE_FILE, SUMMARY_FILE, Results
from .jit import compilations
from .moments import Moments
from .observers import Signals
from .parallel import Communicator
from .progress import ProgressLog, console, duration, phase_table, size_text
from .scene.build import build, cuts_of
from .scene.check_waves import doubts_of
from .scene.limits import refuse_too_large
from .scene.load import load_scene, parse_setting, scene_name, scene_text
from .scene.movers import expected_height
from .scene.plan import costs
from .scene.solids import fillings_of
from .scene.zones import relaxed_height
from .traffic import traffic, traffic_text
from .walls import INTERPOLATORS

STARTED = time.monotonic()  # a wall time counts from when the process began
LARGEST_SHARE, LEAST = 0.1, 10.0  # of the time that a kind of output may take, s that it takes, before the end of a run says so
RARER = {"snapshots": "output.snapshots.every", "gauges": "gauges.N.every"}  # what makes them rarer, by phase
CHANGEABLE = ("time.end", "time.walltime", "output.snapshots.every", "output.log.every", "output.checkpoints.every")


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
        The run went wrong; what was written before is kept.
    Unfinished
        It was asked to end, or its wall time is up; `resume` goes on.
    """
    communicator = communicator or parallel.start()
    scene = load_scene(source, overrides)
    refuse_too_large(scene, communicator)
    cuts_of(scene, communicator.size, communicator)  # whatever speaks against it must do so before a folder is made
    name = scene_name(source)
    folder = communicator.on_root(lambda: output_folder(name, out, overwrite))
    with _claimed(folder, communicator):
        communicator.on_root(lambda: write_whole(folder / SCENE_FILE, scene_text(scene)))
        return _carry_out(scene, name, folder, communicator, ranks_info)


def resume(folder, overrides=(), ranks_info=False, communicator=None):
    """Go on with a run where its newest checkpoint is, to the same bits as if it had never ended, on any number of ranks.

    Without a checkpoint that is whole it begins anew; a run that has finished stays as it is, unless it is to end later.

    Parameters
    ----------
    folder : path
        Output folder of the run.
    overrides
        As of `parsph.load_scene`; when it ends, how long it may take and how often it writes may change.
    ranks_info, communicator
        As of `run`.

    Returns
    -------
    Finished or None
        None when there was nothing to do.

    Raises
    ------
    SceneError, RunError, Unfinished
        As `run`.
    """
    communicator = communicator or parallel.start()
    results = Results(folder)
    scene, name = _continued(results, overrides), results.name
    refuse_too_large(scene, communicator)
    cuts_of(scene, communicator.size, communicator)
    with _claimed(results.folder, communicator):
        checkpoint, damages = latest(results.folder, communicator)
        if communicator.rank == 0:
            for damage in damages:
                print(f"warning: {damage}", file=sys.stderr, flush=True)
        if checkpoint and checkpoint.time > scene.time.end:
            why = f"its newest checkpoint is of t = {checkpoint.time:g} s"
            raise SceneError(f"it cannot end at {scene.time.end:g} s", "time.end", why, "a later end")
        finished = communicator.on_root(lambda: results.summary)
        if finished and finished["time [s]"] >= scene.time.end:
            if communicator.rank == 0:
                print(f"{folder}: has finished at t = {finished['time [s]']:g} s; later ends by --set time.end=...")
            return None
        communicator.on_root(lambda: _reopen(results.folder, scene))
        return _carry_out(scene, name, results.folder, communicator, ranks_info, checkpoint)


def _continued(results, overrides):
    """Return the scene of a run that goes on, with what may be changed of it."""
    items = dict(map(parse_setting, overrides or ())) if not isinstance(overrides, dict) else dict(overrides)
    for key in items:
        if key not in CHANGEABLE:
            why = "a run goes on as it began"
            raise SceneError("cannot change", f"--set {key}", why, f"one of: {', '.join(CHANGEABLE)}; or another run")
    before = load_scene(results.folder / SCENE_FILE)
    if "time.end" in items:  # intervals that follow from it stay
        items.setdefault("output.snapshots.every", before.snapshot_interval)
        items.setdefault("output.log.every", before.log_interval)
    return load_scene(results.folder / SCENE_FILE, items)


def _reopen(folder, scene):
    """Have the folder say that the run has not finished, and when it is to."""
    (folder / SUMMARY_FILE).unlink(missing_ok=True)
    write_whole(folder / SCENE_FILE, scene_text(scene))


@contextmanager
def _claimed(folder, communicator):
    """Keep the folder for this job."""
    claims = []
    communicator.on_root(lambda: claims.append(Claim(folder)))
    try:
        yield
    finally:
        for claim in claims:
            claim.release()


def _carry_out(scene, name, folder, communicator, ranks_info, checkpoint=None):
    """Run a scene from its beginning, or from a checkpoint, to its end."""
    with Signals() as signals:
        loading = time.perf_counter()
        compiled = load_code(scene, communicator)
        loading = time.perf_counter() - loading
        simulation = build(scene, communicator, folder, checkpoint)
        account = Account(simulation, checkpoint)
        log = ProgressLog(scene.log_interval, scene.time.end)
        saved = scene.output.checkpoints.every, scene.time.walltime, STARTED
        simulation.observers += [log, Checkpoints(folder, scene_text(scene), *saved, signals, account.totals)]
        if checkpoint:
            checkpoint.restore(simulation)
        if communicator.rank == 0:
            _print_start(scene, simulation, folder, name, loading, compiled, checkpoint)
        if ranks_info:
            _print_ranks(simulation)
        signals.waiting = True
        try:
            simulation.run()
        finally:
            for observer in simulation.observers:
                observer.close()
    summary = _summary(scene, simulation, folder, name, account, log.total)
    communicator.on_root(lambda: _close(folder, summary))
    _print_end(simulation, summary, account.wall)
    return Finished(simulation, folder, summary)


def _close(folder, summary):
    files = [path for path in folder.rglob("*") if path.is_file() and not path.name.startswith(".")]
    summary["files"] = 1 + len(files)  # and the summary itself
    summary["bytes written"] = sum(path.stat().st_size for path in files)
    write_whole(folder / SUMMARY_FILE, json.dumps(summary, indent=1))  # its presence says that the run has finished


class Account:
    """What a run has used up, and counted, all its parts together.

    Parameters
    ----------
    simulation : Simulation
    checkpoint : Checkpoint or None
        What the run goes on from.
    """

    def __init__(self, simulation, checkpoint):
        self.simulation = simulation
        self.earlier, self.first_step = (checkpoint.totals, checkpoint.step) if checkpoint else ({}, 0)
        self._begin = time.perf_counter(), time.process_time()

    @property
    def wall(self):
        """Time that this part has taken so far [s of the clock]."""
        return time.perf_counter() - self._begin[0]

    def totals(self):
        """Return numbers, and lists and dicts of them, by name; collective."""
        simulation, comm = self.simulation, self.simulation.communicator
        wall, processor = self.wall, time.process_time() - self._begin[1]
        mine = {"cpu [s]": processor, "core seconds": wall, **_counts(simulation)}
        now = reduce(_sum, comm.allgather(mine))
        return _sum(self.earlier, {"parts": 1, "wall [s]": wall, **now})


def _sum(one, other):
    """Return numbers, lists and dicts added, name by name."""
    if isinstance(other, dict):
        return {name: _sum(one[name], other[name]) if name in one else other[name] for name in other}
    return list(map(_sum, one, other)) if isinstance(other, list) else one + other


def _counts(simulation):
    """Return what walls and terms of this rank have counted."""
    domain, counts = simulation.domain, {}
    if domain.ghosts:
        counts["methods"] = domain.ghosts.methods_used.tolist()
    if domain.barrier:
        counts["stopped"] = int(domain.barrier.stopped)
    if domain.exchanging:
        counts["exchanged"] = {wall.name: int(wall.exchanged) for wall in domain.walls}
    if simulation.correction:
        counts["plain"] = int(simulation.correction.plain)
    return counts


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


def _print_start(scene, simulation, folder, name, loading, compiled, checkpoint):
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
    if checkpoint:
        out.print(f"  goes on at t = {checkpoint.time:.6g} s, step {simulation.steps:,}, from {checkpoint.path}")
        if checkpoint.version != __version__:
            out.print(f"note: that was written by parsph {checkpoint.version}; bits may differ from there on")
    for doubt in doubts_of(scene):
        out.print(f"note: {doubt}")


def _print_ranks(simulation):
    slab, p = simulation.domain.slab, simulation.particles
    mine = f"columns {slab.first}:{slab.last}, {len(p.fluid):,} particles, node rank {simulation.communicator.node_rank}"
    lines = simulation.communicator.gather(f"{platform.node()}, {mine}")
    if simulation.communicator.rank == 0:
        for rank, line in enumerate(lines):
            print(f"  rank {rank}: {line}", flush=True)


def _summary(scene, simulation, folder, name, account, particles):
    comm, totals = simulation.communicator, account.totals()
    evaluations = particles * simulation.evaluations
    summary = {
        "scene": name,
        "version": __version__,
        "particles": particles,
        "ranks": comm.size,
        "parts": totals["parts"],
        "time [s]": simulation.time,
        "steps": simulation.steps,
        "wall [s]": totals["wall [s]"],
        "cpu [s]": totals["cpu [s]"],
        "evaluations": evaluations,
        "evaluations per second and rank": evaluations / totals["core seconds"],
        "phases [s]": simulation.timers.over_ranks(comm),
        "folder": str(folder),
    }
    if comm.size > 1:
        summary.update(traffic(simulation, simulation.steps - account.first_step))
    walls = _walls_summary(simulation, totals)
    if walls:
        summary["walls"] = walls
    if simulation.correction:
        summary["kernel correction"] = {"plain kernel per evaluation": totals["plain"] / simulation.evaluations}
    if comm.rank == 0:
        summary.update(wave_heights(scene, simulation))
    return summary


def _walls_summary(simulation, totals):
    """Return what walls are made of and what they did, {} where there is nothing to tell."""
    domain, told = simulation.domain, {}
    if domain.ghosts:
        counts = np.array(totals["methods"]) / simulation.evaluations
        names = ["dry", *(each.name for each in sorted(INTERPOLATORS.values(), key=lambda each: each.code))]
        told["ghosts"] = domain.ghosts.count
        told["methods per evaluation"] = dict(zip(names, counts.tolist(), strict=True))
    if domain.barrier:
        told["stopped"] = totals["stopped"]
    if domain.markers:
        told["markers"] = domain.markers.count
    if domain.exchanging:
        told["exchanged"] = totals["exchanged"]
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


def output_notes(phases):
    """Return what takes more of the time than output should, and its cure, a list of lines.

    Parameters
    ----------
    phases : dict of str to (float, float, float)
        Smallest, mean and largest time over ranks [s], by phase.
    """
    total = sum(mean for _, mean, _ in phases.values())
    means = {phase: phases[phase][1] for phase in RARER if phase in phases}
    return [
        f"note: {phase} take {mean / total:.0%} of the time; a longer {RARER[phase]} would save most of that"
        for phase, mean in means.items()
        if mean > LARGEST_SHARE * total and mean > LEAST
    ]


def _print_end(simulation, summary, wall):
    part = "" if summary["parts"] == 1 else f" of part {summary['parts']}"
    table = phase_table(simulation.timers, simulation.communicator, wall, f"time per phase{part}, in seconds, over ranks")
    if simulation.communicator.rank:
        return
    out = console()
    out.print(table)
    rate = summary["evaluations per second and rank"] / 1e6
    out.print(
        f"{summary['steps']:,} steps, {duration(summary['wall [s]'])}, {rate:.2f} M evaluations/s per core; "
        f"{summary['files']} files, {size_text(summary['bytes written'])} in {summary['folder']}"
    )
    for note in output_notes(summary["phases [s]"]):
        out.print(note)
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
