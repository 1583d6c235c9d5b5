"""Force of the fluid on a wall."""

import numpy as np

from .base import Gauge, column_sums
from .pressures import pressures_at


class ForceGauge(Gauge):
    """Force and moment of the fluid's pressure on a wall, per metre of width: ``F = -sum p n dl`` over its pieces.

    Parameters
    ----------
    points, normals, lengths : ndarray, shapes (n, 2), (n, 2), (n,)
        Pieces of the wall: midpoints [m], normals into the fluid, lengths [m].
    motion : Swing or None
        What moves them.
    about : tuple of float
        What the moment is taken about [m]; counter-clockwise is positive.
    """

    columns = ("force x [N/m]", "force up [N/m]", "moment [N]")

    def __init__(self, name, every, points, normals, lengths, motion, about, folder=None):
        super().__init__(name, every, folder)
        self.points, self.normals, self.lengths = points, normals, lengths
        self.motion, self.about = motion, about

    def measure(self, simulation):
        surface = self.points, self.normals, self.lengths
        return tuple(force_on(simulation, *surface, self.motion, simulation.time, self.about))


def force_on(simulation, points, normals, lengths, motion, time, about=(0.0, 0.0)):
    """Return force [N/m], two components, and moment [N] of the fluid's pressure on a wall on rank 0, else nothing; collective.

    Parameters
    ----------
    points, normals, lengths, motion, about
        As of `ForceGauge`.
    time : float
        When the wall is where it is looked for [s].
    """
    if motion is not None:
        now = motion.at(time)
        points, normals = now.place(points), now.turn(normals, points)
    pressures = pressures_at(simulation, points)
    if simulation.communicator.rank:
        return np.zeros(0)
    push = -(pressures * lengths)[:, None] * normals
    arm = points - np.asarray(about)
    parts = np.column_stack([push, arm[:, 0] * push[:, 1] - arm[:, 1] * push[:, 0]])
    return column_sums(parts, np.array([0, len(parts)]))[0]


class BodyGauge(Gauge):
    """Force on a wall that the flow moves, its way, speed and acceleration, and the work of the force.

    Parameters
    ----------
    body : MovableWall
    """

    columns = ("force [N/m]", "displacement [m]", "velocity [m/s]", "acceleration [m/s^2]", "work [J/m]")

    def __init__(self, name, every, body, folder=None):
        super().__init__(name, every, folder)
        self.body = body

    def measure(self, simulation):
        return self.body.state
