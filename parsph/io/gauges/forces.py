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
        self.motion, self.about = motion, np.asarray(about, float)

    def measure(self, simulation):
        points, normals = self.points, self.normals
        if self.motion is not None:
            now = self.motion.at(simulation.time)
            points, normals = now.place(points), now.turn(normals, points)
        pressures = pressures_at(simulation, points)
        if simulation.communicator.rank:
            return ()
        push = -(pressures * self.lengths)[:, None] * normals
        arm = points - self.about
        parts = np.column_stack([push, arm[:, 0] * push[:, 1] - arm[:, 1] * push[:, 0]])
        return tuple(column_sums(parts, np.array([0, len(parts)]))[0])
