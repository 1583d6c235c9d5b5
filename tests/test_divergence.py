"""Continuity with a renormalised divergence: exact for linear velocities, plain in spray, and what waves gain by it."""

import math

import numpy as np
import pytest
from helpers import domain_of, grid_around, jittered_lattice, tank, water

from parsph.analysis import oscillation
from parsph.errors import SceneError
from parsph.kernels import KERNELS
from parsph.parallel import Communicator
from parsph.scene.build import build
from parsph.scene.check_waves import doubts_of
from parsph.scene.load import load_scene
from parsph.sweep import Sweep
from parsph.terms import DENSITIES, DIFFUSIONS, Terms
from parsph.terms.density import LEAST_DETERMINANT
from parsph.waves import Seiche

CELLS = {1: (24,), 2: (11, 9), 3: (7, 6, 5)}
DX, RHO0, C0 = 0.1, 1000.0, 20.0
RENORMALISED = {"numerics.density": "renormalised", "numerics.integrator": "adams-bashforth"}


def block(dim, velocity):
    """Return fields of a jittered block without anything around it; `velocity` is a function of the positions."""
    rng = np.random.default_rng(3)
    position = jittered_lattice(dim, CELLS[dim], DX)
    count = len(position)
    return {
        "position": position,
        "velocity": velocity(position),
        "density": RHO0 * rng.uniform(0.97, 1.03, count),
        "mass": RHO0 * DX**dim * rng.uniform(0.9, 1.1, count),
    }


def rates(fields, law="renormalised", single=False):
    """Return density rates in the order of the particles."""
    dim = fields["position"].shape[1]
    terms = Terms(density=DENSITIES[law], diffusion=DIFFUSIONS["fourtakas"])  # of no strength: compiled for the basin too
    sweep = Sweep(KERNELS["wendland-c2"], terms, dim, 1.7 * DX, RHO0, C0, (0.0,) * dim, delta=0.0, single=single)
    grid = grid_around(fields["position"], sweep.kernel.support * sweep.h)
    domain = domain_of(grid, fields, state=water(C0))
    domain.arrange(0.0)
    p = domain.particles
    sweep(p, domain.starts, domain.slab, 1, grid.columns + 1)
    return p.density_rate[p.fluid[np.argsort(p.tags[p.fluid])]]


def moments(fields):
    """Return -M/rho_a and G of all particles, shapes (n, dim, dim), over all pairs."""
    x, v = (fields[name] for name in ("position", "velocity"))
    dim, h = x.shape[1], 1.7 * DX
    x_ab, v_ab = x[:, None] - x, v[:, None] - v
    r = np.sqrt((x_ab**2).sum(axis=2))
    slope = KERNELS["wendland-c2"].slope(r / h, 1.0, dim) / h ** (dim + 1)
    mF = fields["mass"] * slope / np.where(r > 0, r, 1.0)
    M = -np.einsum("ab,abi,abj->aij", mF, x_ab, x_ab) / fields["density"][:, None, None]
    return M, np.einsum("ab,abi,abj->aij", mF, v_ab, x_ab)


@pytest.mark.parametrize(("dim", "single"), [*((dim, False) for dim in CELLS), (2, True)])
def test_the_divergence_of_a_linear_velocity_is_exact_at_free_surfaces_too(dim, single):
    gradient = np.random.default_rng(dim).normal(0, 1, (dim, dim))
    fields = block(dim, lambda x: x @ gradient.T + 0.3)
    M, _ = moments(fields)
    inside = np.linalg.det(M) > LEAST_DETERMINANT
    expected = -fields["density"] * np.trace(gradient)
    tolerance = 2e-5 if single else 1e-12
    np.testing.assert_allclose(rates(fields, single=single)[inside], expected[inside], rtol=tolerance)
    assert inside.sum() > 0.3 * len(expected), "edges and corners of three dimensions have a quarter and less"
    assert np.abs(rates(fields, "continuity") / expected - 1).max() > 0.3, "the plain sum is not"


@pytest.mark.parametrize("dim", CELLS)
def test_it_equals_the_sum_over_all_pairs_and_the_plain_one_in_spray(dim):
    fields = block(dim, lambda x: np.random.default_rng(8).normal(0, 1, x.shape))
    M, G = moments(fields)
    spray = np.linalg.det(M) < LEAST_DETERMINANT
    expected = np.trace(G @ np.linalg.inv(M), axis1=1, axis2=2)
    expected[spray] = np.trace(G, axis1=1, axis2=2)[spray]
    found = rates(fields)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * scale)
    np.testing.assert_allclose(found[spray], rates(fields, "continuity")[spray], rtol=0, atol=1e-13 * scale)
    assert spray.any() == (dim > 1)


def test_lone_particles_and_pairs_have_a_rate():
    """A particle without neighbours has none to renormalise by."""
    x = np.array([[0.0, 0.0], [5.0, 0.0], [5.05, 0.0]])
    fields = {"position": x, "velocity": np.array([[1.0, 0], [1.0, 0], [0, 0]]), "mass": np.full(3, RHO0 * DX**2)}
    found = rates(fields)
    assert found[0] == 0
    assert found[1] == found[2] > 0


COUNT, DEPTH = 38, 0.5
DEEP = DEPTH / 12  # dx
MODE = Seiche(COUNT * DEEP, DEPTH, 0.01, 9.81)


def basin(law, periods, **block):
    """Return the prepared simulation of a basin, 12 particles per depth, and its scene's end [s]."""
    keys = {
        "domain.size": [COUNT * DEEP, 0.8],
        "fluid.blocks": [{"low": [0, 0], "high": [COUNT * DEEP, DEPTH], **block}],
        "numerics.dx": DEEP,
        "numerics.h_over_dx": 2.5,
        "numerics.diffusion": "fourtakas",
        "numerics.c0_factor": 10.0,
        **law,
        "walls.exchange": True,
        "time.end": periods * 2 * math.pi / MODE.frequency,
        "gauges": [],
    }
    simulation = build(load_scene("seiche", keys), Communicator())
    simulation.prepare()
    return simulation


def test_still_water_stays_still():
    simulation = basin(RENORMALISED, 2)
    while simulation.time < simulation.end:
        simulation.advance()
    assert np.abs(simulation.field("velocity")).max() < 5e-3


def seiche_loss(law):
    """Return what a seiche loses of its amplitude in a period, and its frequency off theory."""
    simulation, times, shares = basin(law, 6, initial="seiche", amplitude=MODE.amplitude), [], []
    while simulation.time < simulation.end:
        simulation.advance()
        if simulation.steps % 10 == 0:
            times.append(simulation.time)
            shares.append(MODE.share(simulation.field("position"), simulation.field("velocity")))
    late = len(times) // 2
    found = oscillation(np.array(times[late:]), np.array(shares[late:]), MODE.frequency)
    return found.loss, found.frequency / MODE.frequency - 1


def test_waves_lose_less():
    """The plain law's loss is mostly that of the rows at the surface: measured 0.66 and 0.05 % a period."""
    plain, renormalised = seiche_loss({}), seiche_loss(RENORMALISED)
    assert abs(renormalised[0]) < 0.4 * plain[0]
    assert abs(renormalised[1]) < 0.01


@pytest.mark.parametrize(
    ("scene", "overrides", "why"),
    [
        (tank(), {**RENORMALISED, "numerics.kernel_correction": "linear"}, "does that, and more"),
        (tank(), {"numerics.density": "renormalised"}, 'integrator = "adams-bashforth"'),
        ("swe-pulse", RENORMALISED, "no free surface in the plan"),
    ],
)
def test_where_it_does_not_go(scene, overrides, why):
    with pytest.raises(SceneError, match=r"numerics\.density") as caught:
        load_scene(scene, overrides)
    assert why in str(caught.value)


def test_too_smooth_a_kernel_and_walls_of_ghosts_are_told():
    assert not doubts_of(load_scene(tank(), {**RENORMALISED, "numerics.h_over_dx": 2.5}))
    (doubt,) = doubts_of(load_scene(tank(), {**RENORMALISED, "numerics.h_over_dx": 3.0}))
    assert doubt.startswith("numerics.h_over_dx: 3 ")
    assert not doubts_of(load_scene(tank(), {"numerics.h_over_dx": 3.0}))
    (doubt,) = doubts_of(load_scene("still-tank", {**RENORMALISED, "time.end": 5.0}))
    assert doubt.startswith('numerics.density: "renormalised" has been seen')


def test_waves_in_a_basin_for_too_long_are_told():
    """140 sqrt(0.2 m/9.81 m/s^2) are 19.99 s; an absorbing layer, or no weight, and there is no such limit."""
    assert not doubts_of(load_scene("seiche", {**RENORMALISED, "time.end": 19.9}))
    (doubt,) = doubts_of(load_scene("seiche", {**RENORMALISED, "time.end": 20.1}))
    assert "disorder after 20 s" in doubt
    assert not doubts_of(load_scene("seiche", {"time.end": 20.1}))
    assert not doubts_of(load_scene("pool", RENORMALISED))
    assert not doubts_of(load_scene("elliptical-drop", {"time.end": 100.0}))
