"""What walls leave of the accelerations that a fluid at rest may not have, beside what it has without them.

A scene whose fluid is in equilibrium at the beginning (constant pressure without gravity, or still water) is evaluated once:
whatever acceleration is left is an error, near walls that of their treatment.
"""

import json
import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .parallel import Communicator
from .scene.build import build
from .scene.load import load_scene, scene_text
from .scene.schema import Scene
from .scene.solids import markers_of

TURN = math.cos(math.radians(45))  # walls in reach that turn further than this from the nearest one make a corner


@dataclass(frozen=True)
class Residuals:
    """Accelerations of a fluid in equilibrium, which should be zero.

    Attributes
    ----------
    position : ndarray, shape (n, dim)
        Of the fluid [m].
    before, after : ndarray, shape (n, dim)
        Accelerations without walls and with them [m/s^2].
    distance : ndarray, shape (n,)
        From the nearest wall [m].
    near : ndarray of bool, shape (n,)
        Within the support radius of a wall, and farther than that below a free surface.
    turning : ndarray of bool, shape (n,)
        In a corner or at a sharp end: of the walls within the support radius some turn by more than 45 degrees from the
        nearest one.
    reach : float
        Support radius [m].
    """

    position: np.ndarray
    before: np.ndarray
    after: np.ndarray
    distance: np.ndarray
    near: np.ndarray
    turning: np.ndarray
    reach: float

    @property
    def places(self):
        """{"walls": mask, "corners": mask}: near walls away from corners and ends, and in them."""
        return {"walls": self.near & ~self.turning, "corners": self.near & self.turning}


def root_mean_square(acceleration):
    """Return the root mean square of the magnitudes [m/s^2] of accelerations, shape (n, dim); NaN of none."""
    return float(np.linalg.norm(acceleration) / math.sqrt(len(acceleration))) if len(acceleration) else math.nan


def largest(acceleration):
    """Return the largest magnitude [m/s^2] of accelerations, shape (n, dim); NaN of none."""
    return float(np.linalg.norm(acceleration, axis=1).max()) if len(acceleration) else math.nan


def residual_accelerations(scene, overrides=None, time=0.0):
    """Return the `Residuals` of a scene at its beginning, in one or two dimensions.

    Parameters
    ----------
    scene : str, Path, dict or Scene
        What `load_scene` takes, or a scene.
    overrides : dict, optional
        Dotted keys to values, as {"walls.treatment": "ghosts"}.
    time : float
        When [s]: where moving walls stand; the fluid is where it begins.

    Raises
    ------
    SceneFaults
        When the scene does not go with the overrides.
    """
    scene = load_scene(_keys(scene), overrides)
    return residuals_of(scene, build(scene, Communicator()), time)


def residuals_of(scene, walled, time=0.0):
    """Return the `Residuals` of the simulation `walled`, which has the fluid of `scene`, at `time` [s]."""
    bare = build(scene, Communicator())
    bare.domain.walls, bare.domain.ghosts, bare.domain.barrier, bare.domain.markers = [], None, None, None
    bare.evaluate(time)
    walled.evaluate(time)
    position, before = _accelerations(bare)
    _, after = _accelerations(walled)
    pieces = WallPieces(scene, time)
    distance = pieces.distances(position)
    below = scene.level - position[:, -1] > scene.reach if any(scene.gravity) else np.ones(len(position), bool)
    near = (distance < scene.reach) & below
    turning = np.zeros(len(position), bool)
    turning[near] = pieces.turns(position[near], scene.reach)
    return Residuals(position, before, after, distance, near, turning, scene.reach)


class WallPieces:
    """The walls of a scene at a time, in the small pieces that markers stand for, whatever they are made of.

    Parameters
    ----------
    scene : Scene or dict
        A scene, or its keys.
    time : float
        [s]
    """

    def __init__(self, scene, time=0.0):
        markers = markers_of(load_scene(_keys(scene), {"walls.treatment": "deficiency"}))
        self._markers = markers
        self.position, self.normal = markers.position, markers.normal
        self._stand(time)

    def _stand(self, time):
        self._markers.move(time)
        self._tree = cKDTree(self.position)

    def move(self, time):
        """Put them where they are at `time` [s]."""
        if self._markers.moving:
            self._stand(time)

    def _nearest(self, points):
        return self._tree.query(points)[1]

    def distances(self, points):
        """Return how far points, shape (n, dim) [m], are in front of the nearest wall; behind it the number is negative."""
        nearest = self._nearest(points)
        return ((points - self.position[nearest]) * self.normal[nearest]).sum(axis=1)

    def turns(self, points, reach):
        """Return at which points, shape (n, dim) [m], walls within `reach` [m] turn by more than 45 degrees from the nearest.

        Walls that face each other across a narrow tank are two walls, not a corner.
        """
        turning = np.zeros(len(points), bool)
        for k, (nearest, around) in enumerate(
            zip(self._nearest(points), self._tree.query_ball_point(points, reach), strict=True)
        ):
            turning[k] = (np.abs(self.normal[around] @ self.normal[nearest]) < TURN).any()
        return turning


def _keys(scene):
    """Return a scene's keys, and whatever else names one as it is."""
    return json.loads(scene_text(scene)) if isinstance(scene, Scene) else scene


def _accelerations(simulation):
    """Return positions [m] and accelerations [m/s^2] of the fluid, in the order of its numbers."""
    order = np.argsort(simulation.field("id"))
    return simulation.field("position")[order], simulation.particles.acceleration[simulation.particles.fluid][order]
