"""Exact flows without weight: do they obey their equations, and are they those of the literature."""

import numpy as np
import pytest

from parsph.flows import RotatingPatch, StretchingDrop, TaylorGreen

RHO, STEP = 800.0, 1e-4


def inside(low, high, count=40, margin=0.02):
    """Return random points of a box that keep clear of its edges, shape (count, 2)."""
    low, high = np.array(low) + margin, np.array(high) - margin
    return low + np.random.default_rng(5).random((count, 2)) * (high - low)


def slopes(function, points):
    """Return derivatives of a function of positions along both axes, by central differences: shape (2, n, ...)."""
    steps = STEP * np.eye(2)
    return np.array([(function(points + step) - function(points - step)) / (2 * STEP) for step in steps])


def laplacian(function, points):
    """Return the Laplacian of a function of positions, shape (n,)."""
    steps = [*STEP * np.eye(2), *-STEP * np.eye(2)]
    return (sum(function(points + step) for step in steps) - 4 * function(points)) / STEP**2


def convection(flow, points):
    """Return (v . grad) v of a flow at its beginning, shape (n, 2)."""
    return np.einsum("nj,jni->ni", flow.velocity(points), slopes(flow.velocity, points))


@pytest.mark.parametrize(
    "flow",
    [
        RotatingPatch((1.0, 2.0), (2.0, 2.7), -3.0, RHO),
        StretchingDrop((1.0, 2.0), (2.0, 2.7), 2.0, RHO),
        TaylorGreen((1.0, 2.0), 0.7, 1.5, 0.0, RHO),
    ],
    ids=["patch", "drop", "vortices"],
)
def test_velocities_diverge_nowhere_and_pressures_keep_it_so(flow):
    """``laplace p = -rho div((v . grad) v)``: what an incompressible fluid's pressure does."""
    points = inside((1.0, 2.0), (1.7, 2.7))
    gradient = slopes(flow.velocity, points)
    np.testing.assert_allclose(np.trace(gradient, axis1=0, axis2=2), 0.0, atol=1e-6)
    wanted = -RHO * np.trace(slopes(lambda at: convection(flow, at), points), axis1=0, axis2=2)
    np.testing.assert_allclose(laplacian(flow.pressure, points), wanted, rtol=1e-3, atol=1e-3 * np.abs(wanted).max())


def test_a_patch_has_the_pressure_of_the_double_series_and_none_at_its_surface():
    """Of a square: sum over odd m, n of -32/(m n pi^2 ((m pi)^2 + (n pi)^2)) sin(m pi x/L) sin(n pi y/L), Colagrossi (2005)."""
    side, rate = 2.0, 1.5
    flow = RotatingPatch((0.0, 0.0), (side, side), rate, RHO)
    points = np.concatenate([[[1.0, 1.0]], inside((0.0, 0.0), (side, side), 5, 0.3)])
    m = np.arange(1, 4000, 2)
    weights = -32 / (np.pi**4 * np.outer(m, m) * (m[:, None] ** 2 + m**2))
    series = [np.sin(m * np.pi * x / side) @ weights @ np.sin(m * np.pi * y / side) for x, y in points]
    np.testing.assert_allclose(flow.pressure(points), RHO * rate**2 * side**2 * np.array(series), rtol=1e-5)
    assert flow.pressure(points[:1])[0] / (RHO * rate**2 * side**2) == pytest.approx(-0.147343, abs=1e-6)
    edge = np.linspace(0.0, side, 21)
    for x, y in ((edge, 0 * edge), (edge, 0 * edge + side), (0 * edge, edge), (0 * edge + side, edge)):
        assert np.abs(flow.pressure(np.stack([x, y], axis=1))).max() < 2e-6 * RHO * rate**2 * side**2


def test_a_patch_turns_counter_clockwise_about_its_middle():
    flow = RotatingPatch((1.0, 1.0), (3.0, 2.0), 2.0, RHO)
    np.testing.assert_array_equal(flow.velocity([[2.0, 1.5], [3.0, 1.5], [2.0, 2.0]]), [[0, 0], [0, 2.0], [-1.0, 0]])


@pytest.mark.parametrize(
    ("time", "rate", "short", "long"),
    [
        (0.2, 0.96270219, 0.82082616, 1.2182848),
        (0.4, 0.87510122, 0.68269926, 1.4647738),
        (2.5, 0.32209658, 0.22806455, 4.3847235),
    ],
)
def test_a_drop_stretches_as_monaghan_says(time, rate, short, long):
    """The table of the ODE with a b = 1, scaled to a radius of 2 m and A = 10/s."""
    flow = StretchingDrop((-2.0, -2.0), (2.0, 2.0), 10.0, RHO)
    np.testing.assert_allclose(flow.at(time / 10), [10 * rate, 2 * short, 2 * long], rtol=2e-7)
    assert np.prod(flow.at(time / 10)[1:]) == pytest.approx(4.0, rel=1e-8)


def test_a_drop_presses_in_its_middle_alone():
    flow = StretchingDrop((0.0, 0.0), (2.0, 2.0), 3.0, RHO)
    np.testing.assert_allclose(flow.pressure([[1.0, 1.0], [2.0, 1.0], [1.0, 0.0]]), [0.5 * RHO * 9, 0, 0], atol=1e-9)
    np.testing.assert_array_equal(flow.velocity([[2.0, 1.0], [1.0, 2.0]]), [[-3.0, 0], [0, 3.0]])


def test_vortices_are_a_solution_at_every_time():
    """``dv/dt + (v . grad) v = -grad p/rho + nu laplace v``."""
    flow, time = TaylorGreen((0.0, 0.0), 2.0, 1.5, 0.03, RHO), 0.4
    points = inside((0.0, 0.0), (2.0, 2.0))
    rate = (flow.velocity(points, time + STEP) - flow.velocity(points, time - STEP)) / (2 * STEP)
    gradient = slopes(lambda at: flow.velocity(at, time), points)
    inertia = rate + np.einsum("nj,jni->ni", flow.velocity(points, time), gradient)
    pressure = slopes(lambda at: flow.pressure(at, time), points).T / RHO
    friction = flow.nu * np.stack([laplacian(lambda at, d=d: flow.velocity(at, time)[:, d], points) for d in (0, 1)], axis=1)
    np.testing.assert_allclose(inertia, friction - pressure, atol=1e-5)
    assert flow.decay == pytest.approx(8 * np.pi**2 * 0.03 / 4)
    assert np.abs(flow.velocity(np.array([[0.0, 0.5]]))).max() == 1.5
