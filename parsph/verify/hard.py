"""What hard cases share: runs that may end early, and their books of energy and momentum."""

from contextlib import suppress

import numpy as np

from ..analysis import energy_books
from ..errors import RunError
from ..io.gauges import EnergyGauge, PowerGauge
from .runs import built


def survived(source, overrides=(), observers=()):
    """Run a scene as far as it goes, with more observers than it names.

    Returns
    -------
    tuple of (Scene, Simulation)
        Where the run failed, the simulation stands where it did: see `missing`.
    """
    scene, simulation = built(source, overrides)
    simulation.observers += observers
    with suppress(RunError):  # how far it got is a result
        simulation.run()
    return scene, simulation


def missing(simulation):
    """Yield the row that says how much of a run is missing."""
    yield "part of the run that is missing", 100 * (1 - simulation.time / simulation.end), "%", 0.0


def record_of(simulation, kind):
    """Return the record of the first gauge of a class."""
    return next(gauge.record() for gauge in simulation.observers if isinstance(gauge, kind))


def energy_rows(simulation, scale=None, bar=None):
    """Yield the rows of the energy books, over `scale` [J], by default the energy at the beginning."""
    energy, power = record_of(simulation, EnergyGauge), record_of(simulation, PowerGauge)
    books, unit = energy_books(energy, power), "% of the energy at the beginning" if scale is None else "% of the wave's energy"
    scale = energy[0, 2:5].sum() if scale is None else scale
    for name, values in (
        ("energy, change", books.change),
        ("energy, from viscosity", books.viscosity),
        ("energy, from diffusion", books.diffusion),
        ("energy, from all else", books.rest),
    ):
        yield name, 100 * values[-1] / scale, unit, None
    yield "energy, not accounted for, largest", 100 * np.abs(books.open).max() / scale, unit, bar


def momentum_of(simulation):
    """Return momentum, shape (2,) [kg m/s], and angular momentum about the centre of mass [kg m^2/s] of a flow in the plane."""
    position, velocity, mass = (simulation.field(name) for name in ("position", "velocity", "mass"))
    x, y = (position - mass @ position / mass.sum()).T
    return mass @ velocity, float(mass @ (x * velocity[:, 1] - y * velocity[:, 0]))


def momentum_row(simulation):
    """Yield the row of the momentum of a flow that began without any and that nothing holds."""
    speed = np.linalg.norm(simulation.field("velocity"), axis=1)
    momentum, _ = momentum_of(simulation)
    yield "momentum", np.abs(momentum).max() / (simulation.field("mass") @ speed), "of the sum of all", 1e-9
