"""The commands that look at finished runs: folders in, tables and pictures out."""

import itertools
import json
from pathlib import Path

import numpy as np
from rich.markup import escape
from rich.table import Table

from . import analysis, viz
from .errors import SceneError
from .io.results import Results
from .moments import MOMENTS
from .progress import console
from .scene.load import load_scene
from .scene.solids import motions_of

DEVIATIONS = {moment.name for moment in MOMENTS if moment.rank}  # zero where all is well: how far they are off spans decades


def waves(folder, gauges=None, start=0.0, json_file=None):
    """Print mean level, wave height, period and phase at each level gauge.

    Parameters
    ----------
    folder : path
        Of a run.
    gauges : list of str, optional
        Default: all level gauges.
    start : float
        What was before counts not [s].
    json_file : path, optional
        Where the rows go too.
    """
    t, levels, places, names = _levels(Results(folder), gauges, start)
    rows = []
    for name, x, level in zip(names, places, levels, strict=True):
        found = analysis.wave_summary(t, level)
        rows.append(
            {
                "gauge": name,
                "x [m]": float(x),
                "mean level [m]": found.mean,
                "wave height [m]": found.height,
                "period [s]": found.period,
                "phase [rad]": found.phase,
                "waves": found.waves,
            }
        )
    _print(rows, json_file)


def reflection(folder, gauges=None, start=0.0, period=None, periods=4, spectrum=None, json_file=None):
    """Print incident and reflected waves.

    Parameters
    ----------
    folder, gauges, start, json_file
        As `waves`.
    period : float, optional
        [s]; default: the wavemaker's.
    periods : int
        So many at the end of the record count.
    spectrum : tuple of float, optional
        Lowest and highest frequency [Hz] of irregular waves, instead of a period.

    Raises
    ------
    SceneError
        When there is no period, or the gauges do not suit.
    """
    results = Results(folder)
    t, levels, places, _ = _levels(results, gauges, start)
    depth, gravity = results.depth, results.scene["domain"]["gravity"]
    if spectrum:
        found = analysis.reflection_spectrum(t, levels, places, depth, gravity, *spectrum)
        rows = [
            {"frequency [Hz]": f, "incident [m]": a, "reflected [m]": b}
            for f, a, b in zip(found.frequency, found.incident, found.reflected, strict=True)
        ]
        rows.append({"frequency [Hz]": "all", **_energy_sum(found), "reflection coefficient": found.coefficient})
        _print(rows, json_file)
        return
    maker = results.scene["wavemaker"]
    if period is None and maker is None:
        raise SceneError("is missing", "--period", "the scene has no wavemaker", "the period of the waves [s], or --spectrum")
    period = maker["period"] if period is None else period
    method = "goda-suzuki" if len(places) == 2 else "mansard-funke"
    found = analysis.reflection(t, levels, places, period, depth, gravity, method, periods)
    row = {
        "gauges": len(places),
        "period [s]": period,
        "wavelength [m]": 2 * np.pi / found.wavenumber,
        "incident [m]": found.incident,
        "reflected [m]": found.reflected,
        "reflection coefficient": found.coefficient,
        "misfit": found.residual,
    }
    _print([row], json_file)


def _energy_sum(found):
    return {f"{name} [m]": float(np.sqrt(np.sum(getattr(found, name) ** 2))) for name in ("incident", "reflected")}


def ratio(layer, reflecting, infinite, json_file=None):
    """Print the reflection ratio of three 1D shallow-water runs, Molteni et al. eqs. (2.7), (2.8).

    Parameters
    ----------
    layer, reflecting, infinite : path
        Folders of the runs.
    json_file : path, optional
    """
    runs = [Results(folder) for folder in (layer, reflecting, infinite)]
    for run in runs:
        if run.scene["numerics"]["state"] != "shallow":
            raise SceneError("is no shallow water", where=str(run.folder), cure="runs of scenes as swe-pulse")
    times = [run.snapshot()["time"] for run in runs]
    if len(set(times)) > 1:
        told = ", ".join(f"{time:g}" for time in times)
        raise SceneError(f"the runs end at different times, {told} s", where="ratio", cure="the same time.end for all three")
    window = 0.0, runs[1].scene["domain"]["size"][0]
    profiles = [run.profile() for run in runs]
    value = analysis.reflection_ratio(*profiles, runs[0].scene["domain"]["gravity"], window)
    _print([{"time [s]": times[0], "reflection ratio": value}], json_file)


def energy(folder, low=None, high=None, json_file=None):
    """Print the kinetic energy of a region in every snapshot.

    Parameters
    ----------
    folder, json_file
        As `waves`.
    low, high : str, optional
        Corners of the region as "x,z" [m]; default: everything.
    """
    results = Results(folder)
    dim = len(results.scene["domain"]["size"])
    bounds = [_corner(low, dim, -np.inf, "--low"), _corner(high, dim, np.inf, "--high")]
    rows = []
    for number in range(len(results.snapshots)):
        found = results.snapshot(number)
        position, velocity = found["position"][:, :dim], found["velocity"][:, :dim]
        joules = analysis.kinetic_energy(position, velocity, found["mass"], *bounds)
        rows.append({"time [s]": found["time"], "kinetic energy [J]": joules})
    _print(rows, json_file)


def plot(folder, out=None, field="pressure", snapshot=-1):
    """Draw particles and walls, levels, energies, pressures and forces of a run.

    Parameters
    ----------
    folder : path
    out : path, optional
        Where pictures go; default: ``figures`` in the run's folder.
    field : str
        What colours the particles: a field of the snapshot, of a vector its length, of a tensor how far it is from the unit
        matrix; "speed" is the length of the velocity.
    snapshot : int
        Which one.
    """
    results = Results(folder)
    out = Path(out) if out else results.folder / "figures"
    if out.exists() and not out.is_dir():
        raise SceneError(f"{out} is no folder", where="--out", cure="name a folder")
    scene = results.scene
    written = []
    found = results.snapshot(snapshot)
    dim = len(scene["domain"]["size"])
    name = "velocity" if field == "speed" else field
    names = [*(name for name, values in found.items() if np.ndim(values)), "speed"]
    if field not in names:
        raise SceneError(f"no field {field!r} of particles", where="--field", cure=f"one of: {', '.join(names)}")
    values, label = one_number(found[name], field, dim)
    unit = results.units.get(name, "")
    label = f"{label} [{unit}]" if unit else label
    drawing, ax = viz.figure()
    if dim == 1:
        viz.profile(ax, found["position"][:, 0], {field: values}, "x [m]", label)
    else:
        zones = [results.layer(zone) for zone in scene["damping"]]
        for zone in zones or [None]:
            viz.particles(ax, found["position"][:, [0, dim - 1]], values, label, results.level, zone, log=field in DEVIATIONS)
        viz.walls(ax, _walls(results, found["time"]))
    ax.set_title(f"{results.folder.name}, t = {found['time']:.4g} s", fontsize=9)
    written.append(viz.save(drawing, out / f"{field}.png"))
    if results.gauges("level"):
        t, levels, places, _ = results.levels()
        drawing, ax = viz.figure()
        viz.levels(ax, t, levels.T, [f"x = {x:g} m" for x in places])
        written.append(viz.save(drawing, out / "levels.png"))
    for name in results.gauges("energy"):
        table = results.table(name)
        drawing, ax = viz.figure()
        viz.energy(ax, table["time [s]"], {"kinetic": table["kinetic energy [J]"]})
        written.append(viz.save(drawing, out / f"{name}.png"))
    for kind, columns in (("pressure", ["pressure [Pa]"]), ("force", ["force x [N/m]", "force up [N/m]"])):
        for name in results.gauges(kind):
            table = results.table(name)
            drawing, ax = viz.figure()
            curves = {f"{name}, {column.partition(' [')[0]}": table[column] for column in columns}
            viz.profile(ax, table["time [s]"], curves, "t [s]", f"{kind} {columns[0][columns[0].index('[') :]}")
            written.append(viz.save(drawing, out / f"{name}.png"))
    for path in written:
        console().print(str(path), markup=False)


def one_number(values, name, dim):
    """Return one number per particle, shape (n,), and what to call it: of a scalar itself, of a vector, shape (n, 3), its
    length, of a tensor, shape (n, 9), the Frobenius norm of what it lacks of the unit matrix.
    """
    if values.ndim == 1:
        return values, name
    if values.shape[1] == 3:
        return np.linalg.norm(values, axis=1), name if name == "speed" else f"|{name}|"
    unit_matrix = np.diag(np.arange(3) < dim).astype(float)
    return np.linalg.norm(values - unit_matrix.ravel(), axis=1), f"|{name} - 1|"


def _levels(results, gauges, start):
    t, levels, places, names = results.levels(gauges)
    late = t >= start
    if not late.any():
        raise SceneError(f"{start:g} s is after the end of the record", where="--start", cure=f"less than {t[-1]:g} s")
    return t[late], levels[:, late], places, names


def _corner(text, dim, default, where):
    if text is None:
        return np.full(dim, default)
    try:
        corner = [float(part) for part in text.split(",")]
    except ValueError:
        corner = []
    if len(corner) != dim:
        raise SceneError(f"{text!r} is not {dim} numbers", where=where, cure="as 0,0" if dim == 2 else "numbers with commas")
    return np.array(corner)


def _print(rows, json_file):
    if json_file and not json_file.parent.is_dir():
        raise SceneError(f"there is no folder {json_file.parent}", where="--json", cure="name a file in a folder that is there")
    columns = list(dict.fromkeys(name for row in rows for name in row))
    table = Table(*map(escape, columns))
    for row in rows:
        table.add_row(*(f"{row[name]:.5g}" if isinstance(row.get(name), float) else str(row.get(name, "")) for name in columns))
    console().print(table)
    if json_file:
        json_file.write_text(json.dumps(rows, indent=1), encoding="utf-8")


def _walls(results, time):
    """Return the polygon walls where they stand at `time` [s], each of shape (n, 2) [m]."""
    lines = []
    scene = load_scene(results.scene)
    motions = motions_of(scene)
    for name, wall in zip(scene.wall_names, scene.lines, strict=True):
        points, motion = np.array(wall.points, float), motions.get(name)
        if wall.fluid in ("inside", "outside"):
            points = np.vstack([points, points[:1]])
        if wall.bulge is not None:  # straight at rest
            parts = np.linspace(0.0, 1.0, 41)[:, None]
            points = np.concatenate([(1 - parts) * a + parts * b for a, b in itertools.pairwise(points)])
        lines.append(points if motion is None else motion.at(time).place(points))
    return lines
