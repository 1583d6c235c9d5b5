"""The command line, thin: each command calls one function of the package."""

import os
import sys
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Annotated

import typer

from . import __version__, parallel
from .errors import ParsphError, SceneError, paragraph
from .parallel import Communicator

app = typer.Typer(
    add_completion=False,
    no_args_is_help=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="Smoothed-particle hydrodynamics for numerical wave tanks, serial or on any number of MPI ranks.\n\n"
    "Without a command the built-in scene **pool** runs.  Parallel: `mpirun -n 4 python -m parsph run SCENE`.\n\n"
    "Exit codes: 0 done, 1 the run failed, 2 bad input (nothing was written), 85 stopped with a checkpoint by a signal or "
    "its wall time (`parsph resume` goes on), 130 interrupted.",
)

SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="Built-in scene (see `parsph list`) or a TOML file.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Override a key, as `time.end=5` or `gauges.0.x=2`. Repeatable."),
]
RanksInfo = Annotated[bool, typer.Option("--ranks-info", help="Print what each rank owns.")]
Walltime = Annotated[
    str | None,
    typer.Option(metavar="[D-]H:M:S", help="Or seconds: stop before so long by the clock, with a checkpoint and exit code 85."),
]
RunFolder = Annotated[Path, typer.Argument(metavar="DIR", help="Output folder of a run.")]
JsonFile = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the results to FILE as JSON.")]


def _show_version(wanted: bool):
    if wanted:
        print(f"parsph {__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def _default(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print it.")] = False,
):
    if context.invoked_subcommand is None:
        run("pool", [])


@app.command()
def run(
    scene: SceneName = "pool",
    set_: Settings = None,
    out: Annotated[Path | None, typer.Option(help="Output folder. Default: runs/SCENE-NNN, the next free number.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Empty --out of an earlier run first.")] = False,
    walltime: Walltime = None,
    ranks_info: RanksInfo = False,
):
    """Run a scene: snapshots, gauge tables, checkpoints and a summary go to the output folder."""
    from .run import run as run_scene

    run_scene(scene, _with_walltime(set_, walltime), out, overwrite, ranks_info)


@app.command()
def resume(folder: RunFolder, set_: Settings = None, walltime: Walltime = None, ranks_info: RanksInfo = False):
    """Go on with a run from its newest checkpoint, on any number of ranks, to the same bits as if it had not been stopped.

    A run that has finished goes on to a later end: `--set time.end=60`. Without a checkpoint it begins anew.
    """
    from .run import resume as resume_run

    resume_run(folder, _with_walltime(set_, walltime), ranks_info)


def _with_walltime(settings, walltime):
    return (settings or []) + ([f'time.walltime="{walltime}"'] if walltime else [])


@app.command("list")
def list_scenes():
    """List the built-in scenes."""
    from .progress import console
    from .scene.load import builtin_names, load_scene

    names = builtin_names()
    for name in names:
        console().print(f"{name:{max(map(len, names))}s}  {load_scene(name).title}")


@app.command()
def check(scene: SceneName, set_: Settings = None):
    """Check a scene and print all its faults at once, and what may not be what is wanted."""
    from .scene.check_waves import doubts_of
    from .scene.load import load_scene

    for doubt in doubts_of(load_scene(scene, set_)):
        print(f"note: {doubt}")
    print(f"{scene}: no faults")


@app.command()
def plan(
    scene: SceneName = "pool",
    set_: Settings = None,
    ranks: Annotated[int | None, typer.Option(min=1, help="What it will need on up to so many ranks as well.")] = None,
):
    """Print what a scene will model, with equations and sources, what it leaves out, and what it will cost."""
    from .scene.load import load_scene
    from .scene.plan import print_plan

    declared = load_scene(scene, set_)
    print_plan(declared, scene)
    if ranks:
        from .scene.forecast import print_forecast

        print_forecast(declared, ranks)


@app.command()
def show(
    scene: SceneName = "pool",
    set_: Settings = None,
    schema: Annotated[bool, typer.Option("--schema", help="The JSON Schema of scenes instead, for editors.")] = False,
):
    """Print a scene with all defaults filled in, as JSON."""
    from .scene.load import json_schema, load_scene, scene_text

    print(json_schema() if schema else scene_text(load_scene(scene, set_)))


@app.command()
def study(
    name: Annotated[str | None, typer.Argument(metavar="STUDY", help="Built-in study or a TOML file; none: list them.")] = None,
    set_: Settings = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Rows at a time. Default: as many as there are cores for.")] = None,
    ranks: Annotated[int, typer.Option(min=1, help="MPI ranks of each row.")] = 1,
    resume: Annotated[bool, typer.Option("--resume", help="Go on in --out; finished rows are not run again.")] = False,
    out: Annotated[Path | None, typer.Option(help="Folder. Default: studies/STUDY-NNN, the next free number.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Its small size: minutes on two cores.")] = False,
    row: Annotated[str | None, typer.Option(help="Run this row alone (number or name), as a task of a job array.")] = None,
    list_: Annotated[bool, typer.Option("--list", help="Print the rows and what they cost, and run nothing.")] = False,
):
    """Run a matrix of scenes: one folder a row, one table, figures, a report.

    Failed rows are recorded and do not stop the others. After an interruption go on with `--resume --out FOLDER`.
    """
    from .study import command

    if name is None:
        command.print_studies()
    elif list_:
        command.print_rows(name, set_, quick)
    else:
        command.study(name, set_, jobs, ranks, resume, out, quick, row)


analyse = typer.Typer(no_args_is_help=True, help="Analyse finished runs: waves, spectra, reflection, decay, energies.")
app.add_typer(analyse, name="analyse")

GaugeNames = Annotated[list[str] | None, typer.Option("--gauge", help="Level gauges to use; default: all. Repeatable.")]
Start = Annotated[float, typer.Option(help="Leave out what was before this time [s].")]
Period = Annotated[float | None, typer.Option(help="Period [s]. Default: the wavemaker's.")]
Periods = Annotated[int, typer.Option(min=1, help="So many periods at the end count.")]


@analyse.command("waves")
def analyse_waves(folder: RunFolder, gauge: GaugeNames = None, start: Start = 0.0, json_file: JsonFile = None):
    """Mean level, wave height, period and phase at each level gauge, by zero up-crossings."""
    from .examine import waves

    waves(folder, gauge, start, json_file)


@analyse.command("reflection")
def analyse_reflection(
    folder: RunFolder,
    gauge: GaugeNames = None,
    start: Start = 0.0,
    period: Period = None,
    periods: Periods = 4,
    spectrum: Annotated[
        tuple[float, float] | None, typer.Option(metavar="LOW HIGH", help="Irregular waves between these frequencies [Hz].")
    ] = None,
    json_file: JsonFile = None,
):
    """Incident and reflected waves from level gauges: two after Goda & Suzuki, three or more after Mansard & Funke."""
    from .examine import reflection

    reflection(folder, gauge, start, period, periods, spectrum, json_file)


@analyse.command("spectrum")
def analyse_spectrum(
    folder: RunFolder,
    gauge: GaugeNames = None,
    start: Start = 0.0,
    band: Annotated[
        tuple[float, float] | None, typer.Option(metavar="LOW HIGH", help="Frequencies that count [Hz]. Default: all.")
    ] = None,
    segments: Annotated[
        int | None, typer.Option(min=1, help="Lengths to cut the record in. Default: of ten waves, eight at most.")
    ] = None,
    json_file: JsonFile = None,
):
    """Statistics of irregular waves at each level gauge: heights, periods and spectrum, drawn in DIR/figures."""
    from .examine import spectrum

    spectrum(folder, gauge, start, band, segments, json_file)


@analyse.command("harmonics")
def analyse_harmonics(
    folder: RunFolder,
    gauge: GaugeNames = None,
    start: Start = 0.0,
    period: Period = None,
    count: Annotated[int, typer.Option(min=1, help="Number of harmonics.")] = 3,
    periods: Periods = 4,
    json_file: JsonFile = None,
):
    """Harmonics of regular waves along the tank, bound and free second harmonic, decay beside that of the viscosity.

    Gauges should stand two depths from the wavemaker or more; those in absorbing layers count for the first table alone.
    """
    from .examine import harmonics

    harmonics(folder, gauge, start, period, count, periods, json_file)


@analyse.command("ratio")
def analyse_ratio(
    layer: Annotated[Path, typer.Argument(help="Run with the layer.")],
    reflecting: Annotated[Path, typer.Argument(help="Run with a wall instead.")],
    infinite: Annotated[Path, typer.Argument(help="Run whose end is too far away to matter.")],
    json_file: JsonFile = None,
):
    """Reflection ratio of three 1D shallow-water runs at their end, Molteni et al. eqs. (2.7), (2.8)."""
    from .examine import ratio

    ratio(layer, reflecting, infinite, json_file)


@analyse.command("energy")
def analyse_energy(
    folder: RunFolder,
    low: Annotated[str | None, typer.Option(metavar="X,Z", help="Lower corner of the region [m].")] = None,
    high: Annotated[str | None, typer.Option(metavar="X,Z", help="Upper corner of the region [m].")] = None,
    json_file: JsonFile = None,
):
    """Kinetic energy of a region in every snapshot."""
    from .examine import energy

    energy(folder, low, high, json_file)


@analyse.command("books")
def analyse_books(folder: RunFolder, json_file: JsonFile = None):
    """Energy books: the change of all energies, and what viscosity, diffusion and all else (walls, shifting) gave or took.

    Needs a gauge of energy and one of power.
    """
    from .examine import books

    books(folder, json_file)


@app.command()
def plot(
    folder: RunFolder,
    out: Annotated[Path | None, typer.Option(help="Folder for the pictures. Default: DIR/figures.")] = None,
    field: Annotated[str, typer.Option(help="What colours the particles: pressure, density, speed, ...")] = "pressure",
    snapshot: Annotated[int, typer.Option(help="Which snapshot; -1 is the last.")] = -1,
):
    """Draw a run: particles coloured by a field, levels at the gauges, energies against time."""
    from .examine import plot as plot_run

    plot_run(folder, out, field, snapshot)


@app.command()
def waves(
    depth: Annotated[float, typer.Option(help="Still-water depth [m].")],
    height: Annotated[float | None, typer.Option(help="Wave height [m].")] = None,
    period: Annotated[float | None, typer.Option(help="Period [s].")] = None,
    frequency: Annotated[float | None, typer.Option(help="Frequency [Hz], instead.")] = None,
    wavelength: Annotated[float | None, typer.Option(help="Wavelength [m], instead.")] = None,
    gravity: Annotated[float, typer.Option(help="Gravity [m/s^2].")] = 9.81,
    solitary: Annotated[bool, typer.Option("--solitary", help="A solitary wave of that height.")] = False,
):
    """Print what theory says of a wave: lengths, speeds, limits, what paddles need; of a solitary one also what a wall gets."""
    from rich.table import Table

    from .progress import console
    from .waves import describe, describe_solitary

    if solitary:
        if height is None or {period, frequency, wavelength} != {None}:
            why = "a solitary wave has a height and neither period nor length"
            raise SceneError("needs --height alone", "--solitary", why, "parsph waves --solitary --depth 1 --height 0.2")
        rows = describe_solitary(depth, gravity, height)
    else:
        rows = describe(depth, gravity, height, period, frequency, wavelength)
    table = Table("quantity", "value", "unit")
    for quantity, value, unit in rows:
        table.add_row(quantity, value if isinstance(value, str) else f"{value:.5g}", unit)
    console().print(table)


@app.command()
def bench(
    json_file: JsonFile = None,
    particles: Annotated[
        int | None, typer.Option(min=1000, help="Default: 100,000; with --scaling and --output 200,000.")
    ] = None,
    repeats: Annotated[int, typer.Option(min=1, help="The fastest of so many counts; with the options below the median.")] = 7,
    scaling: Annotated[bool, typer.Option("--scaling", help="Strong and weak scaling over ranks instead.")] = False,
    ranks: Annotated[str | None, typer.Option(metavar="N,...", help="Of --scaling. Default: 1, 2, 4 ... cores.")] = None,
    output: Annotated[bool, typer.Option("--output", help="How fast snapshots and checkpoints are written instead.")] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder of --scaling, by default bench/scaling-NNN; of --output, by default this one.")
    ] = None,
):
    """Measure the speed of the neighbour loop and of a whole step on one core, against a textbook loop.

    With --scaling: whole steps on several ranks, which it starts itself, in a table and a plot.  With --output: files, on the
    ranks that mpirun starts.
    """
    if scaling:
        from .scaling import ranks_of
        from .scaling import scaling as run_scaling

        run_scaling(ranks_of(ranks), particles or 200_000, repeats, out)
        return
    if output:
        from .throughput import throughput

        throughput(particles or 200_000, repeats, json_file, out)
        return
    from .bench import bench as run_bench

    run_bench(json_file, particles or 100_000, repeats)


@app.command()
def stability(
    quick: Annotated[bool, typer.Option("--quick", help="Three cells: one of each integrator.")] = False,
    jobs: Annotated[int | None, typer.Option(min=1, help="Cells at a time. Default: as many as there are cores for.")] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on in --out; cells in its table are not measured again.")
    ] = False,
    out: Annotated[Path | None, typer.Option(help="Folder. Default: stability/map-NNN, the next free number.")] = None,
):
    """Measure the stability map: the largest CFL with which a violent and a calm flow stay stable, by bisection.

    For each integrator, against h/dx, diffusion and viscosity; a table and a plot.
    """
    from .stability import stability as run_stability

    run_stability(quick, jobs, resume, out)


@app.command()
def verify(
    cases: Annotated[list[str] | None, typer.Argument(metavar="[CASE]...", help="Cases; default: all.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Shorter runs, same metrics and bars where they apply.")] = False,
    json_file: JsonFile = None,
):
    """Run validation cases against theory; exit 1 if a bar is missed."""
    from .verify import verify as run_verify

    if not run_verify(cases, quick, json_file):
        raise typer.Exit(1)


def main(arguments=None):
    """Run the command line; end the whole job, on all ranks, with the exit code of the first failure."""
    communicator = Communicator()
    try:
        communicator = parallel.start()
        parallel.end_job_on_error(communicator)
        with _quiet(communicator.rank > 0):
            # not `app(arguments)`: that would replace the hook that ends the job
            typer.main.get_command(app)(arguments)
    except ParsphError as error:
        _fail(communicator, paragraph(error), error.exit_code, error.alike)
    except KeyboardInterrupt:
        _fail(communicator, "interrupted", 130)
    except SystemExit as end:
        if end.code not in (None, 0, 2):  # else the other ranks would wait for this one for ever
            _fail(communicator, "", end.code)
        raise


@contextmanager
def _quiet(quiet):
    """Let rank 0 alone talk; errors of other ranks are written past this."""
    if not quiet:
        yield
        return
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
        yield


def _fail(communicator, message, code, alike=False):
    """Say why and end the job. Of what all ranks find alike, bad input above all, rank 0 speaks for them."""
    if message and (communicator.rank == 0 or not alike):
        print(message, file=sys.__stderr__, flush=True)
    if communicator.size > 1 and not alike:
        communicator.abort(code)
    sys.exit(code)
