"""Mirror walls: the fluid near a plane is reflected at it.

Two laws for what an image carries (`water-waves`, Szmidt Fig. 1 and 2):

- plain: density and pressure of the particle it mirrors;
- hydrostatic: pressure raised by ``rho (g - a_w) . (x_image - x)``, density from the inverse state equation, so that water
  at rest stays at rest (a_w: acceleration of the wall).

Free slip reflects the velocity relative to the wall's local velocity, ``v - 2 [(v - v_w) . n] n``; no slip is
``2 v_w - v``. Walls are taken in turn, and each mirrors the images of those before it too: corners come of themselves. An
image that lies beyond a later wall is dropped, since that wall's own images fill the place.

What particles carry from one evaluation to the next is reflected with the field that it is of. Smoothing is a velocity that the
wall has none of; a density is even there, so its gradient is reflected as an arrow is. For the strain rate D
(`parsph.terms.viscosity`) let R be the reflection and n the normal: the velocity gradient of the image is ``R G R`` at free
slip, so its strain rate is ``R D R``: the shear ``n . D . t`` changes its sign. At no slip it is ``-G R``: what derives along
the normal continues, what derives along the wall changes its sign, and vanishes at the wall, whether that is at rest or moves
in its plane. D does not tell the two parts of its shear from each other; as the one along the wall vanishes there, all of it
continues. At a wall that turns, both hold in the frame of the wall, from which D differs by no more than the velocity does: by
a rotation, which has no strain rate.

Exchange: a fluid particle that got behind a wall changes places with its image (Szmidt 2013): position and
velocity are reflected, at the beginning of the step too, since integrators go on from there; what it carries as well. Its
density stays.

A flap is mirrored along the bed, not along its normal: an image has the height of its original. Reflected squarely, the
images of a plate that leans by theta would leave a wedge of 2 theta at the hinge empty, or fill it twice, and the corner
would suck particles in; mirrored along the bed, the line of the bed maps onto itself. Both maps keep volumes. For the same
reason two walls one above the other, the flap and the sill below its hinge, mirror each what is at their own heights.
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
def distance_of(rows, i, column, wall, dim):
    """How far the place in row `i`, from `column` on, is in front of the wall [m]."""
    distance = 0.0
    for d in range(dim):
        distance += (rows[i, column + d] - wall[d]) * wall[dim + d]
    return distance


@jit
def in_span(rows, i, wall, dim):
    """Whether row `i` is at a height at which the wall is."""
    return wall[5 * dim + 2] <= rows[i, dim - 1] < wall[5 * dim + 3]


@jit
def slant_of(wall, dim):
    """How far one goes along the normal on a unit of way in the direction of mirroring."""
    slant = 0.0
    for d in range(dim):
        slant += wall[dim + d] * wall[4 * dim + d]
    return slant


@jit
def arm_of(rows, i, d, wall, dim):
    """What the rate of rotation is multiplied with in component `d` of the wall's velocity where row `i` is [m]."""
    up = dim - 1
    if dim > 1 and d == 0:
        return -(rows[i, up] - wall[up])
    if dim > 1 and d == up:
        return rows[i, 0] - wall[0]
    return 0.0


@jit
def reflect_velocity(source, i, column, to, rows, at, dim, wall, slip):
    """Write to row `to` of `source` the velocity in row `i`, from `column` on, as the wall reflects it at the place of `at`."""
    rate = wall[5 * dim]
    slip_speed = 0.0
    for d in range(dim):
        wall_velocity = wall[2 * dim + d] + rate * arm_of(rows, at, d, wall, dim)
        slip_speed += (source[i, column + d] - wall_velocity) * wall[dim + d]
    for d in range(dim):
        if slip == NO_SLIP:
            wall_velocity = wall[2 * dim + d] + rate * arm_of(rows, at, d, wall, dim)
            source[to, column + d] = 2.0 * wall_velocity - source[i, column + d]
        else:
            source[to, column + d] = source[i, column + d] - 2.0 * slip_speed * wall[dim + d]


@jit
def strain_place(a, b, dim):
    """Column of the component (a, b) in the upper triangle of a symmetric tensor, row by row."""
    low, high = min(a, b), max(a, b)
    return low * dim - low * (low - 1) // 2 + high - low


@jit
def reflect_vector(rows, i, to, column, dim, wall):
    """Write to row `to` the vector in row `i`, from `column` on, as the wall reflects it."""
    along = 0.0
    for d in range(dim):
        along += rows[i, column + d] * wall[dim + d]
    for d in range(dim):
        rows[to, column + d] = rows[i, column + d] - 2.0 * along * wall[dim + d]


@jit
def reflect_carried(rows, i, to, dim, wall, slip, carried):
    """Write to row `to` what the image of row `i` carries, in columns from `carried` on, which are -1 where there is none."""
    strain_rate, smoothing, density_gradient = carried
    if density_gradient >= 0:
        reflect_vector(rows, i, to, density_gradient, dim, wall)
    if smoothing >= 0:
        if slip == NO_SLIP:
            for d in range(dim):
                rows[to, smoothing + d] = -rows[i, smoothing + d]
        else:
            reflect_vector(rows, i, to, smoothing, dim, wall)
    if strain_rate >= 0:
        # Dn = D . n, nDn = n . D . n; free slip R D R = D - 2 (n Dn + Dn n) + 4 nDn n n, no slip D - 2 P D P with P = 1 - n n
        Dx, Dy, Dz, nDn = 0.0, 0.0, 0.0, 0.0
        for b in range(dim):
            n = wall[dim + b]
            Dx += rows[i, strain_rate + strain_place(0, b, dim)] * n
            if dim > 1:
                Dy += rows[i, strain_rate + strain_place(1, b, dim)] * n
            if dim > 2:
                Dz += rows[i, strain_rate + strain_place(2, b, dim)] * n
        Dn = (Dx, Dy, Dz)
        for a in range(dim):
            nDn += Dn[a] * wall[dim + a]
        sign, twice = (-1.0, 2.0) if slip == NO_SLIP else (1.0, 4.0)
        for a in range(dim):
            for b in range(a, dim):
                column = strain_rate + strain_place(a, b, dim)
                sheared = 2.0 * (wall[dim + a] * Dn[b] + wall[dim + b] * Dn[a])
                rows[to, column] = sign * (rows[i, column] - sheared + twice * nDn * wall[dim + a] * wall[dim + b])


@jit
def wall_images(
    rows,
    tags,
    cells,
    close,
    close_count,
    first_ghost,
    end,
    dim,
    wall,
    law,
    slip,
    bit,
    gravity,
    state,
    grid,
    reach,
    carried,
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
    wall : ndarray, shape (5 * dim + 4,)
        Point, normal into the fluid, velocity and acceleration of the point, direction of mirroring, then rate [1/s] and
        acceleration [1/s^2] of the rotation from the first to the last axis, and the heights between which it mirrors [m].
    law, slip, bit : int
        Law, slip and the wall's bit in the image number.
    gravity, state, grid : tuple
        [m/s^2]; constants of the state; (low, 1/cell, shape, first cell of the slab).
    reach : float
        Distance up to which particles have images [m].
    carried : tuple of int
        First columns of what rows carry, -1 where they carry none, see `parsph.particles.Layout.carried`.

    Returns
    -------
    tuple of int
        (end of the images, first fluid row beyond the wall or -1)
    """
    low, inverse, shape, first_cell = grid
    rate, spin = wall[5 * dim], wall[5 * dim + 1]
    slant = slant_of(wall, dim)
    ghosts = end - first_ghost
    bad = -1
    for k in range(close_count + ghosts):
        i = close[k] if k < close_count else first_ghost + k - close_count
        if cells[i] < 0 or not in_span(rows, i, wall, dim):
            continue
        distance = distance_of(rows, i, 0, wall, dim)
        if distance < 0.0:
            if tags[i] < FIRST_GHOST:
                bad = i
                break
            cells[i] = DROPPED
            continue
        if distance >= reach:
            continue
        head = 0.0
        for d in range(dim):
            # the wall's motion where the particle touches it
            arm = arm_of(rows, i, d, wall, dim)
            wall_acceleration = wall[3 * dim + d] + spin * arm - rate * rate * (rows[i, d] - wall[d])
            way = -2.0 * distance / slant * wall[4 * dim + d]
            rows[end, d] = rows[i, d] + way
            head += way * (gravity[d] - wall_acceleration)
        reflect_velocity(rows, i, dim, end, rows, i, dim, wall, slip)
        density, pressure = rows[i, 2 * dim], rows[i, 2 * dim + 1]
        if law == HYDROSTATIC:
            pressure += density * head
            density = density_of(pressure, state)
        rows[end, 2 * dim] = density
        rows[end, 2 * dim + 1] = pressure
        rows[end, 2 * dim + 2] = rows[i, 2 * dim + 2]
        reflect_carried(rows, i, end, dim, wall, slip, carried)
        tags[end] = tags[i] + bit * FIRST_GHOST
        cells[end] = cell_of(rows, end, low, inverse, shape) - first_cell
        end += 1
    return end, bad


@jit
def exchange_with_images(rows, start, tags, first, last, dim, wall, slip, reach, carried, start_position):
    """Put the fluid among the rows ``first:last`` that is behind a wall where its images are; return how many that were.

    Parameters
    ----------
    rows, start : ndarray
        Shared and private rows; the latter begin with velocity and density at the beginning of the step.
    reach : float
        Particles farther behind the wall [m] stay there: they are lost.
    start_position : int
        Column of the position at the beginning of the step in `start`; -1 where the integrator keeps none.

    The others are those of `wall_images`.
    """
    count = 0
    slant = slant_of(wall, dim)
    for i in range(first, last):
        if tags[i] >= FIRST_GHOST or not in_span(rows, i, wall, dim):
            continue
        distance = distance_of(rows, i, 0, wall, dim)
        if not -reach < distance < 0.0:
            continue
        reflect_velocity(start, i, 0, i, rows, i, dim, wall, slip)
        reflect_velocity(rows, i, dim, i, rows, i, dim, wall, slip)
        reflect_carried(rows, i, i, dim, wall, slip, carried)
        for d in range(dim):
            rows[i, d] -= 2.0 * distance / slant * wall[4 * dim + d]
        if start_position >= 0:
            start_distance = distance_of(start, i, start_position, wall, dim)
            for d in range(dim):
                start[i, start_position + d] -= 2.0 * start_distance / slant * wall[4 * dim + d]
        count += 1
    return count


@dataclass
class MirrorWall:
    """A plane that mirrors the fluid, at rest or moving.

    Attributes
    ----------
    name : str
        "left", "right", "bottom", "top", ...
    point, normal : tuple of float
        A point of the plane [m] and its normal into the fluid, both at rest.
    law, slip : str
        "plain" or "hydrostatic"; "free" or "no".
    bit : int
        The wall's bit in the image number, a power of two.
    motion : Slide or Flap, optional
        What moves it.
    velocity : tuple of float, optional
        With what it slides in its plane [m/s].
    span : tuple of float
        Heights between which it stands [m].
    exchanged : int
        How many times a particle behind it has changed places with its image.
    """

    name: str
    point: tuple
    normal: tuple
    law: str
    slip: str
    bit: int
    motion: object = None
    velocity: tuple = ()
    span: tuple = (-np.inf, np.inf)
    exchanged: int = field(default=0, init=False)
    numbers: np.ndarray = field(init=False, repr=False)

    def __post_init__(self):
        dim = len(self.point)
        self.numbers = np.zeros(5 * dim + 4)
        self.numbers[:dim] = self.point
        self.numbers[dim : 2 * dim] = self.normal
        self.numbers[2 * dim : 3 * dim] = self.velocity or 0.0
        self.numbers[4 * dim : 5 * dim] = self.normal
        self.numbers[5 * dim + 2 :] = self.span

    def move(self, time):
        """Put the wall where it is at `time` [s]: it moves in the plane of the first and the last axis."""
        if self.motion is None:
            return
        dim, now = len(self.point), self.motion.at(time)
        axes = np.array([0, dim - 1])
        point = now.place(np.array([[self.point[0], self.point[-1]]]))
        self.numbers[axes] = point[0]
        self.numbers[dim + axes] = now.turn(np.array([[self.normal[0], self.normal[-1]]]))[0]
        self.numbers[2 * dim + axes] = now.velocity(point)[0]
        self.numbers[3 * dim + axes] = now.acceleration(point)[0]
        self.numbers[5 * dim], self.numbers[5 * dim + 1] = now.rate, now.spin

    def exchange(self, particles, reach):
        """Let the fluid that is less than `reach` [m] behind the wall change places with its images; return how many do."""
        p, layout = particles, particles.layout
        rows, columns = (p.shared, p.private, p.tags, p.first, p.last), (layout.carried, layout.place("start_position"))
        count = exchange_with_images(*rows, layout.dim, self.numbers, SLIPS[self.slip], reach, *columns)
        self.exchanged += count
        return count

    @property
    def codes(self):
        """(law, slip, bit) as the compiled code knows them."""
        return LAWS[self.law], SLIPS[self.slip], self.bit

    def distance(self, position):
        """Return how far `position` [m] is in front of the wall [m], negative behind it, infinite above and below it."""
        dim = len(self.point)
        if not self.span[0] <= position[-1] < self.span[1]:
            return np.inf
        with np.errstate(invalid="ignore"):  # asked of particles that got lost, at infinity too
            return float((np.asarray(position) - self.numbers[:dim]) @ self.numbers[dim : 2 * dim])

    def band(self, reach, height):
        """Return the box, (low, high) tuples, in which particles may come within `reach` of the wall [m].

        `height` is up to where a moving wall is wetted at the most [m].
        """
        least, largest = self.motion.reach(height) if self.motion else (0.0, 0.0)
        lows, highs = [], []
        for x, n in zip(self.point, self.normal, strict=True):
            lows.append(x + least - reach if n else -np.inf)
            highs.append(x + largest + reach if n else np.inf)
        return tuple(lows), tuple(highs)
