"""The neighbour loop against a brute-force sum over all pairs.

The sums, with ``F = (1/r) dW/dr`` and ``x_ab = x_a - x_b``:

- ``dv_a/dt = g - sum_b m_b (p_a/rho_a^2 + p_b/rho_b^2 + Pi_ab) F x_ab``
- ``drho_a/dt = sum_b m_b v_ab . x_ab F + 2 delta h c0 sum_b (s_a - s_b) F m_b/rho_b``
- ``drift_a = epsilon sum_b m_b/2 (1/rho_a + 1/rho_b) (v_b - v_a) W``

Where densities are summed, ``rho_a = sum_b m_b W`` stands in place of the density rate. Where h varies, W and F are those of
``h_ab = (h_a + h_b)/2``; viscosity and diffusion keep the constant h.
"""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import SOME_KERNELS, domain_of, grid_around, jittered_lattice, tank, water

from parsph.kernels import KERNELS
from parsph.particles import Layout
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.sweep import Sweep
from parsph.terms import DENSITIES, DIFFUSIONS, NONE, VISCOSITIES, XSPH, Terms

DX, RHO0, C0 = 0.05, 1000.0, 20.0
CELLS = {1: (40,), 2: (13, 11), 3: (7, 6, 7)}
GRAVITY = {1: (0.0,), 2: (1.5, -9.81), 3: (1.5, -2.0, -9.81)}
COMBINATIONS = {
    "none": Terms(),
    "viscosity": Terms(viscosity=VISCOSITIES["monaghan"]),
    "molteni": Terms(diffusion=DIFFUSIONS["molteni"]),
    "xsph": Terms(smoothing=XSPH),
    "all": Terms(DENSITIES["continuity"], VISCOSITIES["monaghan"], DIFFUSIONS["fourtakas"], XSPH),
}
SUMMED = "summation, viscosity, xsph"
TERMS = {**COMBINATIONS, SUMMED: Terms(DENSITIES["summation"], VISCOSITIES["monaghan"], NONE, XSPH)}


def case(dim, kernel="wendland-c2", terms="all", single=False, gravity=None, growth=1.0, gamma=7.0):
    """Return (fields, Sweep) of a jittered block of water with random velocities and densities."""
    rng = np.random.default_rng(11)
    position = jittered_lattice(dim, CELLS[dim], DX)
    count, state = len(position), water(C0)
    density = RHO0 * rng.uniform(0.98, 1.02, count)
    fields = {
        "position": position,
        "velocity": rng.normal(0, 1.0, (count, dim)),
        "density": density,
        "pressure": state.pressure(density),
        "mass": RHO0 * DX**dim * rng.uniform(0.8, 1.2, count),
    }
    h = 1.3 * DX
    numbers = {
        "alpha": 0.1,
        "delta": 0.1,
        "epsilon": 0.5,
        "single": single,
        "h_over_dx": 1.3,
        "h_growth": growth,
        "gamma": gamma,
    }
    gravity = GRAVITY[dim] if gravity is None else gravity
    return fields, Sweep(KERNELS[kernel], TERMS[terms], dim, h, RHO0, C0, gravity, **numbers)


def swept(fields, sweep):
    """Return the rates that the sweep finds, in the order of the tags."""
    grid = grid_around(fields["position"], sweep.kernel.support * sweep.h * sweep.h_growth)
    domain = domain_of(grid, fields, gravity=sweep.gravity, state=water(C0))
    p = domain.particles
    if sweep.terms.smoothing is not NONE:
        p.drift = np.zeros((len(p.tags), sweep.dim))
    domain.arrange(0.0)
    sweep(p, domain.starts, domain.slab, 1, grid.columns + 1)
    rows = p.fluid[np.argsort(p.tags[p.fluid])]
    drift = p.drift[rows] if len(p.drift) else None
    return SimpleNamespace(acceleration=p.acceleration[rows], density_rate=p.density_rate[rows], drift=drift)


def brute_force(fields, sweep):
    """The sums of the module's docstring over all pairs, term by term in numpy."""
    x, v, rho, p, m = (fields[name] for name in ("position", "velocity", "density", "pressure", "mass"))
    x_ab, v_ab = x[:, None] - x, v[:, None] - v
    r = np.sqrt((x_ab**2).sum(axis=2))
    h = (
        np.clip(sweep.h_over_dx * m / rho, sweep.h, sweep.h * sweep.h_growth)
        if sweep.h_growth > 1
        else np.full(len(m), sweep.h)
    )
    h = 0.5 * (h[:, None] + h)
    W = sweep.kernel.value(r / h, 1.0, sweep.dim) / h**sweep.dim
    F = sweep.kernel.slope(r / h, 1.0, sweep.dim) / h ** (sweep.dim + 1) / np.where(r > 0, r, 1.0)
    vx = (v_ab * x_ab).sum(axis=2)
    pressure = (p / rho**2)[:, None] + p / rho**2
    mean = 0.5 * ((1 / rho)[:, None] + 1 / rho)
    if sweep.terms.viscosity is not NONE:
        mu = sweep.h * vx / (r**2 + 0.01 * sweep.h**2)
        pressure = pressure + np.where(vx < 0, -sweep.alpha * sweep.c0 * mu * mean, 0.0)
    acceleration = np.array(sweep.gravity) - ((m * pressure * F)[:, :, None] * x_ab).sum(axis=1)
    density_rate = (m * vx * F).sum(axis=1)
    if sweep.terms.diffusion is not NONE:
        s = rho.copy()
        if sweep.terms.diffusion.name == "fourtakas":
            e, gamma = rho / sweep.rho0 - 1, sweep.gamma
            enthalpy = e + (gamma - 2) / 2 * e**2 + (gamma - 2) * (gamma - 3) / 6 * e**3
            s = sweep.rho0 * (enthalpy - x @ np.array(sweep.gravity) / sweep.c0**2)
        # psi_ab . grad W with psi_ab = 2 (s_b - s_a) x_ba / r^2 and grad W = F x_ab
        psi_grad = 2 * (s - s[:, None]) * np.where(r > 0, -1.0, 0.0) * F
        density_rate = density_rate + sweep.delta * sweep.h * sweep.c0 * (psi_grad * m / rho).sum(axis=1)
    if sweep.terms.density.name == "summation":
        density_rate = (m * W).sum(axis=1)
    drift = None
    if sweep.terms.smoothing is not NONE:
        drift = -sweep.epsilon * ((m * mean * W)[:, :, None] * v_ab).sum(axis=1)
    return SimpleNamespace(acceleration=acceleration, density_rate=density_rate, drift=drift)


def assert_same_rates(found, expected, tolerance):
    for name in ("acceleration", "density_rate", "drift"):
        a, b = getattr(found, name), getattr(expected, name)
        if b is None:
            assert a is None, f"{name} although no term needs it"
        else:
            np.testing.assert_allclose(a, b, atol=tolerance * np.abs(b).max(), rtol=0, err_msg=name)


@pytest.mark.parametrize("dim", CELLS)
@pytest.mark.parametrize(
    ("kernel", "terms"),
    [("wendland-c2", name) for name in COMBINATIONS] + [(name, "all") for name in SOME_KERNELS if name != "wendland-c2"],
)
def test_sweep_equals_the_sum_over_all_pairs(dim, kernel, terms):
    fields, sweep = case(dim, kernel, terms)
    assert_same_rates(swept(fields, sweep), brute_force(fields, sweep), 2e-12)


def test_summed_densities_equal_the_sum_over_all_pairs():
    """In one dimension, where shallow water needs them; a particle's own mass counts."""
    fields, sweep = case(1, terms=SUMMED)
    found, expected = swept(fields, sweep), brute_force(fields, sweep)
    assert_same_rates(found, expected, 2e-12)
    assert (found.density_rate > fields["mass"] * sweep.kernel.value(0.0, sweep.h, 1)).all()


def thinning(terms, growth, kernel="wendland-c2", single=False):
    """A case in 1D whose particles have 0.2 to 6 times the volume that belongs to h, on the same positions."""
    fields, sweep = case(1, kernel, terms, single, growth=growth)
    fields["mass"] = fields["mass"] * np.geomspace(0.2, 6, len(fields["mass"]))
    return fields, sweep


@pytest.mark.parametrize("growth", [1.5, 4.0])
@pytest.mark.parametrize(("terms", "kernel"), [("all", "wendland-c2"), (SUMMED, "wendland-c2"), (SUMMED, "gaussian")])
def test_sweep_with_a_growing_h_equals_the_sum_over_all_pairs(terms, kernel, growth):
    """h_a = h_over_dx m_a/rho_a, at least h and at most growth times that; a pair has the mean of two."""
    fields, sweep = thinning(terms, growth, kernel)
    volumes = fields["mass"] / fields["density"] / DX
    assert volumes.min() < 0.5
    assert volumes.max() > growth
    expected = brute_force(fields, sweep)
    assert_same_rates(swept(fields, sweep), expected, 2e-12)
    constant = brute_force(fields, dataclasses.replace(sweep, h_growth=1.0))
    for name in ("acceleration", "density_rate", "drift"):
        assert np.abs(getattr(constant, name) / getattr(expected, name) - 1).max() > 0.1


def test_a_growing_h_in_single_precision():
    fields, sweep = thinning("all", 4.0, single=True)
    assert_same_rates(swept(fields, sweep), brute_force(fields, sweep), 1e-4)


@pytest.mark.parametrize("terms", ["all", SUMMED])
def test_h_does_not_grow_where_water_does_not_thin(terms):
    """With volumes below dx the growing h is the constant one; and where it grows, pairs still conserve momentum."""
    fields, sweep = case(1, terms=terms, growth=20.0, gravity=(0.0,))
    fields["mass"] = 0.5 * RHO0 * DX * np.random.default_rng(2).uniform(0.2, 1.5, len(fields["mass"]))
    assert_same_rates(swept(fields, sweep), swept(fields, dataclasses.replace(sweep, h_growth=1.0)), 1e-13)
    fields["mass"] *= 8
    forces = fields["mass"][:, None] * swept(fields, sweep).acceleration
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12 * np.abs(forces).sum())


@pytest.mark.parametrize("dim", CELLS)
@pytest.mark.parametrize("kernel", SOME_KERNELS)
def test_sweep_in_single_precision_equals_the_sum_over_all_pairs(dim, kernel):
    """Pairs in float32 with coordinates relative to the cell: good to 1e-4 of the largest rate."""
    fields, sweep = case(dim, kernel, "all", single=True)
    found, expected = swept(fields, sweep), brute_force(fields, sweep)
    assert_same_rates(found, expected, 1e-4)
    assert np.abs(found.acceleration - expected.acceleration).max() > 1e-12 * np.abs(expected.acceleration).max()


@pytest.mark.parametrize("dim", CELLS)
@pytest.mark.parametrize("terms", ["none", "all"])
def test_pairs_conserve_momentum(dim, terms):
    """Action equals reaction: without gravity the forces of a closed set of particles sum to zero."""
    fields, sweep = case(dim, terms=terms, gravity=(0.0,) * dim)
    forces = fields["mass"][:, None] * swept(fields, sweep).acceleration
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12 * np.abs(forces).sum())


@pytest.mark.parametrize("dim", CELLS)
def test_velocity_smoothing_conserves_momentum(dim):
    fields, sweep = case(dim)
    shares = fields["mass"][:, None] * swept(fields, sweep).drift
    np.testing.assert_allclose(shares.sum(axis=0), 0, atol=1e-12 * np.abs(shares).sum())


@pytest.mark.parametrize("dim", CELLS)
@pytest.mark.parametrize("diffusion", ["molteni", "all"])
def test_density_diffusion_only_moves_mass_between_particles(dim, diffusion):
    """``sum_a V_a drho_a/dt = 0``: what one particle gains another loses. At rest diffusion is the only density rate."""
    fields, sweep = case(dim, terms=diffusion)
    fields["velocity"][:] = 0
    gains = fields["mass"] / fields["density"] * swept(fields, sweep).density_rate
    assert np.abs(gains).max() > 0
    assert abs(gains.sum()) < 1e-12 * np.abs(gains).sum()


@pytest.mark.parametrize("dim", [2, 3])
def test_fourtakas_leaves_hydrostatic_density_as_it_is(dim):
    """In still water, ``rho = rho0 (1 + g . x / c0^2)`` for gamma = 2, nothing diffuses; Molteni's form sees it all."""
    rates = {}
    for terms in ("all", "molteni"):
        fields, sweep = case(dim, terms=terms, gamma=2.0)
        fields["velocity"][:] = 0
        fields["density"] = RHO0 * (1 + fields["position"] @ np.array(sweep.gravity) / C0**2)
        rates[terms] = np.abs(swept(fields, sweep).density_rate).max()
    assert rates["all"] < 1e-11 * rates["molteni"]


def test_viscosity_takes_kinetic_energy_and_acts_on_approaching_pairs_only():
    fields, sweep = case(2, terms="viscosity", gravity=(0.0, 0.0))
    fields["pressure"][:] = 0
    centre = fields["position"].mean(axis=0)
    for sign, acts in ((-1, True), (1, False)):
        fields["velocity"] = sign * (fields["position"] - centre)
        power = (fields["mass"][:, None] * fields["velocity"] * swept(fields, sweep).acceleration).sum()
        assert (power < 0) if acts else (power == 0)


@pytest.mark.parametrize("dim", CELLS)
def test_constant_velocity_changes_nothing(dim):
    """Galilean invariance: a common velocity has neither density rate, nor viscosity, nor smoothing."""
    fields, sweep = case(dim, terms="xsph")
    fields["velocity"][:] = 1.0
    rates = swept(fields, sweep)
    assert (rates.density_rate == 0).all()
    assert (rates.drift == 0).all()


def test_terms_that_a_scene_does_not_name_cost_nothing():
    """No array for smoothing, none for a start position that only the midpoint integrator needs; no dead number acts."""
    simulation = build(load_scene(tank()))
    simulation.run()
    assert len(simulation.particles.drift) == 0
    assert Layout(2, ("verlet",)).width("private") < Layout(2, ("midpoint",)).width("private")
    fields, sweep = case(2, terms="none")
    loud = dataclasses.replace(sweep, alpha=9.0, delta=9.0, epsilon=9.0)
    a, b = swept(fields, sweep), swept(fields, loud)
    np.testing.assert_array_equal(a.acceleration, b.acceleration)
    np.testing.assert_array_equal(a.density_rate, b.density_rate)


def test_named_smoothing_has_its_array():
    keys = tank()
    keys["numerics"]["xsph"] = 0.5
    simulation = build(load_scene(keys))
    simulation.run()
    assert np.abs(simulation.particles.drift[simulation.particles.fluid]).max() > 0


def test_rates_do_not_depend_on_the_grid_around_the_particles():
    """A particle's sum has a fixed order; moving the grid changes rounding only."""
    fields, sweep = case(2)
    rates = swept(fields, sweep)
    shifted = {**fields, "position": np.concatenate([fields["position"], [[-1.0, -1.0]]])}
    for name, value in (("velocity", [[0.0, 0.0]]), ("density", [RHO0]), ("pressure", [0.0]), ("mass", [1.0])):
        shifted[name] = np.concatenate([fields[name], value])
    more = swept(shifted, sweep)
    scale = np.abs(rates.acceleration).max()
    np.testing.assert_allclose(more.acceleration[:-1], rates.acceleration, atol=1e-12 * scale)
