"""What walls leave of the accelerations that a fluid at rest may not have, beside what it has without them.

A scene whose fluid is in equilibrium at the beginning (constant pressure without gravity, or still water) is evaluated once:
whatever acceleration is left is an error, near walls that of their treatment.
"""

import json
import math
from dataclasses import dataclass

import numpy as np

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
    bare = build(scene, Communicator())
    without_walls(bare)
    return residuals_of(scene, bare, build(scene, Communicator()), time)


def residuals_of(scene, bare, walled, time=0.0):
    """Return the `Residuals` of two simulations of the same fluid, `bare` without walls and `walled`, at `time` [s]."""
    bare.evaluate(time)
    walled.evaluate(time)
    order, before = _sorted(bare)
    _, after = _sorted(walled)
    position = bare.field("position")[order]
    distance, turning = wall_distances(scene, position, time)
    below = scene.level - position[:, -1] > scene.reach if any(scene.gravity) else np.ones(len(position), bool)
    return Residuals(position, before, after, distance, (distance < scene.reach) & below, turning, scene.reach)


def without_walls(simulation):
    """Take all walls out of a simulation that has not begun."""
    domain = simulation.domain
    domain.walls, domain.ghosts, domain.barrier, domain.markers = [], None, None, None


def wall_distances(scene, position, time=0.0):
    """Return the distances [m] of points, shape (n, dim), from the nearest wall, and whether walls turn there (`Residuals`).

    Walls are taken in the pieces that markers stand for, whatever they are made of.
    """
    pieces = markers_of(load_scene(_keys(scene), {"walls.treatment": "deficiency"}))
    pieces.move(time)
    away = position[:, None] - pieces.position
    far = np.linalg.norm(away, axis=2)
    rows, nearest = np.arange(len(position)), far.argmin(axis=1)
    normal = pieces.normal[nearest]
    distance = np.abs((away[rows, nearest] * normal).sum(axis=1))
    alike = normal @ pieces.normal.T
    # Opposite walls of a narrow tank are two walls, not a corner.
    turning = ((far < scene.reach) & (alike < TURN) & (alike > -TURN)).any(axis=1)
    return distance, turning


def _keys(scene):
    """Return a scene's keys, and whatever else names one as it is."""
    return json.loads(scene_text(scene)) if isinstance(scene, Scene) else scene


def _sorted(simulation):
    """Return the order of the fluid by its number, and the accelerations [m/s^2] in that order."""
    order = np.argsort(simulation.field("id"))
    return order, simulation.particles.acceleration[simulation.particles.fluid][order]
