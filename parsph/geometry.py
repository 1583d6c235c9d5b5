"""Polygonal walls in 2D: what is solid, where ghost particles stand, and which points of the fluid they mirror.

Solids that stand still are merged first, so an obstacle on a bed makes a corner with it. Ghosts stand on curves parallel to
the boundary of the merged solid, at depths ``s = (k + 1/2) dx``, as many as the support needs. Each belongs to the nearest
point of the wall, x_w, and mirrors a point of the fluid:

- at a face: ``x_m = x_w + s n``, n the normal into the fluid;
- where the nearest point is a corner of the fluid: mirrored through it (along the bisector where that leaves the fluid);
- where two faces of a corner of the solid are equally near: along the bisector of their normals, through the corner.

Where another wall is nearer than 2 s along that way the point stands half-way to it. Marrone et al. (2011), Comput. Methods
Appl. Mech. Eng. 200, 1526; Huang et al. (2019) section 2.2.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import cKDTree
from shapely.geometry import LineString, Polygon

from .errors import SceneError

PUSHES = 200
COINCIDENT = 1e-12  # m: points nearer to each other are one
CLOSE = 1.1  # over the distance at which points are moved: round ends are drawn by chords, a little too thin
LARGEST_TABLE = 1_000_000  # points times edges that are looked at together
CROWDED = 0.35  # spacings: ghosts nearer to each other are one
SHARP_TURN = math.radians(20)  # bends beyond it are corners; below, the line is round
STRAIGHT = 0.9  # cosine of the angle up to which a line goes on in another


@dataclass(frozen=True)
class Outline:
    """The outline of a wall as the scene gives it.

    Attributes
    ----------
    name : str
    points : tuple of (float, float)
        Vertices [m].
    fluid : str
        Where the fluid is: "inside" or "outside" of a closed polygon, "left" or "right" of an open line, walking along it.
    """

    name: str
    points: tuple
    fluid: str

    def nearest_vertex(self, point):
        """Return the number of the vertex nearest to `point` [m]."""
        return int(np.linalg.norm(np.array(self.points) - point, axis=1).argmin())

    @property
    def closed(self):
        """Whether it is a polygon."""
        return self.fluid in ("inside", "outside")

    @property
    def edges(self):
        """Edges with the fluid at their left, shape (n, 2, 2) [m]."""
        points = np.array(self.points, float)
        if self.closed:
            points = np.vstack([points, points[:1]])
            counter_clockwise = Polygon(points).exterior.is_ccw
            turn = counter_clockwise != (self.fluid == "inside")
        else:
            turn = self.fluid == "right"
        if turn:
            points = points[::-1]
        return np.stack([points[:-1], points[1:]], axis=1)


def outline_faults(outline, where, size):
    """Return what is wrong with an outline alone, a list of SceneError; `where` names it, `size` is the domain's [m]."""
    points, faults = np.array(outline.points, float), []
    least = 3 if outline.closed else 2
    if len(points) < least:
        return [SceneError(f"has {len(points)} points", where=f"{where}.points", cure=f"at least {least}")]
    for number, point in enumerate(points):
        if (point < 0).any() or (point > np.array(size) * (1 + 1e-12)).any():
            cure = f"within 0 and {list(size)} m, or enlarge domain.size"
            why = f"({point[0]:g}, {point[1]:g}) m"
            faults.append(SceneError("lies outside the domain", where=f"{where}.points.{number}", why=why, cure=cure))
    following = np.roll(points, -1, axis=0) if outline.closed else points[1:]
    for number, (a, b) in enumerate(zip(points, following, strict=False)):
        if math.dist(a, b) <= COINCIDENT:
            cure = "leave one out; a polygon closes itself"
            faults.append(SceneError("equals the next point", where=f"{where}.points.{number}", cure=cure))
    if faults:
        return faults
    line = LineString(np.vstack([points, points[:1]]) if outline.closed else points)
    if not line.is_simple:
        number, crossing = _crossing(line)
        why = f"the edge from point {number} meets another one at ({crossing[0]:g}, {crossing[1]:g}) m"
        cure = "an outline that does not cross or touch itself"
        faults.append(SceneError("crosses itself", where=f"{where}.points.{number}", why=why, cure=cure))
    return faults


def _crossing(line):
    """Return (number of the first edge that meets another one away from their common point, where [m])."""
    points = list(line.coords)
    edges = [LineString(pair) for pair in itertools.pairwise(points)]
    for i, edge in enumerate(edges):
        for j in range(i + 1, len(edges)):
            common = edge.intersection(edges[j])
            allowed = {points[j]} if j == i + 1 else set()
            allowed |= {points[i]} if i == 0 and j == len(edges) - 1 and line.is_closed else set()
            if common.is_empty or (common.geom_type == "Point" and common.coords[0] in allowed):
                continue
            return i, common.representative_point().coords[0]
    return 0, points[0]


@dataclass
class Ghosts:
    """Ghost particles of walls that move together, or stand still.

    Attributes
    ----------
    position, mirror : ndarray, shape (n, 2)
        Where they stand, and the points of the fluid that they mirror [m].
    direction : ndarray, shape (n, 2)
        Normal of the wall into the fluid; at corners from the ghost to its mirror point.
    through_point : ndarray of bool, shape (n,)
        Mirrored through a corner: all components of the velocity are turned, not the normal one alone.
    volume : ndarray, shape (n,)
        Area [m^2] that each stands for.
    part : ndarray of int, shape (n,)
        Number of the outline that each belongs to.
    """

    position: np.ndarray
    mirror: np.ndarray
    direction: np.ndarray
    through_point: np.ndarray
    volume: np.ndarray
    part: np.ndarray


class Boundary:
    """The walls that stand still together, or one that moves: their merged solid, and their wetted edges.

    Parameters
    ----------
    outlines : dict of int to Outline
        By their number in the scene.
    dx, reach : float
        Particle spacing and support radius [m].
    neighbours : sequence of Outline
        Walls of other boundaries: what moves ends at a wall that stands still, which goes on under it, unless what moves
        carries it on, as a flap does above its hinge.
    moves : bool
        Whether this boundary moves.

    Attributes
    ----------
    solid : shapely geometry
    edges : ndarray, shape (n, 2, 2)
        Edges with the fluid at their left, open lines prolonged at their free ends [m].
    part : ndarray of int, shape (n,)
        Outline of each edge.
    """

    def __init__(self, outlines, dx, reach, neighbours=(), moves=False):
        self.outlines, self.dx, self.reach, self.neighbours, self.moves = outlines, dx, reach, neighbours, moves
        self._tolerance, self._thickness = 1e-6 * dx, 2 * reach + 2 * dx
        self.solids = {number: self._solid(number) for number in outlines}
        self.solid = shapely.union_all([*self.solids.values(), *self._joints()])
        self.edges, self.part = self._wetted({n: self._prolonged(n).edges for n in outlines})
        self.normals = _normals(self.edges)

    def _prolonged(self, number):
        """Return an outline, an open one longer at its free ends, where ghosts are needed a little beyond."""
        outline = self.outlines[number]
        if outline.closed:
            return outline
        points = np.array(outline.points, float)
        length = math.ceil(2 * self.reach / self.dx) * self.dx  # whole spacings: ghosts keep step with the fluid's lattice
        free = self.free_ends(number)
        if free[0]:
            points[0] += length * unit(points[0] - points[1])
        if free[1]:
            points[-1] += length * unit(points[-1] - points[-2])
        return Outline(outline.name, tuple(map(tuple, points)), outline.fluid)

    def free_ends(self, number):
        """Return whether the first and the last point of an open line touch no other outline."""
        points, others = self.outlines[number].points, [other for n, other in self.outlines.items() if n != number]
        if self.moves:
            others += self.neighbours
        ends = (points[0], points[1]), (points[-1], points[-2])
        return tuple(not (touched(end, others, self.dx) or self._carried_on(end, before)) for end, before in ends)

    def _carried_on(self, end, before):
        """Whether a wall of another boundary goes on straight where an open line ends that comes from `before`."""
        way = unit(np.subtract(end, before))
        for other in self.neighbours:
            for first, second in ((0, 1), (-1, -2)):
                start = np.array(other.points[first])
                if not other.closed and np.linalg.norm(start - end) <= 1e-6 * self.dx:
                    return bool(unit(np.subtract(other.points[second], start)) @ way > STRAIGHT)
        return False

    def _solid(self, number):
        """Return what is solid behind an outline: the polygon itself, or a band thick enough for all ghosts."""
        outline = self._prolonged(number)
        if outline.fluid == "outside":
            return Polygon(outline.points)
        if outline.fluid == "inside":
            inner = Polygon(outline.points)
            return inner.buffer(self._thickness, join_style="mitre").difference(inner)
        return self._band(outline.edges)

    def _band(self, edges):
        """Return the band behind consecutive edges with the fluid at their left."""
        line = LineString([*edges[:, 0], edges[-1, 1]])
        return line.buffer(-self._thickness, single_sided=True, join_style="mitre")

    def _joints(self):
        """Return the bands behind the corners where one open line goes on in another."""
        lines = [outline.edges for outline in self.outlines.values() if not outline.closed]
        joints = []
        for before in lines:
            for after in lines:
                if np.linalg.norm(before[-1, 1] - after[0, 0]) <= self._tolerance:
                    joints.append(self._band(np.stack([before[-1], [before[-1, 1], after[0, 1]]])))
        return joints

    def _wetted(self, edges_of):
        """Return what of the edges, by outline, is not inside the merged solid: edges, shape (n, 2, 2), and their outlines."""
        edges, part, inside = [], [], self.solid.buffer(-self._tolerance)
        for number, own in edges_of.items():
            for edge in own:
                rest = LineString(edge).difference(inside)
                for piece in getattr(rest, "geoms", [rest]):
                    if piece.length > 10 * self._tolerance:
                        edges.append(np.array(piece.coords)[[0, -1]])
                        part.append(number)
        return np.array(edges).reshape(-1, 2, 2), np.array(part, int)

    def inner_ends(self):
        """Return which ends of the edges meet another one in a corner of the fluid, shape (n, 2).

        What moves meets the walls of other boundaries too: the line of a plate goes on in the bed that it stands on, but not
        that of a flap above its sill.
        """
        inner = np.zeros((len(self.edges), 2), bool)
        for e, edge in enumerate(self.edges):
            for end, other_end in ((0, 1), (1, 0)):
                meets = np.linalg.norm(self.edges[:, other_end] - edge[end], axis=1) <= 10 * self._tolerance
                for other in np.flatnonzero(meets):  # it leads away to the fluid's side
                    away = self.edges[other, end] - self.edges[other, other_end]
                    inner[e, end] |= bool(unit(away) @ self.normals[e] > 1e-9)
                if self.moves and not self._carried_on(edge[end], edge[other_end]):
                    inner[e, end] |= touched(edge[end], self.neighbours, self.dx)
        return inner

    def lines(self, pieces=False):
        """Return the wetted edges, shape (n, 2, 2) [m], their normals, and `inner_ends`; if asked, in `pieces` of about dx."""
        inner = self.inner_ends()
        if not pieces:
            return self.edges, self.normals, inner
        counts = np.maximum(1, np.round(np.linalg.norm(self.edges[:, 1] - self.edges[:, 0], axis=1) / self.dx).astype(int))
        edge, last = np.repeat(np.arange(len(counts)), counts), np.cumsum(counts) - 1
        place = np.concatenate([np.arange(count) / count for count in counts])[:, None]
        along = self.edges[edge, 1] - self.edges[edge, 0]
        start = self.edges[edge, 0] + place * along
        cut = np.stack([start, start + along / counts[edge][:, None]], axis=1)
        ends = np.zeros((len(edge), 2), bool)
        ends[last - counts + 1, 0], ends[last, 1] = inner[:, 0], inner[:, 1]
        return cut, self.normals[edge], ends

    # --- ghosts ---------------------------------------------------------------------------------------------------

    def ghosts(self, layers=None):
        """Return the `Ghosts` of this boundary, in so many `layers`; by default as many as the support needs."""
        rings = []
        for layer in range(layers or math.ceil(self.reach / self.dx - 0.5)):
            rings += [_sampled(ring, self.dx) for ring in self._inset_rings((layer + 0.5) * self.dx)]
        position = np.concatenate([points for points, _ in rings])
        volume = np.concatenate([lengths * self.dx for _, lengths in rings])
        position, volume = _merged(position, volume, self.dx)
        deepest = layers * self.dx if layers else self.reach
        ways, near, part = [], [], []
        for some in _parts(len(position), len(self.edges)):
            feet, distance = _feet(position[some], self.edges)
            close = distance.min(axis=1) < deepest
            near.append(close)
            part.append(self.part[distance[close].argmin(axis=1)])
            ways += map(self._way, position[some][close], feet[close], distance[close])
        near = np.concatenate(near)
        mirror, direction, through = (np.array(values) for values in zip(*ways, strict=True))
        return Ghosts(position[near], mirror, direction, through, volume[near], np.concatenate(part))

    def _inset_rings(self, depth):
        """Return the lines at a `depth` [m] inside the solid, those in the middle of solids twice as thick among them."""
        hair = 1e-3 * self.dx
        inset, wider = (self.solid.buffer(-d, join_style="mitre", mitre_limit=2.0) for d in (depth, depth - hair))
        slivers = [part for part in getattr(wider, "geoms", [wider]) if part.area < 2 * hair * part.length]
        return _rings(inset) + [ring for sliver in slivers for ring in _rings(sliver)]

    def _way(self, position, feet, distance):
        """Return (mirror point, direction, whether mirrored through a point) of a ghost, from its feet on all edges."""
        nearest = distance.argmin()
        foot, normal, s = feet[nearest], self.normals[nearest], distance[nearest]
        ties = np.flatnonzero(distance <= s + 10 * self._tolerance)
        corner = _shared_vertex(self.edges[ties], self._tolerance)
        if corner is None:
            return foot + min(s, 0.5 * self._free_way(foot, normal)) * normal, normal, False
        bisector = unit(self.normals[ties].sum(axis=0))
        direction, through = bisector, False
        if np.linalg.norm(feet[ties] - corner, axis=1).max() <= 10 * self._tolerance:  # a corner of the fluid, or a bend
            through = bool(self.normals[ties[0]] @ self.normals[ties[-1]] < math.cos(SHARP_TURN))
            direction = unit(corner - position)
            if self._free_way(corner, direction) == 0.0:
                direction = bisector
        s = np.linalg.norm(corner - position)
        return corner + min(s, 0.5 * self._free_way(corner, direction)) * direction, direction, through

    def _free_way(self, start, direction):
        """Return how far a ray from a point of the wall runs through the fluid [m], up to the next wall or for ever."""
        if self.solid.contains(shapely.Point(start + 1e-3 * self.dx * direction)):
            return 0.0
        ways, _ = self._hits(start[None], direction[None])
        return float(ways[0])

    def _hits(self, starts, directions):
        """Return at which distance [m] rays first meet an edge, inf for never, and which, all of shape (n,)."""
        ways, others = np.full(len(starts), math.inf), np.zeros(len(starts), int)
        along = self.edges[:, 1] - self.edges[:, 0]
        for some in _parts(len(starts), len(self.edges)):
            begin, direction = self.edges[:, 0] - starts[some, None], directions[some, None]
            with np.errstate(divide="ignore", invalid="ignore"):
                across = _cross(direction, along)
                way, place = _cross(begin, along) / across, _cross(begin, direction) / across
            met = (way > 10 * self._tolerance) & (place >= -1e-9) & (place <= 1 + 1e-9)
            way = np.where(met, way, math.inf)
            others[some] = way.argmin(axis=1)
            ways[some] = way.min(axis=1)
        return ways, others

    def pushed_off(self, points, gap):
        """Return `points`, shape (n, 2), those nearer to a wall than `gap` moved away from it [m]."""
        points, lines = points.copy(), shapely.MultiLineString([LineString(edge) for edge in self.edges])
        close = np.flatnonzero(contains(lines.buffer(CLOSE * gap), points))  # much faster than distances, which few points need
        for _ in range(PUSHES):  # what moves off one wall of a corner may come near the other
            near = close[shapely.distance(lines, shapely.points(points[close])) < (1 - 1e-9) * gap]
            if not len(near):
                break
            for some in _parts(len(near), len(self.edges)):
                own = near[some]
                feet, distance = _feet(points[own], self.edges)
                nearest, rows = distance.argmin(axis=1), np.arange(len(own))
                foot, away = feet[rows, nearest], distance[rows, nearest][:, None]
                direction = np.where(
                    away > self._tolerance, (points[own] - foot) / np.maximum(away, self._tolerance), self.normals[nearest]
                )
                points[own] = foot + gap * direction
        return points

    # --- surface and faults -----------------------------------------------------------------------------------------

    def elements(self, number, length=None):
        """Return the wetted surface of one outline in pieces of about a `length` [m], by default dx.

        Returns
        -------
        tuple of ndarray
            Midpoints, shape (n, 2) [m], normals into the fluid, shape (n, 2), lengths, shape (n,) [m].
        """
        edges, _ = self._wetted({number: self.outlines[number].edges})
        along = edges[:, 1] - edges[:, 0]
        lengths = np.linalg.norm(along, axis=1)
        counts = np.maximum(1, np.round(lengths / (length or self.dx)).astype(int))
        edge = np.repeat(np.arange(len(edges)), counts)
        place = np.concatenate([(np.arange(count) + 0.5) / count for count in counts])
        return edges[edge, 0] + place[:, None] * along[edge], _normals(edges)[edge], (lengths / counts)[edge]

    def faults(self, where):
        """Return what is wrong with the walls together, a list of SceneError; `where` names outlines by their number.

        Walls must be as thick as their ghost layers, gaps between them two particles wide.
        """
        faults = []
        for number, outline in self.outlines.items():
            points, normals, _ = self.elements(number)
            found = []
            for way, least, what, why in (
                (-1.0, self.reach, "the wall is", "ghost particles of one side would act on the fluid at the other"),
                (1.0, 2 * self.dx, "the gap to the next wall is", "it needs two particles across"),
            ):
                width, other = self._hits(points, way * normals)
                facing = (self.normals[other] * normals).sum(axis=1) < -0.5
                near = np.flatnonzero((width < (1 - 1e-9) * least) & facing)
                row = next((row for row in near if not self._adjacent(points[row], other[row])), None)
                if row is not None:
                    cure = f"at least {least:.4g} m there, or a smaller numerics.dx"
                    found.append((row, f"{what} {width[row]:.4g} m near this point", why, cure))
            if found:
                row, *told = min(found, key=lambda each: each[0])
                vertex = f"{where[number]}.points.{outline.nearest_vertex(points[row])}"
                faults.append(SceneError(told[0], vertex, *told[1:]))
        return faults

    def behind(self, number, shape):
        """Return how much of a `shape` lies behind the outline of a basin or a line [m^2], and a point of it [m] or None.

        What an obstacle takes of it does not count: that stays dry.
        """
        outline = self.outlines[number]
        if outline.fluid == "outside":
            return 0.0, None
        grid = {"grid_size": self._tolerance}  # slanting edges that are equal but for rounding defeat the exact overlay
        if outline.closed:
            hidden = shapely.difference(shape, Polygon(outline.points), **grid)
        else:
            hidden = shapely.intersection(shape, self.solids[number], **grid)
        return hidden.area, np.array(hidden.representative_point().coords[0]) if hidden.area else None

    def ends_in(self, number, shapes):
        """Return the numbers of the ends of an open outline that touch no wall and lie in one of the `shapes` of fluid."""
        outline = self.outlines[number]
        if outline.closed:
            return []
        ends = {0: self.free_ends(number)[0], len(outline.points) - 1: self.free_ends(number)[1]}
        wet = {end: any(self._wets(shape, outline.points[end]) for shape in shapes) for end in ends}
        held = {end: touched(outline.points[end], self.neighbours, self.dx) for end in ends}
        return [end for end, free in ends.items() if free and wet[end] and not held[end]]

    def _wets(self, shape, point):
        """Whether a shape of fluid reaches above a point of it."""
        return shape.distance(shapely.Point(point)) <= self._tolerance and point[1] < shape.bounds[3] - self._tolerance

    def _adjacent(self, point, other):
        """Whether the edge that holds `point` and the edge `other` share a vertex."""
        own = int(_feet(point[None], self.edges)[1].argmin())
        return _shared_vertex(self.edges[[own, other]], self._tolerance) is not None


def touched(point, outlines, dx):
    """Whether a point lies on one of the outlines, to a millionth of the spacing `dx` [m]."""
    point = shapely.Point(point)
    return any(LineString(edge).distance(point) <= 1e-6 * dx for outline in outlines for edge in outline.edges)


def without(shape, boundaries):
    """Return what of a shape lies in none of the solids of `boundaries`."""
    for boundary in boundaries:
        shape = shapely.difference(shape, boundary.solid, grid_size=1e-6 * boundary.dx)
    return shape


def polygon(points):
    """Return the shape of a polygon with the vertices `points` [m]."""
    return Polygon(points)


def contains(area, points):
    """Return which of `points`, shape (n, 2) [m], lie inside an area, shape (n,)."""
    return shapely.contains_xy(area, *points.T)


def unit(vector):
    """Return the vector over its length."""
    return vector / np.linalg.norm(vector)


def _normals(edges):
    """Return the normals of edges to their left, shape (n, 2)."""
    along = edges[:, 1] - edges[:, 0]
    return np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _feet(points, edges):
    """Return the nearest point of each edge to each of `points`, shape (n, edges, 2), and its distance, shape (n, edges)."""
    start, along = edges[:, 0], edges[:, 1] - edges[:, 0]
    place = ((points[:, None] - start) * along).sum(axis=2) / (along**2).sum(axis=1)
    feet = start + np.clip(place, 0.0, 1.0)[:, :, None] * along
    return feet, np.linalg.norm(points[:, None] - feet, axis=2)


def _parts(count, edges):
    """Return slices of `count` points such that a part of them and all `edges` make a table of a bounded size."""
    length = max(1, LARGEST_TABLE // max(edges, 1))
    return [slice(first, first + length) for first in range(0, count, length)]


def _shared_vertex(edges, tolerance):
    """Return the vertex that two or more edges share, None where they share none or lie in one line."""
    if len(edges) < 2:
        return None
    first, last = edges[0], edges[-1]
    for a in first:
        for b in last:
            if np.linalg.norm(a - b) <= 10 * tolerance:
                straight = abs(_cross(unit(first[1] - first[0]), unit(last[1] - last[0]))) < 1e-9
                return None if straight else a
    return None


def _rings(area):
    """Return the closed boundary lines of an area, each of shape (n, 2), the first point not repeated."""
    rings = []
    for polygon in getattr(area, "geoms", [area]):
        if not polygon.is_empty:
            rings += [np.array(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    return rings


def _merged(points, volume, dx):
    """Return ghosts and their volumes, those that crowd together made one: two sides of a thin solid meet in its middle."""
    pairs = cKDTree(points).query_pairs(CROWDED * dx, output_type="ndarray")
    alone, volume = np.ones(len(points), bool), volume.copy()
    for first, second in pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]:
        if alone[first] and alone[second]:
            volume[first] = min(volume[first] + volume[second], dx**2)
            alone[second] = False
    return points[alone], volume[alone]


def _sampled(ring, dx):
    """Return points at spacings near `dx` on a closed line, its corners among them, and the length that each stands for."""
    back, on = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turn = np.abs(np.arctan2(_cross(back, on), (back * on).sum(axis=1)))
    corners = np.flatnonzero(turn > SHARP_TURN)
    ring = np.roll(ring, -(corners[0] if len(corners) else 0), axis=0)
    corners = (corners - corners[0]) if len(corners) else np.array([0])
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1))])
    closed = np.vstack([ring, ring[:1]])
    places = []
    for a, b in zip(way[corners], [*way[corners[1:]], way[-1]], strict=True):
        count = max(1, round((b - a) / dx))
        places.append(a + (b - a) * np.arange(count) / count)
    places = np.concatenate(places)
    points = np.stack([np.interp(places, way, closed[:, d]) for d in range(2)], axis=1)
    gaps = np.diff(np.append(places, way[-1]))
    return points, 0.5 * (gaps + np.roll(gaps, 1))
