"""What is left of accelerations at rest, and how far particles are from walls, on small scenes."""

import math

import numpy as np
import pytest

from parsph.residuals import WallPieces, largest, residual_accelerations, root_mean_square
from parsph.scene.load import load_scene

SMALL = {"numerics.dx": 0.2, "numerics.h_over_dx": 1.5}  # of the closed tanks


def test_mirrors_leave_nothing_of_a_constant_pressure_but_rounding():
    found = residual_accelerations("tank-rectangle", {**SMALL, "walls.treatment": "mirror"})
    assert found.position.shape == found.before.shape == found.after.shape == (150, 2)
    assert root_mean_square(found.before[found.near]) > 1e-3
    assert largest(found.after) < 1e-14
    inner = (found.position > found.reach).all(axis=1) & (found.position < np.array([3.0, 2.0]) - found.reach).all(axis=1)
    assert inner.any()
    assert largest(found.before[inner]) < 1e-14


def test_places_are_walls_and_corners():
    """The corners of a rectangle are where two of its walls are within the support radius."""
    found = residual_accelerations("tank-rectangle", {**SMALL, "walls.treatment": "mirror"})
    to_walls = np.concatenate([found.position, np.array([3.0, 2.0]) - found.position], axis=1)
    np.testing.assert_allclose(found.distance, to_walls.min(axis=1), atol=1e-12)
    in_reach = (to_walls < found.reach).sum(axis=1)
    np.testing.assert_array_equal(found.near, in_reach > 0)
    np.testing.assert_array_equal(found.places["corners"], in_reach > 1)
    np.testing.assert_array_equal(found.places["walls"], in_reach == 1)


def test_before_is_the_same_whatever_the_walls():
    mirrored, marked = (
        residual_accelerations("tank-rectangle", {**SMALL, "walls.treatment": name}) for name in ("mirror", "deficiency")
    )
    np.testing.assert_allclose(marked.before, mirrored.before, rtol=1e-12, atol=1e-15)
    ratio = root_mean_square(marked.after[marked.near]) / root_mean_square(marked.before[marked.near])
    assert 1e-6 < ratio < 0.2


def test_a_free_surface_is_no_wall():
    """Of a column of water only what is farther than the support radius below the surface counts."""
    found = residual_accelerations("column", {"numerics.dx": 0.25, "numerics.h_over_dx": 1.5, "walls.treatment": "mirror"})
    high = found.position[:, 1] > 5.0 - found.reach
    assert high.any()
    assert not found.near[high].any()
    assert found.near[~high].any()


def test_a_line_has_no_corners():
    found = residual_accelerations("column-1d", {"walls.treatment": "mirror"})
    assert found.position.shape == (40, 1)
    assert found.near.sum() == 20
    assert not found.turning.any()
    assert largest(found.before) > 1.0
    assert largest(found.after) < 1e-12


def test_nothing_has_no_size():
    assert math.isnan(root_mean_square(np.zeros((0, 2))))
    assert math.isnan(largest(np.zeros((0, 2))))
    assert root_mean_square(np.array([[3.0, 4.0], [0.0, 0.0]])) == pytest.approx(5.0 / math.sqrt(2.0))
    assert largest(np.array([[3.0, 4.0], [0.0, 6.0]])) == pytest.approx(6.0)


def test_distances_are_negative_behind_walls():
    pieces = WallPieces(load_scene("seiche"))
    points = np.array([[0.05, 0.03], [-0.004, 0.1], [0.207, 0.1], [0.1, -0.002], [0.1, 0.15], [-0.003, -0.002]])
    expected = [0.03, -0.004, -0.007, -0.002, 0.1]
    np.testing.assert_allclose(pieces.distances(points)[:5], expected, atol=1e-12)
    assert pieces.distances(points)[5] < 0


def test_distances_follow_a_wall_that_bulges():
    scene = load_scene("bulging-wall")
    point = np.array([[0.5, 0.13]])
    assert WallPieces(scene).distances(point)[0] == pytest.approx(0.03, abs=1e-9)
    assert WallPieces(scene, 1.875).distances(point)[0] == pytest.approx(-0.03, abs=1e-4)
    assert WallPieces(scene, 2.625).distances(point)[0] == pytest.approx(0.09, abs=1e-4)
