"""Pictures of a run: its particles and walls, its records."""

import itertools
from pathlib import Path

import numpy as np

from .. import viz
from ..errors import SceneError
from ..io.results import Results
from ..moments import MOMENTS
from ..progress import console
from ..scene.load import load_scene
from ..scene.solids import motions_of

DEVIATIONS = {moment.name for moment in MOMENTS if moment.rank}  # zero where all is well: how far they are off spans decades


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
        weightless = scene["domain"]["gravity"] == 0 or "up" in scene["domain"]["periodic"]
        level = None if weightless else results.level
        for zone in zones or [None]:
            viz.particles(ax, found["position"][:, [0, dim - 1]], values, label, level, zone, log=field in DEVIATIONS)
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
    records = {
        "pressure": ["pressure [Pa]"],
        "force": ["force x [N/m]", "force up [N/m]"],
        "runup": ["run-up z [m]"],
    }
    for kind, columns in records.items():
        for name in results.gauges(kind):
            table = results.table(name)
            drawing, ax = viz.figure()
            curves = {f"{name}, {column.partition(' [')[0]}": table[column] for column in columns}
            viz.profile(ax, table["time [s]"], curves, "t [s]", f"{kind} {columns[0][columns[0].index('[') :]}")
            written.append(viz.save(drawing, out / f"{name}.png"))
    for name in results.gauges("body"):
        written.append(viz.save(_body(results, name), out / f"{name}.png"))
    for path in written:
        console().print(str(path))


def _body(results, name):
    """Draw the force on a body over its first value, that of still water, and the way of the body, one over the other."""
    table = results.table(name)
    t, force, way = (table[column] for column in ("time [s]", "force [N/m]", "displacement [m]"))
    first = force[np.flatnonzero(force)[0]] if force.any() else 1.0
    drawing, (above, below) = viz.figure(rows=2, share_x=True)
    viz.profile(above, t, {name: force / first}, "", "force over that of still water [-]")
    viz.profile(below, t, {name: way}, "t [s]", "displacement [m]")
    return drawing


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


def _walls(results, time):
    """Return the polygon walls where they stand at `time` [s], each of shape (n, 2) [m]."""
    lines = []
    scene = load_scene(results.scene)
    motions = motions_of(scene)
    ways = {gauge["wall"]: results.table(name) for name, gauge in results.gauges("body").items()}
    for name, wall in zip(scene.wall_names, scene.lines, strict=True):
        points, motion = np.array(wall.points, float), motions.get(name)
        if wall.fluid in ("inside", "outside"):
            points = np.vstack([points, points[:1]])
        if wall.bulge is not None:  # straight at rest
            parts = np.linspace(0.0, 1.0, 41)[:, None]
            points = np.concatenate([(1 - parts) * a + parts * b for a, b in itertools.pairwise(points)])
        if name in ways:  # where the flow has moved it is known from its record alone
            t, way = (ways[name][column] for column in ("time [s]", "displacement [m]"))
            points = points + np.interp(time, t, way) * np.array(motion.direction)
        elif motion is not None:
            points = motion.at(time).place(points)
        lines.append(points)
    return lines
