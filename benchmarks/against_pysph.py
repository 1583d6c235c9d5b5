"""parsph beside PySPH, in one run: speed on a dam break, error against cost on a stretching drop, memory and start-up.

    python benchmarks/against_pysph.py --python /path/to/python-with-pysph

Both codes run PySPH's own examples on one core, each in a process of its own, in turns; of repeats the fastest counts. They may
live in different environments. Caches of compiled code begin empty, so that what compiling takes is measured too.

Ends with 0 when it has measured, 77 when there is no PySPH to measure against, 2 for bad input, 1 when a code fails.
"""

import argparse
import csv
import json
import math
import os
import platform
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from rich.table import Table

import parsph
from parsph import viz
from parsph.errors import ParsphError, RunError, SceneError, paragraph
from parsph.flows import StretchingDrop
from parsph.io.folder import output_folder, write_whole
from parsph.jit import processor
from parsph.progress import console

HERE = Path(__file__).parent
CODES = "parsph", "PySPH"
SKIPPED = 77  # as test harnesses know it
RATE, STRETCHED = 100.0, 0.0075  # A of PySPH's drop [1/s], and when A t = 0.75 [s]
DROPS = {  # series: code, method
    "parsph": ("parsph", "parsph"),
    "parsph, PySPH's method": ("parsph", "PySPH"),
    "PySPH": ("PySPH", "PySPH"),
    "PySPH, parsph's kernel and h/dx": ("PySPH", "parsph"),
}
DIFFERENCES = (
    "walls: parsph mirrors particles, of which none is stepped or evaluated; PySPH has four rows of fixed particles, whose "
    "densities are evaluated",
    "dam break: both Wendland C2, h/dx = 1.3, alpha = 0.1, XSPH 0.5, c0 = 10 sqrt(2 g H), Tait, CFL = 0.3; PySPH's h follows "
    "the density, parsph's water begins with its hydrostatic pressure, PySPH's without",
    "integrator, evaluations a step: dam break parsph Verlet 1, PySPH PEC 1; drop parsph Adams-Bashforth 1 (PySPH's method: "
    "midpoint 2), PySPH EPEC 2",
    "precision: float64 in both; numba compiles for this processor, PySPH by its defaults (-O3) for any",
    "drop, own methods: parsph Wendland C2, h/dx = 2, renormalised divergence, density diffusion, no viscosity; PySPH "
    "Gaussian, h/dx = 1.3, alpha = 0.1, XSPH 0.5; both c0 = 14 A R",
    "drop, its lattice: a particle in the middle where it is PySPH's, half a spacing beside it where it is parsph's",
)


@dataclass(frozen=True)
class Sizes:
    """How much is measured.

    Attributes
    ----------
    dx : float
        Of the dam break [m].
    developed : float
        When its flow counts as developed [s].
    window : float
        What is timed in one turn [s of the flow].
    windows : int
        How many, at the start and in the developed flow.
    radii : tuple of int
        Particles per radius of the drop.
    finer : tuple of int
        More of them for parsph's own method, to cost as much as the others.
    turns : int
        Repeats of the drop, and of warm starts.
    memory : (float, float)
        dx of two dam breaks whose memories are compared [m].
    """

    dx: float = 0.02
    developed: float = 0.6  # a while before the front meets the far wall
    window: float = 0.02
    windows: int = 5
    radii: tuple = (10, 20, 40)
    finer: tuple = (80, 170)
    turns: int = 2
    memory: tuple = (0.05, 0.004)


QUICK = Sizes(0.05, 0.1, 0.01, 2, (10, 20), (40,), 1, (0.05, 0.005))


class Side:
    """A code that runs one flow, in a process of its own, as far as it is told; a context manager.

    Parameters
    ----------
    code : str
        One of `CODES`.
    settings : dict
        Of the flow.
    bench : Bench
    """

    def __init__(self, code, settings, bench):
        self.code = code
        self._log = tempfile.TemporaryFile("w+", dir=bench.home)  # noqa: SIM115 - open as long as the process
        script = HERE / f"{code.lower()}_side.py"
        command = [bench.pythons[code], str(script), json.dumps(settings)]
        # one thread each; caches, homes and temporary files where they are removed
        places = dict.fromkeys(("HOME", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "TMPDIR"), str(bench.home))
        paths = os.pathsep.join(filter(None, (str(HERE.parent), os.environ.get("PYTHONPATH"))))
        environment = os.environ | places | {"OMP_NUM_THREADS": "1", "PYTHONPATH": paths}
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": self._log, "text": True}
        self._process = subprocess.Popen(command, env=environment, **pipes)

    def advance(self, to):
        """Go on to the time `to` [s] and return what `serving.serve` answers; RunError when the process has ended instead."""
        try:
            print(to, file=self._process.stdin, flush=True)
            answer = self._process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if not answer:
            code = self._process.wait()  # negative: the number of the signal that ended it
            self._log.seek(0)
            raise RunError(f"has ended too early, with {code}", where=self.code, why=self._log.read().strip()[-500:])
        return json.loads(answer)

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind:
            self._process.kill()
        self._process.communicate()
        self._log.close()


class Bench:
    """Everything that is measured.

    Parameters
    ----------
    pythons : dict
        Interpreter by code.
    home : Path
        An empty folder for caches and temporary files.
    sizes : Sizes
    say : callable
        Told what is going on.
    """

    def __init__(self, pythons, home, sizes, say):
        self.pythons, self.home, self.sizes, self.say = pythons, home, sizes, say

    def starts(self):
        """Return {case: {code: (cold, warm)}}, wall time from nothing to the end of a first step [s]; fills the caches.

        Only the first case finds them empty; later ones find what they share with those before.
        """
        cases = {"dam break": {"case": "dam break", "dx": self.sizes.memory[0]}}
        for method in CODES:
            cases[f"drop, method of {method}"] = {"case": "drop", "per radius": 10, "method": method}
        found = {name: {} for name in cases}
        for turn in range(1 + self.sizes.turns):
            for name, settings in cases.items():
                for code in CODES:
                    begin = time.perf_counter()
                    with Side(code, settings, self) as side:
                        side.advance(1e-7)
                        found[name].setdefault(code, []).append(time.perf_counter() - begin)
                    self.say(f"start {turn}, {name}, {code}: {found[name][code][-1]:.1f} s")
        return {
            name: {code: (seconds[0], min(seconds[1:])) for code, seconds in by_code.items()} for name, by_code in found.items()
        }

    def dam_break(self):
        """Return {code: {stage: answers}} of the timed windows, in turns: at the start, and in the developed flow."""
        sizes, found = self.sizes, {code: {} for code in CODES}
        settings = {"case": "dam break", "dx": sizes.dx}
        with ExitStack() as stack:
            sides = [stack.enter_context(Side(code, settings, self)) for code in CODES]
            for stage, begin in (("start", sizes.window), ("developed", sizes.developed)):
                for side in sides:
                    found[side.code][f"before {stage}"] = [side.advance(begin)]
                for window in range(1, sizes.windows + 1):
                    for side in sides:
                        answer = side.advance(begin + window * sizes.window)
                        found[side.code].setdefault(stage, []).append(answer)
                        rate = answer["fluid"] * answer["evaluations"] / answer["CPU [s]"]
                        self.say(
                            f"dam break, {stage}, window {window}, {side.code}: {rate / 1e6:.3f} M evaluations/s of the fluid"
                        )
        return found

    def memory(self):
        """Return {code: bytes per fluid particle}, the growth of the peak memory from a small dam break to a large one."""
        found = {}
        for code in CODES:
            answers = []
            for dx in self.sizes.memory:
                with Side(code, {"case": "dam break", "dx": dx}, self) as side:
                    answers.append(side.advance(1e-7))
            small, large = answers
            more = {name: large[name] - small[name] for name in ("peak memory [bytes]", "fluid")}
            found[code] = more["peak memory [bytes]"] / more["fluid"]
            self.say(f"memory, {code}: {found[code]:.0f} bytes per fluid particle, {large['fluid']:,} of them")
        return found

    def drops(self):
        """Return the rows of the drop: series, resolution, particles, evaluations, cost, error; one for each run, in turns."""
        sizes, best = self.sizes, {}
        runs = [(series, per_radius) for per_radius in sizes.radii for series in DROPS]
        runs += [("parsph", per_radius) for per_radius in sizes.finer]
        for turn in range(sizes.turns):
            for run in runs:
                row = self._drop(*run)
                self.say(f"drop, turn {turn + 1}, {run[0]}, {run[1]} per radius: {row['cost']:.3g} s, error {row['error']:.2e}")
                if run not in best or row["cost"] < best[run]["cost"]:
                    best[run] = row
        return [best[run] for run in sorted(best, key=lambda run: (list(DROPS).index(run[0]), run[1]))]

    def _drop(self, series, per_radius):
        code, method = DROPS[series]
        with Side(code, {"case": "drop", "per radius": per_radius, "method": method}, self) as side:
            start, end = side.advance(1e-7), side.advance(STRETCHED)
        errors = axis_errors(start["half axes [m]"], end["half axes [m]"])
        return {
            "series": series,
            "per radius": per_radius,
            "particles": end["fluid"],
            "evaluations": start["evaluations"] + end["evaluations"],
            "cost": start["CPU [s]"] + end["CPU [s]"],
            "short half axis": errors[0],
            "long half axis": errors[1],
            "error": max(map(abs, errors)),
        }


def axis_errors(start, end):
    """Return the relative errors of the short and the long half axis of the drop [-].

    Parameters
    ----------
    start, end : (float, float)
        Half axes along x and y [m], those of ellipses with the second moments of the particles. How they grow is compared, so
        that it does not matter how well a lattice fills a circle.
    """
    _, *theory = StretchingDrop((-1.0, -1.0), (1.0, 1.0), RATE, 1.0).at(STRETCHED)
    return [after / before / exact - 1 for before, after, exact in zip(start, end, theory, strict=True)]


def at_cost(cost, costs, errors):
    """Return the error that costs `cost`, between the points of a series by its logarithms; nan beyond its ends."""
    order = np.argsort(costs)
    x, y = np.log(np.asarray(costs)[order]), np.log(np.asarray(errors)[order])
    return float(np.exp(np.interp(math.log(cost), x, y, left=np.nan, right=np.nan)))


def equal_cost(rows):
    """Return, for each row of PySPH's, its series, resolution, cost and error, and parsph's error at that cost."""
    own = [row for row in rows if row["series"] == "parsph"]
    costs, errors = [row["cost"] for row in own], [row["error"] for row in own]
    return [
        {
            **{name: row[name] for name in ("series", "per radius", "cost", "error")},
            "parsph's error": at_cost(row["cost"], costs, errors),
        }
        for row in rows
        if DROPS[row["series"]][0] == "PySPH"
    ]


def summary(starts, flows, memory):
    """Return the rows of the table: (quantity, unit, parsph's, PySPH's)."""
    rows = []

    def add(quantity, unit, number):
        rows.append((quantity, unit, *map(number, CODES)))

    def rate(stage, which):
        return lambda code: max(a[which] * a["evaluations"] / a["CPU [s]"] for a in flows[code][stage]) / 1e6

    def last(name, scale=1.0, stage="developed"):
        return lambda code: flows[code][stage][-1][name] * scale

    add("dam break: particles of the fluid", "", last("fluid"))
    add("particles in an evaluation", "", last("particles"))
    for stage in ("start", "developed"):
        add(f"{stage}: evaluations of the fluid", "M/s per core", rate(stage, "fluid"))
        add(f"{stage}: evaluations of all particles", "M/s per core", rate(stage, "particles"))
        add(f"{stage}: evaluations in a window", "", last("evaluations", stage=stage))
        add(f"{stage}: CPU time of a window", "s", lambda code, stage=stage: min(a["CPU [s]"] for a in flows[code][stage]))
        add(f"{stage}: front at its beginning", "m", last("front [m]", stage=f"before {stage}"))
    add("peak resident memory", "MB", last("peak memory [bytes]", 1e-6))
    add("memory per particle of the fluid", "bytes", memory.get)
    for name, by_code in starts.items():
        for k, state in enumerate(("cold", "warm")):
            add(f"{state} start, {name}", "s", lambda code, by_code=by_code, k=k: by_code[code][k])
    return rows


def show(rows, drops, equal, shown):
    """Print the tables."""
    table = Table("", "unit", *CODES, "parsph/PySPH", title="ratios are of minima", title_justify="left")
    for quantity, unit, ours, theirs in rows:
        table.add_row(quantity, unit, f"{ours:.4g}", f"{theirs:.4g}", f"{ours / theirs:.3g}" if theirs else "-")
    shown.print(table)
    table = Table("series", "per radius", "particles", "evaluations", "CPU [s]", "short half axis", "long half axis")
    table.title = "drop at A t = 0.75: errors of its half axes"
    for row in drops:
        errors = (f"{100 * row[name]:+.3f} %" for name in ("short half axis", "long half axis"))
        counts = (f"{row[name]:,}" for name in ("per radius", "particles", "evaluations"))
        table.add_row(row["series"], *counts, f"{row['cost']:.3g}", *errors)
    shown.print(table)
    table = Table("series", "per radius", "CPU [s]", "its error", "parsph's error", "its/parsph's", title="error at equal cost")
    for row in equal:
        ratio, ours = row["error"] / row["parsph's error"], row["parsph's error"]
        told = ["-", "-"] if math.isnan(ours) else [f"{100 * ours:.3f} %", f"{ratio:.2f}"]
        table.add_row(row["series"], str(row["per radius"]), f"{row['cost']:.3g}", f"{100 * row['error']:.3f} %", *told)
    shown.print(table)
    for line in DIFFERENCES:
        shown.print(f"- {line}")


def plot(drops, path):
    """Draw error against cost of the drop."""
    drawing, ax = viz.figure()
    points = [(str(row["per radius"]), row["cost"], row["error"], row["series"]) for row in drops]
    viz.error_against_cost(ax, points, xlabel="CPU time [s]", ylabel="error of a half axis [-]")
    viz.save(drawing, path)


def write(folder, rows, drops, equal, **more):
    """Write the tables, everything as JSON, and the plot where there is matplotlib."""
    with open(folder / "peers.csv", "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("quantity", "unit", *CODES), *rows])
    with open(folder / "drop.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, drops[0])
        table.writeheader()
        table.writerows(drops)
    named = [dict(zip(("quantity", "unit", *CODES), row, strict=True)) for row in rows]
    told = {"rows": named, "drop": drops, "equal cost": equal, "differences": DIFFERENCES, **more}
    write_whole(folder / "peers.json", json.dumps(told, indent=1))
    if find_spec("matplotlib") is not None:
        plot(drops, folder / "drop.png")


def pysph_in(python):
    """Return {library: version} of the environment of an interpreter, None where it has no PySPH.

    Raises
    ------
    SceneError
        When it is no interpreter.
    """
    libraries = "PySPH", "compyle", "Cython", "numpy"
    code = (
        f"import json, pysph; from importlib.metadata import version; print(json.dumps({{n: version(n) for n in {libraries}}}))"
    )
    try:
        done = subprocess.run([python, "-c", code], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    except OSError as error:
        raise SceneError(f"cannot be run: {error.strerror}", where=f"--python {python}", cure="a Python with pysph") from None
    return json.loads(done.stdout) if done.returncode == 0 else None


def main(arguments=None):
    """Measure, print and write; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", default=sys.executable, help="interpreter with pysph; default: this one")
    parser.add_argument("--out", type=Path, help="folder for tables and plot; default: bench/peers-<NNN>")
    parser.add_argument("--quick", action="store_true", help="small flows: to see that it works, not to be quoted")
    given = parser.parse_args(arguments)
    shown = console()
    theirs = pysph_in(given.python)
    if theirs is None:
        shown.print(f"not measured: pysph is not installed in {given.python} (pip install pysph, which needs a C++ compiler)")
        return SKIPPED
    folder = output_folder("peers", given.out, parent="bench")
    ours = {"parsph": parsph.__version__} | {name: version(name) for name in ("numba", "numpy")}
    versions = {"parsph": ours, "PySPH": theirs, "python": platform.python_version(), "processor": processor()}
    sizes = QUICK if given.quick else Sizes()
    with tempfile.TemporaryDirectory(prefix="peers-") as home:
        bench = Bench(dict(zip(CODES, (sys.executable, given.python), strict=True)), Path(home), sizes, shown.print)
        starts = bench.starts()
        flows, memory, drops = bench.dam_break(), bench.memory(), bench.drops()
    rows, equal = summary(starts, flows, memory), equal_cost(drops)
    write(folder, rows, drops, equal, versions=versions, sizes=vars(sizes), windows=flows)
    show(rows, drops, equal, shown)
    shown.print(f"parsph {ours['parsph']}, PySPH {theirs['PySPH']}, {versions['processor']}; tables and plot: {folder}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except ParsphError as error:
        print(paragraph(error), file=sys.stderr)
        sys.exit(error.exit_code)
