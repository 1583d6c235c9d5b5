"""What snapshots say: the reflection ratio of shallow water, the energy of a region."""

import numpy as np

from .. import analysis
from ..errors import SceneError
from ..io.results import Results
from .tables import show


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
    show([{"time [s]": times[0], "reflection ratio": value}], json_file)


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
    show(rows, json_file)


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
