"""Differences between runs, as energies and as levels, and the energy of a region.

Source: Molteni et al., for the reflection ratio of absorbing layers.
"""

import math

import numpy as np

from ..errors import SceneError
from .records import record_of, time_mean


def energy_difference(depth, velocity, mass, depth_reference, velocity_reference, gravity):
    """Return the energy [m^4/s^2] of the difference of two shallow-water runs, per unit of width and density.

    ``E = sum V_i [g/2 (H - H_ref)^2 + H/2 (v - v_ref)^2]``, ``V_i = m_i / H_ref``: Molteni et al. eq. (2.8), the integrals as
    sums over the same particles.

    Parameters
    ----------
    depth, velocity, mass : ndarray, shape (n,)
        H [m], v [m/s] and m [m^2] (depth times length) of the particles.
    depth_reference, velocity_reference : ndarray, shape (n,)
        The same particles in the reference run.
    gravity : float
        [m/s^2]
    """
    potential = 0.5 * gravity * (depth - depth_reference) ** 2
    kinetic = 0.5 * depth * (velocity - velocity_reference) ** 2
    return float(np.sum(mass / depth_reference * (potential + kinetic)))


def reflection_ratio(layer, reflecting, infinite, gravity, window):
    """Return the reflection ratio of an absorbing layer, ``R = sqrt(E_layer / E_reflecting)``, Molteni et al. eq. (2.7).

    Both energies are differences from the infinite run (`energy_difference`) at the same time, over the particles that all
    three runs have and that lie in the window in the infinite one.

    Parameters
    ----------
    layer, reflecting, infinite : mapping of str to ndarray, shape (n,)
        "id", "position" [m], "density" (the depth H [m]), "velocity" [m/s] and "mass" [m^2] of one-dimensional runs with the
        layer, with a wall in its place, and with an end too far away to matter. In any order, with n of their own.
    gravity : float
        [m/s^2]
    window : tuple of (float, float)
        Lower and upper end [m], both included.

    Raises
    ------
    SceneError
        When an array is not of shape (n,), no particle is common, or the reflecting run equals the infinite one.
    """
    for name, run in (("layer", layer), ("reflecting", reflecting), ("infinite", infinite)):
        for key in ("position", "density", "velocity", "mass"):
            if run[key].shape != (run["id"].size,):
                raise SceneError(
                    f"{key} has shape {run[key].shape} for {run['id'].size} particles",
                    where=f"{name} run",
                    why="the ratio is one of one-dimensional shallow-water runs",
                    cure="give each array one number per particle",
                )
    low, high = window
    common = infinite["id"][(infinite["position"] >= low) & (infinite["position"] <= high)]
    common = np.intersect1d(np.intersect1d(common, layer["id"]), reflecting["id"])
    if not common.size:
        raise SceneError(
            f"no particle of all three runs lies from {low:g} to {high:g} m",
            where="reflection ratio",
            why="particles are compared one by one, by their id",
            cure="take runs of the same initial particles and a window that they are in",
        )

    def taken(run):
        order = np.argsort(run["id"])
        rows = order[np.searchsorted(run["id"], common, sorter=order)]
        return run["density"][rows], run["velocity"][rows], run["mass"][rows]

    depth, velocity, _ = taken(infinite)
    of_layer = energy_difference(*taken(layer), depth, velocity, gravity)
    of_reflecting = energy_difference(*taken(reflecting), depth, velocity, gravity)
    if of_reflecting == 0:
        raise SceneError(
            f"the reflecting run equals the infinite one from {low:g} to {high:g} m",
            where="reflection ratio",
            why="there is no reflection yet that the layer's could be compared with",
            cure="take a later time, when the reflected wave is back in the window",
        )
    return math.sqrt(of_layer / of_reflecting)


def kinetic_energy(position, velocity, mass, low, high):
    """Return the kinetic energy of the particles in a box, ``sum m v^2 / 2`` over ``low <= position < high``.

    Parameters
    ----------
    position, velocity : ndarray, shape (n, dim)
        [m], [m/s]
    mass : ndarray, shape (n,)
        [kg] in three dimensions, [kg/m] in two; the energy is in [J] or [J/m].
    low, high : array_like, shape (dim,)
        Corners of the box [m]; infinite ones are welcome.
    """
    inside = np.all((position >= low) & (position < high), axis=1)
    return float(0.5 * np.sum(mass[inside, None] * velocity[inside] ** 2))


def level_difference(t, levels, reference):
    """Return the relative L2 difference of gauge records, over all gauges and times.

    ``sqrt(mean (levels - reference)^2) / sqrt(mean (reference - its mean over time)^2)``, each sample weighted by the time it
    stands for.

    Parameters
    ----------
    t : array_like, shape (samples,)
        Times [s] of both.
    levels, reference : array_like, shape (gauges, samples)
        [m]

    Raises
    ------
    SceneError
        When shapes differ or the reference stands still.
    """
    if np.shape(levels) != np.shape(reference) or np.ndim(reference) != 2:
        raise SceneError(
            f"levels have shape {np.shape(levels)}, the reference {np.shape(reference)}",
            where="gauges",
            why="both must be (gauges, samples), with the same gauges and times",
            cure="cut or interpolate one to the other",
        )
    t, levels = record_of(t, levels)
    t, reference = record_of(t, reference)
    if not np.ptp(reference, axis=1).any():
        raise SceneError(
            "the reference stands still",
            where="gauges",
            why="a difference relative to its motion has no meaning",
            cure="take a reference run with waves, or a longer record",
        )
    motion = reference - time_mean(t, reference)[:, None]
    return float(np.sqrt(time_mean(t, (levels - reference) ** 2).mean() / time_mean(t, motion**2).mean()))
