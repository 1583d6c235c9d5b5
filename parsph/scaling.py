"""Strong and weak scaling: the tank of `parsph bench`, whole steps, on the numbers of ranks that are given.

Each number of ranks is a job of its own, started here; jobs take turns, so that what else the machine does hits all alike.
Of a job the fastest block of steps counts, of all turns the median; speed-ups are ratios within a turn. Ranks beyond the cores
at hand count messages, bytes and memory, but no time.
"""

import csv
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

from rich.table import Table

from . import parallel, viz
from .bench import bench_scene, jittered
from .domain import imbalance
from .errors import RunError, SceneError
from .io.folder import output_folder, write_whole
from .progress import console
from .run import load_code
from .scene.forecast import forecast
from .scene.plan import SECONDS_PER_STEP

H_OVER_DX, PRECISION = 1.7, "float64"
WARM_UP, STEPS, BLOCKS = 5, 10, 4
FORMS = {
    "kind": "{}",
    "ranks": "{}",
    "particles": "{:,}",
    "s/step": "{:.3g}",
    "expected s/step": "{:.3g}",
    "speed-up": "{:.2f}",
    "efficiency": "{:.0%}",
    "waiting": "{:.1%}",
    "imbalance": "{:.3f}",
    "messages": "{:g}",
    "expected messages": "{:g}",
    "bytes": "{:,.0f}",
    "expected bytes": "{:,.0f}",
    "memory": "{:,.0f}",
    "expected memory": "{:,.0f}",
    "resident": "{:,.0f}",
}
TABLES = {
    "time": ("s/step", "expected s/step", "speed-up", "efficiency", "waiting"),
    "sent in a step by the rank with the most [bytes]": ("messages", "expected messages", "bytes", "expected bytes"),
    "particles of all; memory of the rank with the most [bytes]; largest over mean cost": (
        "particles",
        "memory",
        "expected memory",
        "resident",
        "imbalance",
    ),
}


def scaling(ranks=None, particles=200_000, repeats=5, out=None):
    """Measure, print and write strong and weak scaling, beside what `parsph plan --ranks` expects.

    Parameters
    ----------
    ranks : sequence of int, optional
        By default 1, 2, 4 ... up to the cores at hand; 1 is always among them.
    particles : int
        Of strong scaling; for weak scaling each rank has that over the largest number of ranks that there are cores for.
    repeats : int
        Turns.
    out : path, optional
        Folder; default ``bench/scaling-<NNN>``.

    Returns
    -------
    list of dict
        The rows of the table.

    Raises
    ------
    SceneError
        When it is started on several ranks, or there are too many for the columns.
    RunError
        When a job fails.
    """
    if parallel.launched_ranks() > 1:
        cure = "parsph bench --scaling --ranks 1,2, without mpirun"
        raise SceneError("bench --scaling starts its ranks itself", where="mpirun", cure=cure)
    cores = len(os.sched_getaffinity(0))
    ranks = sorted({1, *(ranks or (2**k for k in range(cores.bit_length())))})
    each = particles // max(number for number in ranks if number <= cores)
    cases = [(kind, number) for kind in ("strong", "weak") for number in ranks]
    sizes = {case: (particles, 1) if case[0] == "strong" else (each, case[1]) for case in cases}
    for case, size in sizes.items():
        forecast(bench_scene(*_scene_keys(size)), case[1])  # too many ranks are told before anything is measured
    folder = output_folder("scaling", out, parent="bench")
    shown, jobs = console(), {case: [] for case in cases}
    for turn in range(repeats):
        for case in cases:
            if case[1] > cores and jobs[case]:
                continue  # what counts does not change
            jobs[case].append(_job(case[1], *sizes[case], BLOCKS if case[1] <= cores else 1))
            found = jobs[case][-1]
            shown.print(f"turn {turn + 1} of {repeats}: {case[0]}, {case[1]} rank(s): {found['step']:.3g} s/step")
    rows = [_row(*case, jobs, sizes[case], case[1] > cores) for case in cases]
    _write(folder, rows, jobs, cores)
    _print(rows, jobs, folder)
    return rows


def ranks_of(text):
    """Return the numbers of ranks in a list such as "1,2,4", None without a text; SceneError when it is none."""
    if text is None:
        return None
    numbers = text.split(",")
    if not all(number.strip().isdecimal() and int(number) > 0 for number in numbers):
        raise SceneError(f"{text!r} is no list of numbers of ranks", where="--ranks", cure="as 1,2,4")
    return [int(number) for number in numbers]


def _scene_keys(size):
    return size[0], H_OVER_DX, PRECISION, size[1]


def _job(ranks, particles, squares, blocks):
    """Start a job on so many ranks and return what it has measured."""
    with tempfile.TemporaryDirectory() as place:
        told = Path(place) / "told.json"
        command = parallel.python_command("-m", "parsph.scaling", told, particles, squares, blocks, ranks=ranks)
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode:
            raise RunError(f"a job on {ranks} ranks failed", where="bench --scaling", why=done.stderr.strip()[-500:])
        return json.loads(told.read_text(encoding="utf-8"))


def measure(communicator, particles, squares, blocks):
    """Step the tank of so many squares on all ranks; collective.

    Returns
    -------
    dict
        Of the fastest block: "step", time of a step [s], and "waiting", that for halos, mean over ranks [s]; the same of
        blocks that wait before they sweep, "step without overlap" and "waiting without overlap". Of a step: "messages" and
        "bytes" that the rank with the most sends. "imbalance" of the cost. "memory" of the arrays and "resident" memory,
        largest [bytes].
    """
    scene = bench_scene(*_scene_keys((particles, squares)))
    load_code(scene, communicator)
    simulation = jittered(scene, communicator, speed=0.0)  # in time some of what moves at random would leave
    for _ in range(WARM_UP):
        simulation.advance()
    domain, exchange = simulation.domain, simulation.domain.exchange
    before, steps, halo_at_once = (exchange.messages, exchange.bytes), simulation.steps, _at_once(domain)
    fastest = {}
    for _ in range(blocks):
        for name, start_halo in (("", domain.start_halo), (" without overlap", halo_at_once)):
            domain.start_halo, usual = start_halo, domain.start_halo
            step, waiting = _block(simulation)
            domain.start_halo = usual
            if step < fastest.get(f"step{name}", float("inf")):
                fastest |= {f"step{name}": step, f"waiting{name}": waiting}
    counts = zip(*communicator.allgather((exchange.messages - before[0], exchange.bytes - before[1])), strict=True)
    messages, sent = (max(count) / (simulation.steps - steps) for count in counts)
    with simulation.present():
        share = imbalance(domain.column_costs(), domain.cuts)
    memory = simulation.particles.nbytes, 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    arrays, resident = (max(sizes) for sizes in zip(*communicator.allgather(memory), strict=True))
    return {
        **fastest,
        "particles": sum(communicator.allgather(len(simulation.particles.fluid))),
        "messages": messages,
        "bytes": sent,
        "imbalance": share,
        "memory": arrays,
        "resident": resident,
        "load": os.getloadavg()[0],
    }


def _at_once(domain):
    """Return a `start_halo` that waits: what it costs more is what overlap hides."""
    start = domain.start_halo

    def start_and_finish():
        start()
        domain.finish_halo()

    return start_and_finish


def _block(simulation):
    """Make some steps; return the time of one, and that of waiting for halos in it, mean over ranks [s]."""
    seconds, communicator = simulation.timers.seconds, simulation.communicator
    waited = seconds.get("halo", 0.0)
    communicator.barrier()
    begin = time.perf_counter()
    for _ in range(STEPS):
        simulation.advance()
    mine = time.perf_counter() - begin, seconds.get("halo", 0.0) - waited
    spent, waiting = zip(*communicator.allgather(mine), strict=True)
    return max(spent) / STEPS, sum(waiting) / len(waiting) / STEPS


def _row(kind, ranks, jobs, size, oversubscribed):
    """Return the row of a case: medians over turns, and what was expected."""
    alone, mine = jobs[kind, 1], jobs[kind, ranks]

    def median(name):
        return statistics.median(job[name] for job in mine)

    step = statistics.median(job["step"] for job in alone)
    whole = SECONDS_PER_STEP + (step - SECONDS_PER_STEP) * size[1]  # of the whole tank on one rank
    expected = forecast(bench_scene(*_scene_keys(size)), ranks, step=whole)
    row = {"kind": kind, "ranks": ranks, "particles": mine[0]["particles"]}
    if oversubscribed:
        row |= dict.fromkeys(("s/step", "expected s/step", "speed-up", "efficiency", "waiting"))
    else:
        ratio = statistics.median(one["step"] / many["step"] for one, many in zip(alone, mine, strict=True))
        row |= {
            "s/step": median("step"),
            "expected s/step": expected.step,
            "speed-up": ratio * size[1],
            "efficiency": ratio * size[1] / ranks,
            "waiting": median("waiting") / median("step"),
        }
    return row | {
        "imbalance": median("imbalance"),
        "messages": median("messages"),
        "expected messages": expected.messages[1],
        "bytes": median("bytes"),
        "expected bytes": expected.bytes[1],
        "memory": median("memory"),
        "expected memory": expected.memory,
        "resident": median("resident"),
    }


def _write(folder, rows, jobs, cores):
    with open(folder / "scaling.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, FORMS)
        table.writeheader()
        table.writerows(rows)
    raw = [{"kind": kind, "ranks": ranks, "turns": turns} for (kind, ranks), turns in jobs.items()]
    write_whole(folder / "scaling.json", json.dumps({"cores": cores, "rows": rows, "jobs": raw}, indent=1))
    if find_spec("matplotlib") is None:
        console().print("no plot: matplotlib is not installed (pip install 'parsph[plots]')")
        return
    drawing, axes = viz.figure(columns=2)
    for ax, kind, name in zip(axes, ("strong", "weak"), ("speed-up", "efficiency"), strict=True):
        timed = [row for row in rows if row["kind"] == kind and row["s/step"] is not None]
        numbers = [row["ranks"] for row in timed]
        theory = {
            "expected": [timed[0]["s/step"] / row["expected s/step"] for row in timed],
            "ideal": numbers if kind == "strong" else [1.0] * len(numbers),
        }
        measured = {f"{kind}, measured": [row[name] for row in timed]}
        viz.against(ax, numbers, measured, "ranks", f"{name} [-]", log_y=False, theory=theory)
    viz.save(drawing, folder / "scaling.png")


def _print(rows, jobs, folder):
    shown = console()
    for title, names in TABLES.items():
        table = Table("", *names, title=title, title_justify="left", pad_edge=False)
        for row in rows:
            told = ("-" if row[name] is None else FORMS[name].format(row[name]) for name in names)
            table.add_row(f"{row['kind']}, {row['ranks']}", *told)
        shown.print(table)
    if any(row["s/step"] is None for row in rows):
        shown.print("-: no time, since the ranks are oversubscribed: more than there are cores")
    for row in rows:
        if row["ranks"] > 1 and row["s/step"] is not None:
            turns = jobs[row["kind"], row["ranks"]]
            names = "waiting", "waiting without overlap"
            with_overlap, without = (1e3 * statistics.median(job[name] for job in turns) for name in names)
            shown.print(
                f"{row['kind']}, {row['ranks']} ranks: {with_overlap:.2f} ms of a step wait for halos, {without:.2f} ms where "
                "nothing is swept meanwhile"
            )
    shown.print(f"table and plot: {folder}")


def main(arguments):
    """Measure one case on the ranks of this job; rank 0 writes what it found to a file."""
    file, *numbers = arguments
    communicator = parallel.start()
    parallel.end_job_on_error(communicator)
    found = measure(communicator, *map(int, numbers))
    communicator.on_root(lambda: write_whole(Path(file), json.dumps(found)))


if __name__ == "__main__":
    main(sys.argv[1:])
