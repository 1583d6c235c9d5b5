"""Mirror walls: the fluid near a plane is reflected at it.

Two laws for what an image carries (`water-waves`, Szmidt Fig. 1 and 2):

- plain: density and pressure of the particle it mirrors;
- hydrostatic: pressure raised by ``rho (g - a_w) . (x_image - x)``, density from the inverse state equation, so that water
  at rest stays at rest (a_w: acceleration of the wall).

Free slip reflects the velocity relative to the wall's local velocity, ``v - 2 [(v - v_w) . n] n``; no slip is
``2 v_w - v``. Walls are taken in turn, and each mirrors the images of those before it too: corners come of themselves. An
image that lies beyond a later wall is dropped, since that wall's own images fill the place.

A palette is mirrored along the bed, not along its normal: an image has the height of its original. Reflected squarely, the
images of a plate that leans by theta would leave a wedge of 2 theta at the hinge empty, or fill it twice, and the corner
would suck particles in; mirrored along the bed, the line of the bed maps onto itself. Both maps keep volumes.
"""

from dataclasses import dataclass, field

import numpy as np

from ..columns import DROPPED, cell_of
from ..jit import jit
from ..particles import FIRST_GHOST
from ..states import density_of

PLAIN, HYDROSTATIC = range(2)
LAWS = {"plain": PLAIN, "hydrostatic": HYDROSTATIC}
FREE_SLIP, NO_SLIP = range(2)
SLIPS = {"free": FREE_SLIP, "no": NO_SLIP}


@jit
def wall_images(
    rows, tags, cells, close, close_count, first_ghost, end, dim, wall, law, slip, bit, gravity, state, grid, reach
):
    """Append the images of all particles within `reach` of a wall.

    Parameters
    ----------
    rows, tags, cells : ndarray
        Particle arrays; images are written from row `end` on.
    close, close_count : ndarray of int32, int
        The fluid rows that may be near a wall.
    first_ghost, end : int
        The images that earlier walls made are the rows ``first_ghost:end``.
    wall : ndarray, shape (5 * dim + 2,)
        Point, normal into the fluid, velocity and acceleration of the point, direction of mirroring, then rate [1/s] and
        acceleration [1/s^2] of the rotation from the first to the last axis.
    law, slip, bit : int
        Law, slip and the wall's bit in the image number.
    gravity, state, grid : tuple
        [m/s^2]; constants of the state; (low, 1/cell, shape, first cell of the slab).
    reach : float
        Distance up to which particles have images [m].

    Returns
    -------
    tuple of int
        (end of the images, first fluid row beyond the wall or -1)
    """
    low, inverse, shape, first_cell = grid
    up = dim - 1
    rate, spin = wall[5 * dim], wall[5 * dim + 1]
    ghosts = end - first_ghost
    bad = -1
    for k in range(close_count + ghosts):
        i = close[k] if k < close_count else first_ghost + k - close_count
        if cells[i] < 0:
            continue
        distance = 0.0
        for d in range(dim):
            distance += (rows[i, d] - wall[d]) * wall[dim + d]
        if distance < 0.0:
            if tags[i] < FIRST_GHOST:
                bad = i
                break
            cells[i] = DROPPED
            continue
        if distance >= reach:
            continue
        slant = 0.0
        for d in range(dim):
            slant += wall[dim + d] * wall[4 * dim + d]
        head = 0.0
        slip_speed = 0.0
        for d in range(dim):
            arm = 0.0
            if dim > 1 and d == 0:
                arm = -(rows[i, up] - wall[up])
            elif dim > 1 and d == up:
                arm = rows[i, 0] - wall[0]
            # the wall's motion where the particle touches it
            wall_velocity = wall[2 * dim + d] + rate * arm
            wall_acceleration = wall[3 * dim + d] + spin * arm - rate * rate * (rows[i, d] - wall[d])
            way = -2.0 * distance / slant * wall[4 * dim + d]
            rows[end, d] = rows[i, d] + way
            rows[end, dim + d] = wall_velocity
            slip_speed += (rows[i, dim + d] - wall_velocity) * wall[dim + d]
            head += way * (gravity[d] - wall_acceleration)
        for d in range(dim):
            if slip == NO_SLIP:
                rows[end, dim + d] = 2.0 * rows[end, dim + d] - rows[i, dim + d]
            else:
                rows[end, dim + d] = rows[i, dim + d] - 2.0 * slip_speed * wall[dim + d]
        density, pressure = rows[i, 2 * dim], rows[i, 2 * dim + 1]
        if law == HYDROSTATIC:
            pressure += density * head
            density = density_of(pressure, state)
        rows[end, 2 * dim] = density
        rows[end, 2 * dim + 1] = pressure
        rows[end, 2 * dim + 2] = rows[i, 2 * dim + 2]
        tags[end] = tags[i] + bit * FIRST_GHOST
        cells[end] = cell_of(rows, end, low, inverse, shape) - first_cell
        end += 1
    return end, bad


@dataclass
class MirrorWall:
    """A plane that mirrors the fluid, at rest or moved by a wavemaker.

    Attributes
    ----------
    name : str
        "left", "right", "bottom", "top", ...
    point, normal : tuple of float
        A point of the plane [m] and its normal into the fluid.
    law, slip : str
        "plain" or "hydrostatic"; "free" or "no".
    bit : int
        The wall's bit in the image number, a power of two.
    motion : Palette, optional
        What turns the wall about `point`.
    """

    name: str
    point: tuple
    normal: tuple
    law: str
    slip: str
    bit: int
    motion: object = None
    numbers: np.ndarray = field(init=False, repr=False)

    def __post_init__(self):
        dim = len(self.point)
        self.numbers = np.zeros(5 * dim + 2)
        self.numbers[:dim] = self.point
        self.numbers[dim : 2 * dim] = self.normal
        self.numbers[4 * dim : 5 * dim] = self.normal

    def move(self, time):
        """Put the wall where it is at `time` [s]."""
        if self.motion is None:
            return
        dim = len(self.point)
        now = self.motion.at(time)
        # leaning towards +x is a rotation from the last axis to the first: negative
        c, s = np.cos(now.angle), np.sin(now.angle)
        first, last = self.normal[0], self.normal[-1]
        self.numbers[dim] = c * first + s * last
        self.numbers[2 * dim - 1] = c * last - s * first
        self.numbers[5 * dim] = -now.rate
        self.numbers[5 * dim + 1] = -now.acceleration

    @property
    def codes(self):
        """(law, slip, bit) as the compiled code knows them."""
        return LAWS[self.law], SLIPS[self.slip], self.bit

    def distance(self, position):
        """Return how far `position` [m] is in front of the wall [m], negative behind it."""
        dim = len(self.point)
        with np.errstate(invalid="ignore"):  # asked of particles that got lost, at infinity too
            return float((np.asarray(position) - self.numbers[:dim]) @ self.numbers[dim : 2 * dim])

    def band(self, reach, height):
        """Return the box, (low, high) tuples, in which particles may come within `reach` of the wall [m].

        `height` is how far above its hinge a moving wall is wetted at the most [m].
        """
        swing = self.motion.reach(height) if self.motion else 0.0
        lows, highs = [], []
        for x, n in zip(self.point, self.normal, strict=True):
            lows.append(x - swing - reach if n else -np.inf)
            highs.append(x + swing + reach if n else np.inf)
        return tuple(lows), tuple(highs)
