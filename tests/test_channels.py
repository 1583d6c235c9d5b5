"""Viscous stress, walls that slide, a vertical without ends, smoothed continuity, and densities that are summed.

Newtonian viscosity adds to dv_a/dt, with the strain rate D that the rows carry, ``F = (1/r) dW/dr``, ``x_ab = x_a - x_b``:

- ``sum_b m_b mu (eps_a/rho_a^2 + eps_b/rho_b^2) . x_ab F`` with ``eps = D - 1/3 tr(D) 1``, and
- ``sum_b m_b 2 (dim + 2)/4 mu U_ab/(r_ab^2 + 0.01 h^2) x_ab F`` with the part of the velocity difference that D does not
  explain, ``U_ab = (1/rho_a^2 + 1/rho_b^2)/2 v_ab . x_ab - x_ab . (D_a/rho_a^2 + D_b/rho_b^2) . x_ab / 4``;

and the sweep finds ``D_a = sum_b m_b/rho_b (v_ba x_ab + x_ab v_ba) F``.
"""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import domain_of, grid_around, images_of, jittered_lattice, tank, water

from parsph.columns import Grid
from parsph.errors import RunError, SceneError
from parsph.kernels import KERNELS
from parsph.particles import FIELDS, FIRST_FIXED, IMAGE_SHIFT, Layout, identities
from parsph.run import run
from parsph.scene.build import borders_of, build, walls_of
from parsph.scene.load import builtin_names, load_scene
from parsph.scene.plan import costs, print_plan
from parsph.stepping import time_step_limit
from parsph.sweep import Sweep
from parsph.terms import NONE, SMOOTHED_CONTINUITY, VISCOSITIES, XSPH, Terms
from parsph.terms.viscosity import UNSEEN, unseen_viscosity
from parsph.verify import CASES
from parsph.verify.channels import channel, couette_profile, poiseuille_profile, shake
from parsph.walls import MirrorWall, PeriodicBorder
from parsph.walls.mirror import SLIPS
from parsph.wavemakers import Flap, Oscillation

DX, RHO0, C0, NU = 0.05, 1000.0, 20.0, 0.3
CELLS = {1: (40,), 2: (13, 11), 3: (7, 6, 7)}
TRIANGLES = {dim: np.triu_indices(dim) for dim in CELLS}


def tensor(triangle, dim):
    """Return symmetric tensors, shape (n, dim, dim), from their upper triangles."""
    full = np.zeros((len(triangle), dim, dim))
    rows, columns = TRIANGLES[dim]
    full[:, rows, columns] = triangle
    full[:, columns, rows] = triangle
    return full


def block(dim, features=("verlet", "newtonian")):
    """Return random fields of a jittered block, those that rows carry included."""
    rng = np.random.default_rng(5)
    position = jittered_lattice(dim, CELLS[dim], DX)
    count = len(position)
    density = RHO0 * rng.uniform(0.95, 1.05, count)
    fields = {
        "position": position,
        "velocity": rng.normal(0, 1, (count, dim)),
        "density": density,
        "pressure": np.zeros(count),
        "mass": RHO0 * DX**dim * rng.uniform(0.8, 1.2, count),
    }
    if "newtonian" in features:
        fields["strain_rate"] = rng.normal(0, 5, (count, dim * (dim + 1) // 2))
    if "xsph_continuity" in features:
        fields["smoothing"] = rng.normal(0, 0.5, (count, dim))
    return fields


def viscous_sweep(dim, single=False):
    terms = Terms(viscosity=VISCOSITIES["newtonian"])
    return Sweep(KERNELS["wendland-c2"], terms, dim, 1.4 * DX, RHO0, C0, (0.0,) * dim, single=single, nu=NU)


def rates(fields, sweep, features=("verlet", "newtonian"), carry=False):
    """Return what the sweep finds, in the order of the tags."""
    grid = grid_around(fields["position"], sweep.kernel.support * sweep.h)
    domain = domain_of(grid, fields, gravity=sweep.gravity, state=water(C0), features=features)
    p = domain.particles
    if sweep.terms.smoothing is not NONE:
        p.drift = np.zeros((len(p.tags), sweep.dim))
    domain.arrange(0.0)
    for _ in range(1 + carry):
        sweep(p, domain.starts, domain.slab, 1, grid.columns + 1)
        p.carry()
    rows = p.fluid[np.argsort(p.tags[p.fluid])]
    return SimpleNamespace(
        **{name: getattr(p, name)[rows] for name in ("acceleration", "density_rate")},
        strain_rate=p.strain_rate[rows] if len(p.strain_rate) else None,
        carried={field.name: p.field(field.name, rows) for field in p.layout.fields if field.name in fields},
    )


def pairs(fields, sweep):
    """Return x_ab, v_ab, r_ab and F_ab, all pairs."""
    x_ab, v_ab = (fields[name][:, None] - fields[name] for name in ("position", "velocity"))
    r = np.sqrt((x_ab**2).sum(axis=2))
    slope = sweep.kernel.slope(r / sweep.h, 1.0, sweep.dim) / sweep.h ** (sweep.dim + 1)
    return x_ab, v_ab, r, slope / np.where(r > 0, r, 1.0)


def found_strain(fields, sweep):
    """D of the module's docstring, shape (n, dim, dim)."""
    x_ab, v_ab, _, F = pairs(fields, sweep)
    gradient = np.einsum("ab,abi,abj->aij", -F * fields["mass"] / fields["density"], v_ab, x_ab)
    return gradient + gradient.transpose(0, 2, 1)


def viscous_force(fields, sweep):
    """dv_a/dt of the module's docstring."""
    dim, mu = sweep.dim, RHO0 * NU
    x_ab, v_ab, r, F = pairs(fields, sweep)
    D, square = tensor(fields["strain_rate"], dim), fields["density"][:, None, None] ** -2
    eps = D - np.trace(D, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(dim)
    stress = mu * (eps * square)
    force = np.einsum("abij,abj->abi", stress[:, None] + stress, x_ab)
    both = (D * square)[:, None] + D * square
    mean = 0.5 * (square[:, None, :, 0] + square[:, :, 0])[..., 0]
    unseen = mean * (v_ab * x_ab).sum(axis=2) - np.einsum("abi,abij,abj->ab", x_ab, both, x_ab) / 4
    force += (UNSEEN * 2 * (dim + 2) * mu * unseen / (r**2 + 0.01 * sweep.h**2))[..., None] * x_ab
    return np.einsum("ab,abi->ai", F * fields["mass"], force)


# --- the stress ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("dim", "single"), [*((dim, False) for dim in CELLS), (2, True)])
def test_viscous_force_and_strain_rate_are_the_sums_over_all_pairs(dim, single):
    fields, sweep = block(dim), viscous_sweep(dim, single)
    found, tolerance = rates(fields, sweep), 1e-4 if single else 2e-12
    force, strain = viscous_force(fields, sweep), found_strain(fields, sweep)
    np.testing.assert_allclose(found.acceleration, force, rtol=0, atol=tolerance * np.abs(force).max())
    np.testing.assert_allclose(tensor(found.strain_rate, dim), strain, rtol=0, atol=tolerance * np.abs(strain).max())


@pytest.mark.parametrize("dim", CELLS)
def test_the_force_is_that_of_the_strain_rate_of_the_evaluation_before(dim):
    """The rows carry what the last sweep found, and the next one uses that."""
    fields, sweep = block(dim), viscous_sweep(dim)
    found = rates(fields, sweep, carry=True)
    np.testing.assert_array_equal(found.carried["strain_rate"].reshape(found.strain_rate.shape), found.strain_rate)
    later = {**fields, "strain_rate": rates(fields, sweep).strain_rate}
    np.testing.assert_array_equal(found.acceleration, rates(later, sweep).acceleration)
    assert np.abs(found.acceleration - rates(fields, sweep).acceleration).max() > 1


@pytest.mark.parametrize("dim", CELLS)
def test_what_rows_carry_is_found_behind_what_a_term_that_is_left_out_would_carry(dim):
    """As the gauge of power leaves viscosity out."""
    terms = Terms(density=SMOOTHED_CONTINUITY, smoothing=XSPH)
    sweep = Sweep(KERNELS["wendland-c2"], terms, dim, 1.4 * DX, RHO0, C0, (0.0,) * dim, epsilon=0.5)
    features = "verlet", "newtonian", "xsph_continuity", "drift"
    fields = block(dim, features)
    found = rates(fields, sweep, features)
    del fields["strain_rate"]
    alone = rates(fields, sweep, features[:1] + features[2:])
    np.testing.assert_array_equal(found.density_rate, alone.density_rate)
    fields["smoothing"] *= 2
    assert np.abs(rates(fields, sweep, features[:1] + features[2:]).density_rate - alone.density_rate).max() > 1


@pytest.mark.parametrize("dim", CELLS)
def test_viscous_pairs_conserve_momentum(dim):
    fields = block(dim)
    forces = fields["mass"][:, None] * rates(fields, viscous_sweep(dim)).acceleration
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12 * np.abs(forces).sum())


@pytest.mark.parametrize("dim", CELLS)
def test_a_translation_has_no_strain_rate(dim):
    """Whatever the neighbours: the printed form, with v_b alone, would have one at a surface and in any disorder."""
    fields = block(dim)
    fields["velocity"][:] = 3.0
    fields["strain_rate"][:] = 0.0
    found = rates(fields, viscous_sweep(dim))
    assert (found.strain_rate == 0).all()
    assert (found.acceleration == 0).all()


def test_what_strain_rates_explain_is_not_unseen():
    """A linear velocity, with densities that differ: Pi is zero to rounding; and it opposes what is unseen."""
    rng = np.random.default_rng(3)
    gradient, r = rng.normal(0, 1, (3, 3)), rng.normal(0, 1, 3)
    D, V_a, V_b, mu = gradient + gradient.T, 1.1e-3, 0.9e-3, 7.0
    rQr = mu * (V_a**2 + V_b**2) * (r @ D @ r)
    vr = r @ gradient @ r
    whole = unseen_viscosity(10.0, mu, vr, 0.0, r @ r, 0.01, V_a, V_b)
    assert abs(unseen_viscosity(10.0, mu, vr, rQr, r @ r, 0.01, V_a, V_b)) < 1e-14 * abs(whole)
    assert whole * vr < 0


@pytest.mark.parametrize("dim", [2, 3])
def test_strain_rates_have_no_trace_in_three_dimensions_alone(dim):
    """A fluid that expands alike in all directions of space has no viscous stress; in a plane it is not such a flow."""
    fields, sweep = block(dim), viscous_sweep(dim)
    fields["density"][:] = RHO0
    fields["velocity"] = fields["position"].copy()
    fields["strain_rate"] = np.tile((2 * np.eye(dim))[TRIANGLES[dim]], (len(fields["position"]), 1))
    force = np.abs(rates(fields, sweep).acceleration).max()
    scale = NU / sweep.h
    assert force < 1e-10 * scale if dim == 3 else force > 0.1 * scale


def test_viscosity_limits_the_time_step():
    limit = 0.125 * 0.01**2 / 0.2
    assert time_step_limit(0.01, 1.0, 9.81, 0.4, nu=0.2) == pytest.approx(limit)
    assert time_step_limit(0.01, 1.0, 9.81, 0.4, nu=1e-6) == time_step_limit(0.01, 1.0, 9.81, 0.4)
    scene = load_scene("poiseuille")
    limit = 0.125 * scene.h**2
    simulation = build(scene)
    assert simulation.first_step() == simulation.longest_step() == pytest.approx(limit)
    assert costs(scene)["step"] == pytest.approx(limit)
    with pytest.raises(SceneError, match=r"time.dt: 0.00032 s is unstable.*0.000313 s.*nu = 1 m\^2/s, dt = 0.125 h\^2/nu"):
        load_scene("poiseuille", {"time.dt": 3.2e-4})
    load_scene("poiseuille", {"time.dt": 3.1e-4})


def test_scenes_without_the_new_terms_have_none_of_their_fields():
    new = {field.name for field in FIELDS if field.needed_by in ("newtonian", "xsph_continuity", "antuono")}
    assert new == {"strain_rate", "smoothing", "density_gradient"}
    assert not new & {field.name for field in Layout(2, load_scene(tank()).features).fields}
    assert Layout(2, ("verlet",)).place("strain_rate") == -1
    assert Layout(3, ("verlet", "newtonian")).width("shared") == Layout(3, ("verlet",)).width("shared") + 6
    assert len(build(load_scene(tank())).particles.strain_rate) == 0


# --- what images carry ---------------------------------------------------------------------------------------------


REACH = 0.2
NORMALS = [(1.0, 0.0), (0.0, -1.0), (0.6, 0.8)]


def carried_images(fields, wall):
    """Return {field: (parents', images')} of particles beside a wall."""
    dim = fields["position"].shape[1]
    features = ("verlet", "newtonian", "xsph_continuity", "antuono")
    domain = domain_of(Grid.around((-2.0,) * dim, (2.0,) * dim, 0.25), fields, [wall], features=features, reach=REACH)
    domain.arrange(0.0)
    images, parents = images_of(domain)
    assert len(images) == len(fields["position"])
    names = ("position", "velocity", "strain_rate", "smoothing", "density_gradient")
    return {name: (domain.particles.field(name, parents), domain.particles.field(name, images)) for name in names}


def beside(normal, count=20, seed=4):
    """Random particles beside a wall through the origin, with all that rows carry."""
    rng, n = np.random.default_rng(seed), np.array(normal)
    dim = len(n)
    position = rng.uniform(-0.05, 0.05, (count, dim))  # a slanting wall is known to be near in a box about its point alone
    position += (rng.uniform(0.01, 0.19, count) - position @ n)[:, None] * n
    return {
        "position": position,
        "velocity": rng.normal(0, 1, (count, dim)),
        "strain_rate": rng.normal(0, 1, (count, dim * (dim + 1) // 2)),
        "smoothing": rng.normal(0, 1, (count, dim)),
        "density_gradient": rng.normal(0, 1, (count, dim)),
    }


@pytest.mark.parametrize("slip", ["free", "no"])
@pytest.mark.parametrize("normal", [*NORMALS, (1.0, 0.0, 0.0), (0.48, 0.64, 0.6)])
def test_the_gradient_of_the_density_is_reflected(normal, slip):
    """As that of a field which is even at the wall, whatever velocities do there."""
    n, dim = np.array(normal), len(normal)
    wall = MirrorWall("wall", (0.0,) * dim, normal, "plain", slip, 1)
    parents, images = carried_images(beside(normal), wall)["density_gradient"]
    np.testing.assert_allclose(images, parents @ (np.eye(dim) - 2 * np.outer(n, n)), atol=1e-14)


@pytest.mark.parametrize("normal", [*NORMALS, (1.0, 0.0, 0.0), (0.48, 0.64, 0.6)])
def test_at_free_slip_the_strain_rate_is_reflected(normal):
    """R D R, that of the reflected velocity field; smoothing is reflected as a velocity."""
    n, dim = np.array(normal), len(normal)
    wall = MirrorWall("wall", (0.0,) * dim, normal, "plain", "free", 1)
    found = carried_images(beside(normal), wall)
    R = np.eye(dim) - 2 * np.outer(n, n)
    parents, images = found["strain_rate"]
    np.testing.assert_allclose(tensor(images, dim), R @ tensor(parents, dim) @ R, atol=1e-14)
    parents, images = found["smoothing"]
    np.testing.assert_allclose(images, parents @ R, atol=1e-14)


@pytest.mark.parametrize("normal", [*NORMALS, (1.0, 0.0, 0.0), (0.48, 0.64, 0.6)])
@pytest.mark.parametrize("slides", [False, True])
def test_at_no_slip_the_strain_rate_is_that_of_the_velocity_of_the_images(normal, slides):
    """A velocity that is the wall's at the wall, ``v = w + a (x . n)``: its gradient ``a n`` continues behind the wall."""
    n, dim = np.array(normal), len(normal)
    rng = np.random.default_rng(8)
    along = rng.normal(0, 1, dim)
    along -= (along @ n) * n
    wall = MirrorWall("wall", (0.0,) * dim, normal, "plain", "no", 1, velocity=tuple(along) if slides else ())
    a, fields = rng.normal(0, 1, dim), beside(normal)
    fields["velocity"] = slides * along + (fields["position"] @ n)[:, None] * a
    fields["strain_rate"] = np.tile((np.outer(a, n) + np.outer(n, a))[TRIANGLES[dim]], (len(fields["position"]), 1))
    found = carried_images(fields, wall)
    np.testing.assert_allclose(found["velocity"][1], slides * along + (found["position"][1] @ n)[:, None] * a, atol=1e-13)
    np.testing.assert_allclose(found["strain_rate"][1], found["strain_rate"][0], atol=1e-14)
    np.testing.assert_array_equal(found["smoothing"][1], -found["smoothing"][0])


def test_at_no_slip_strain_along_the_wall_changes_its_sign():
    """The velocity along the wall is odd in the distance, so what derives along the wall is odd too."""
    normal = (0.0, 1.0, 0.0)
    found = carried_images(beside(normal), MirrorWall("wall", (0.0,) * 3, normal, "plain", "no", 1))
    parents, images = (tensor(each, 3) for each in found["strain_rate"])
    signs = np.array([[-1, 1, -1], [1, 1, 1], [-1, 1, -1]])
    np.testing.assert_allclose(images, signs * parents, atol=1e-15)


def test_a_sliding_wall_drags_the_images():
    """No slip: ``2 v_w - v``; where nothing slides, ``-v``."""
    fields = beside((1.0, 0.0))
    wall = MirrorWall("wall", (0.0, 0.0), (1.0, 0.0), "plain", "no", 1, velocity=(0.0, 3.0))
    parents, images = carried_images(fields, wall)["velocity"]
    np.testing.assert_allclose(images, [0.0, 6.0] - parents, atol=1e-14)


# --- the vertical without ends -------------------------------------------------------------------------------------


def tall(count=300, size=(1.0, 0.9), seed=2):
    """Random particles in a box, two supports high and more."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(0, 1, (count, len(size))) * size
    return {"position": position, "velocity": rng.normal(0, 1, position.shape), "mass": rng.uniform(1, 2, count)}


def periodic(fields, size=(1.0, 0.9), walls=(), **options):
    dim = len(size)
    border = PeriodicBorder(dim - 1, 0.0, size[-1], (64, 128))
    grid = Grid.around((0.0,) * dim, size, REACH)
    return domain_of(grid, fields, walls, reach=REACH, box=((0.0,) * dim, size), borders=(border,), **options)


@pytest.mark.parametrize("size", [(1.0, 0.9), (0.6, 0.5, 0.9)])
def test_particles_near_one_end_have_copies_beyond_the_other(size):
    domain = periodic(tall(size=size), size)
    domain.arrange(0.0)
    images, parents = images_of(domain)
    p, z = domain.particles, len(size) - 1
    position, height = p.field("position", parents), size[-1]
    near = (tall(size=size)["position"][:, z] < REACH).sum() + (tall(size=size)["position"][:, z] > height - REACH).sum()
    assert len(images) == near > 50
    moved = p.field("position", images) - position
    np.testing.assert_array_equal(moved[:, :z], 0)
    np.testing.assert_allclose(moved[:, z], np.where(position[:, z] < REACH, height, -height), atol=1e-15)
    for name in ("velocity", "density", "pressure", "mass"):
        np.testing.assert_array_equal(p.field(name, images), p.field(name, parents))


def test_corners_of_walls_and_periodic_ends_are_filled():
    """A particle near both has one image at the wall, one copy, and the copy of the image; all tags differ."""
    wall = MirrorWall("left", (0.0, 0.0), (1.0, 0.0), "hydrostatic", "free", 1)
    domain = periodic({"position": np.array([[0.05, 0.07], [0.5, 0.5]])}, walls=[wall])
    domain.arrange(0.0)
    images, _ = images_of(domain)
    found = {tuple(x) for x in np.round(domain.particles.field("position", images), 12)}
    assert found == {(-0.05, 0.07), (0.05, 0.97), (-0.05, 0.97)}
    assert len(set(domain.particles.tags[images])) == 3


def test_bits_of_periodic_images_are_their_own():
    keys = tank(domain={"size": [1.0, 1.0], "periodic": ["up"]}, walls={"left": {}, "right": {}})
    keys["fluid"]["blocks"][0]["pressure"] = 0.0
    keys["numerics"] = {"dx": 0.02, "c0": 20.0}
    scene = load_scene(keys)
    bits = [wall.bit for wall in walls_of(scene)] + [bit for border in borders_of(scene) for bit in border.bits]
    assert len(set(bits)) == 4
    assert sum(bits) << IMAGE_SHIFT < FIRST_FIXED
    assert all(bit & (bit - 1) == 0 for bit in bits)


def test_rates_are_those_of_a_tower_of_copies():
    """Three periods on top of each other, the middle one compared."""
    fields = tall()
    sweep = Sweep(KERNELS["wendland-c2"], Terms(viscosity=VISCOSITIES["monaghan"]), 2, REACH / 2, RHO0, C0, (0.0, 0.0), 0.1)
    fields["density"] = RHO0 * np.random.default_rng(9).uniform(0.98, 1.02, 300)
    fields["pressure"] = water().pressure(fields["density"])
    tower = {name: np.concatenate([values] * 3) for name, values in fields.items()}
    tower["position"][:300, 1] -= 0.9
    tower["position"][600:, 1] += 0.9
    mine = periodic(fields)
    whole = domain_of(Grid.around((0.0, -0.9), (1.0, 1.8), REACH), tower, reach=REACH)
    found = []
    for domain in (mine, whole):
        domain.arrange(0.0)
        p = domain.particles
        sweep(p, domain.starts, domain.slab, 1, domain.grid.columns + 1)
        rows = p.fluid[np.argsort(p.tags[p.fluid])]
        found.append((p.acceleration[rows], p.density_rate[rows]))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other[300:600], rtol=0, atol=1e-11 * np.abs(other).max())


@pytest.mark.parametrize("z", [-1e-20, -1e-9, -0.05, 0.9, 0.90001, 0.95])
def test_what_leaves_at_one_end_comes_in_at_the_other(z):
    """Its position alone changes; its neighbours beyond the border are those that it had."""
    fields = {"position": np.array([[0.5, z]]), "velocity": np.array([[1.0, -2.0]])}
    domain = periodic(fields)
    domain.arrange(0.0)
    p = domain.particles
    x, inside = p.field("position", p.fluid)[0]
    assert 0 <= inside < 0.9
    assert (x, inside) == (0.5, pytest.approx(0.0 if z == -1e-20 else z % 0.9, abs=1e-15))
    np.testing.assert_array_equal(p.field("velocity", p.fluid), fields["velocity"])


@pytest.mark.parametrize("integrator", ["verlet", "midpoint", "adams-bashforth"])
def test_a_block_falls_through_the_ends_as_through_space(integrator):
    """Rigidly, several times: v = g t, with the neighbours and densities that it had."""
    keys = {
        "domain": {"size": [0.4, 0.2], "gravity": 9.81, "periodic": ["up"]},
        "fluid": {"blocks": [{"low": [0.1, 0.0], "high": [0.3, 0.2], "pressure": 0.0}]},
        "numerics": {"dx": 0.02, "c0": 20.0, "integrator": integrator, "viscosity": "newtonian", "nu": 1e-3},
        "time": {"end": 0.3},
    }
    simulation = build(load_scene(keys))
    start = simulation.field("position")[np.argsort(simulation.field("id"))]
    simulation.run()
    order = np.argsort(simulation.field("id"))
    np.testing.assert_allclose(simulation.field("velocity"), [[0.0, -9.81 * 0.3]] * 100, atol=1e-9)
    np.testing.assert_allclose(simulation.field("density"), RHO0, rtol=1e-9)
    fall = (start[:, 1] - 0.5 * 9.81 * 0.3**2 - simulation.field("position")[order, 1]) / 0.2
    np.testing.assert_allclose(fall, np.round(fall), atol=1e-8)
    assert (np.round(fall) < -1).all()


# --- channels ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", [poiseuille_profile, couette_profile])
def test_profiles_solve_the_equation_of_diffusion(profile):
    """dv/dt = nu v'' + g, no slip at the walls, at rest in the beginning."""
    x, t, step, force = np.linspace(0, 2.0, 9), 0.7, 1e-3, 3.0
    nu = 0.4
    v = profile(x, t, 2.0, nu, force)
    assert abs(v[0]) < 1e-12
    assert v[-1] == pytest.approx(force if profile is couette_profile else 0.0, abs=1e-12)
    inner = x[1:-1]
    rate = (profile(inner, t + step, 2.0, nu, force) - profile(inner, t - step, 2.0, nu, force)) / (2 * step)
    bend = (profile(inner + step, t, 2.0, nu, force) - 2 * v[1:-1] + profile(inner - step, t, 2.0, nu, force)) / step**2
    driven = force if profile is poiseuille_profile else 0.0
    np.testing.assert_allclose(rate, nu * bend + driven, atol=1e-4)
    np.testing.assert_allclose(profile(inner, 1e-9, 2.0, nu, force), 0, atol=0.01 * force)


def flow(name, across, end, **overrides):
    """Run a channel; return (scene, x, velocities)."""
    scene = load_scene(channel(name, across).model_dump(exclude_unset=True), {"time.end": end, "gauges": [], **overrides})
    simulation = build(scene)
    simulation.run()
    return scene, simulation.field("position")[:, 0], simulation.field("velocity")


@pytest.mark.parametrize("overrides", [{}, {"numerics.integrator": "midpoint"}, {"numerics.precision": "float32"}])
def test_fluid_falls_between_walls_as_poiseuille_says(overrides):
    """At 20 particles across the profile is off by 3 %, smoothly: no pattern from column to column, nothing across."""
    _, x, v = flow("poiseuille", 20, 0.2, **overrides)
    error = v[:, 1] + poiseuille_profile(x, 0.2, 1.0, 1.0, 8.0)
    assert np.abs(error).max() < 0.035
    assert np.abs(v[:, 0]).max() < 1e-3
    columns = error[np.argsort(x, kind="stable")].reshape(20, -1)
    assert np.ptp(columns, axis=1).max() < 1e-3
    assert np.abs(np.diff(columns.mean(axis=1)[2:-2], 2)).max() < 0.001


def test_a_sliding_wall_drags_the_fluid_as_couette_says():
    scene, x, v = flow("couette", 20, 0.8)
    assert scene.walls.right.velocity == [0.0, 1.0]
    np.testing.assert_allclose(v[:, 1], couette_profile(x, 0.8, 1.0, 1.0, 1.0), atol=2e-3)
    assert np.abs(v[:, 0]).max() < 1e-3


def test_particles_that_begin_in_disorder_keep_to_the_profile():
    """With shifting; the same whether or not they are on a lattice, up to the noise that disorder makes."""
    simulation = build(load_scene("poiseuille", {"time.end": 0.3, "gauges": []}))
    shake(simulation, 0.1 * 0.025)
    simulation.run()
    x, v = simulation.field("position")[:, 0], simulation.field("velocity")
    np.testing.assert_allclose(v[:, 1], -poiseuille_profile(x, 0.3, 1.0, 1.0, 8.0), atol=0.015)
    assert np.abs(v[:, 0]).max() < 0.015


def test_a_finer_channel_is_better_by_the_square():
    errors = []
    for across in (10, 20):
        _, x, v = flow("poiseuille", across, 0.2)
        errors.append(np.abs(v[:, 1] + poiseuille_profile(x, 0.2, 1.0, 1.0, 8.0)).max())
    assert errors[0] / errors[1] > 3


def test_still_viscous_water_stays_still():
    """Hydrostatic pressure, no slip all around: nothing drives a flow along the walls."""
    walls = {side: {"slip": "no"} for side in ("left", "right", "bottom")}
    numerics = {"dx": 0.02, "diffusion": "fourtakas", "viscosity": "newtonian", "nu": 1e-3}
    simulation = build(load_scene(tank(walls=walls, numerics=numerics, time={"end": 0.3})))
    simulation.run()
    assert np.abs(simulation.field("velocity")).max() < 0.02 * math.sqrt(9.81 * 0.2)


@pytest.mark.parametrize("dim", [1, 2])
def test_sound_is_damped_by_four_thirds_of_the_viscosity(dim):
    """A standing wave between walls decays with ``exp(-2/3 nu k^2 t)``, in a line as in a plane: no bulk viscosity."""
    c0, nu, k = 10.0, 0.05, math.pi
    size = [1.0, 0.2][:dim]
    keys = {
        "domain": {"size": size, "gravity": 0.0, "periodic": ["up"] * (dim > 1)},
        "fluid": {"blocks": [{"low": [0.0] * dim, "high": size, "pressure": 0.0}]},
        "walls": {"left": {}, "right": {}},
        "numerics": {"dx": 0.02, "c0": c0, "state": "linear", "viscosity": "newtonian", "nu": nu},
        "time": {"end": 1.0},
    }

    def amplitude(simulation):
        x = simulation.field("position")[:, 0]
        velocity = 2 * (simulation.field("velocity")[:, 0] * np.sin(k * x)).mean()
        return math.hypot(velocity, 2 * c0 / RHO0 * (simulation.field("density") * np.cos(k * x)).mean())

    left = {}
    for viscosity in ("newtonian", "none"):
        keys["numerics"].update(viscosity=viscosity, nu=nu if viscosity == "newtonian" else None)
        simulation = build(load_scene(keys))
        p = simulation.particles
        p.shared[p.fluid, dim] = 0.01 * np.sin(k * p.field("position", p.fluid)[:, 0])
        simulation.run()
        left[viscosity] = amplitude(simulation) / 0.01
    assert left["none"] == pytest.approx(1.0, abs=0.05)
    assert math.log(left["none"] / left["newtonian"]) == pytest.approx(2 / 3 * nu * k**2, rel=0.03)


def test_the_channel_meets_its_bars():
    for case, bars in (("poiseuille", 2), ("couette", 2)):
        rows = list(CASES[case](True))
        assert sum(bar is not None for *_, bar in rows) == bars
        assert all(abs(value) <= bar for _, value, _, bar in rows if bar is not None)
        (transient,) = (value for metric, value, *_ in rows if "transient" in metric)
        assert transient < 1.0


def test_plan_names_what_the_scene_does(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")
    numerics = {"numerics.xsph": 0.5, "numerics.xsph_continuity": True, "numerics.shifting": "none"}
    overrides = {"walls.exchange": True, **numerics}
    print_plan(load_scene("couette", overrides), "couette")
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    for words in ("Jones et al. (2010) eq. (5)", "slides with (0, 1) m/s", "periodic", "changes places", "smoothed velocity G"):
        assert words in text
    assert "strain_rate [1/s]" in text


# --- velocity smoothing in the continuity equation -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("dim", "single", "viscosity"),
    [*((dim, False, "none") for dim in CELLS), (2, True, "newtonian"), (3, False, "newtonian")],
)
def test_continuity_has_the_smoothed_velocity(dim, single, viscosity):
    """``drho_a/dt = sum_b m_b (v + s)_ab . x_ab F`` with the smoothing s that rows carry; the force has v alone."""
    features = ("verlet", viscosity, "xsph_continuity")
    terms = Terms(density=SMOOTHED_CONTINUITY, viscosity=VISCOSITIES[viscosity], smoothing=XSPH)
    nu = NU if viscosity == "newtonian" else 0.0
    numbers = {"epsilon": 0.5, "single": single, "nu": nu}
    sweep = Sweep(KERNELS["wendland-c2"], terms, dim, 1.4 * DX, RHO0, C0, (0.0,) * dim, **numbers)
    fields = block(dim, features)
    x_ab, v_ab, _, F = pairs(fields, sweep)
    s_ab = fields["smoothing"][:, None] - fields["smoothing"]
    expected = np.einsum("ab,abi,abi->a", F * fields["mass"], v_ab + s_ab, x_ab)
    found, tolerance = rates(fields, sweep, features), 1e-4 if single else 2e-12
    np.testing.assert_allclose(found.density_rate, expected, rtol=0, atol=tolerance * np.abs(expected).max())
    force = viscous_force(fields, sweep) if nu else 0.0 * fields["velocity"]
    np.testing.assert_allclose(found.acceleration, force, rtol=0, atol=tolerance * np.abs(force).max())


def test_rows_carry_the_smoothing_that_particles_move_with():
    keys = tank()
    keys["numerics"].update(xsph=0.5, xsph_continuity=True)
    simulation = build(load_scene(keys, {"fluid.blocks.0.initial": "seiche", "fluid.blocks.0.amplitude": 0.02}))
    simulation.run()
    p = simulation.particles
    np.testing.assert_array_equal(p.field("smoothing", p.fluid), p.drift[p.fluid])
    assert np.abs(p.drift[p.fluid]).max() > 0
    without = build(load_scene(tank(numerics={**keys["numerics"], "xsph_continuity": False})))
    assert without.sweep.terms.density.name == "continuity"
    assert simulation.sweep.terms.density is SMOOTHED_CONTINUITY


def test_smoothed_continuity_changes_a_seiche_a_little():
    """And is the plain one where epsilon is next to nothing."""
    densities = {}
    for epsilon, smoothed in ((0.5, False), (0.5, True), (1e-12, True), (1e-12, False)):
        numerics = {"numerics.xsph": epsilon, "numerics.xsph_continuity": smoothed}
        simulation = build(load_scene("seiche", {"time.end": 0.02, "gauges": [], **numerics}))
        simulation.run()
        densities[epsilon, smoothed] = simulation.field("density")[np.argsort(simulation.field("id"))]
    assert 1e-3 < np.abs(densities[0.5, True] - densities[0.5, False]).max() < 5
    np.testing.assert_allclose(densities[1e-12, True], densities[1e-12, False], rtol=1e-9)


# --- summed densities ----------------------------------------------------------------------------------------------


def full_box(dim, **numerics):
    """Return a scene of a box full of fluid between mirror walls."""
    size = [0.4, 0.3, 0.5][:dim] if dim == 3 else [0.4, 0.5][:dim]
    sides = ("left", "right", *("front", "back") * (dim == 3), *("bottom", "top") * (dim > 1))
    keys = {"dx": 0.05, "c0": 20.0, "density": "summation", "density_range": [0.5, 1.4], **numerics}
    return load_scene(
        {
            "domain": {"size": size, "gravity": 0.0},
            "fluid": {"blocks": [{"low": [0.0] * dim, "high": size, "pressure": 3000.0}]},
            "walls": {side: {} for side in sides},
            "numerics": keys,
            "time": {"end": 0.02},
        }
    )


@pytest.mark.parametrize("dim", CELLS)
@pytest.mark.parametrize("kernel", ["wendland-c2", "cubic-spline"])
@pytest.mark.parametrize("h_over_dx", [1.3, 1.7])
def test_sums_on_a_lattice_give_the_density_that_was_asked_for(dim, kernel, h_over_dx):
    simulation = build(full_box(dim, kernel=kernel, h_over_dx=h_over_dx))
    wanted = simulation.field("density")
    simulation.evaluate(0.0)
    p = simulation.particles
    np.testing.assert_allclose(p.density_rate[p.fluid], wanted, rtol=1e-12)
    assert wanted[0] > 1001
    simulation.run()
    np.testing.assert_allclose(simulation.field("density"), wanted, rtol=1e-12)
    assert np.abs(simulation.field("velocity")).max() < 1e-9


@pytest.mark.parametrize("dim", [2, 3])
def test_summed_densities_of_any_dimension_are_the_sum_over_all_pairs(dim):
    fields = block(dim, ("verlet",))
    sweep = full_box(dim)
    terms = build(sweep).sweep.terms
    sweep = Sweep(KERNELS["wendland-c2"], terms, dim, 1.4 * DX, RHO0, C0, (0.0,) * dim)
    _, _, r, _ = pairs(fields, sweep)
    expected = (fields["mass"] * sweep.kernel.value(r / sweep.h, 1.0, dim) / sweep.h**dim).sum(axis=1)
    np.testing.assert_allclose(rates(fields, sweep, ("verlet",)).density_rate, expected, rtol=1e-12)


def test_a_channel_runs_with_summed_densities():
    numerics = {"numerics.density": "summation", "numerics.density_range": [0.8, 1.2], "numerics.diffusion": "none"}
    _, x, v = flow("poiseuille", 20, 0.2, **numerics)
    np.testing.assert_allclose(v[:, 1], -poiseuille_profile(x, 0.2, 1.0, 1.0, 8.0), atol=0.035)


# --- exchange with images ------------------------------------------------------------------------------------------


def lone(**sections):
    """Return a particle in a closed box of 0.2 m, as good as without pressure; times in sections."""
    walls = {side: {} for side in ("left", "right", "bottom", "top")}
    numerics = {"dx": 0.01, "c0": 0.01, "state": "linear", "density_range": [0.1, 4.0]}
    keys = {
        "domain": {"size": [0.2, 0.2], "gravity": 0.0},
        "fluid": {"blocks": [{"low": [0.1, 0.1], "high": [0.11, 0.11], "pressure": 0.0}]},
        "walls": {**walls, "exchange": True, **sections.get("walls", {})},
        "numerics": {**numerics, **sections.get("numerics", {})},
        "time": {"end": 1.0, "dt": 0.003},
    }
    return load_scene(keys)


def thrown(scene, velocity):
    """Run a scene whose fluid is thrown with `velocity` [m/s]."""
    simulation = build(scene)
    p = simulation.particles
    p.shared[p.fluid, p.layout.columns("velocity")[1]] = velocity
    simulation.run()
    return simulation


@pytest.mark.parametrize("integrator", ["verlet", "midpoint"])
@pytest.mark.parametrize("treatment", ["mirror-plain", "mirror"])
def test_a_thrown_particle_bounces_and_is_counted(integrator, treatment):
    """Billiards: positions fold at the walls, |v| stays, and walls count their bounces; corners come by at t = 0.1 s."""
    speed, walls = np.array([2.0, 1.3]), {side: {} for side in ("left", "right", "bottom", "top")} | {"treatment": treatment}
    simulation = thrown(lone(walls=walls, numerics={"integrator": integrator}), speed)
    way = (0.105 + speed) / 0.2
    bounces, place = np.floor(way).astype(int), way % 1
    expected = 0.2 * np.where(bounces % 2, 1 - place, place)
    np.testing.assert_allclose(simulation.field("position")[0], expected, atol=1e-5)
    np.testing.assert_allclose(simulation.field("velocity")[0], speed * (-1.0) ** bounces, atol=1e-4)
    counts = {wall.name: wall.exchanged for wall in simulation.domain.walls}
    assert counts == {
        "left": bounces[0] // 2,
        "right": (bounces[0] + 1) // 2,
        "bottom": bounces[1] // 2,
        "top": (bounces[1] + 1) // 2,
    }


@pytest.mark.parametrize("integrator", ["verlet", "midpoint", "adams-bashforth"])
def test_a_particle_thrown_into_a_corner_comes_back_the_way_it_came(integrator):
    simulation = thrown(lone(numerics={"integrator": integrator}), [1.9, 1.9])
    x, y = simulation.field("position")[0]
    assert x == pytest.approx(y, abs=1e-9)
    assert {wall.exchanged for wall in simulation.domain.walls} == {5}


@pytest.mark.parametrize("integrator", ["verlet", "midpoint"])
def test_exchange_at_no_slip_reverses_the_whole_velocity(integrator):
    """It takes the velocity of the image, as it stands: back along its own way."""
    walls = {side: {"slip": "no"} for side in ("left", "right", "bottom", "top")}
    scene = load_scene(
        lone(walls=walls, numerics={"integrator": integrator}).model_dump(exclude_unset=True), {"time.end": 0.06}
    )
    simulation = thrown(scene, [2.0, 0.5])
    np.testing.assert_allclose(simulation.field("velocity")[0], [-2.0, -0.5], atol=1e-3)
    assert [wall.exchanged for wall in simulation.domain.walls] == [0, 1, 0, 0]


def test_without_exchange_a_particle_behind_a_wall_ends_the_run():
    with pytest.raises(RunError, match="particle 0 crossed the right wall"):
        thrown(lone(walls={"exchange": False}), [2.0, 0.0])


def test_fluid_deep_behind_a_wall_is_lost_all_the_same():
    """Farther than its support it has no image that could take its place."""
    with pytest.raises(RunError, match="particle 0 crossed the right wall"):
        thrown(lone(), [200.0, 0.0])


PLATE = Flap((0.0, 0.0), Oscillation(math.radians(8), 1.7))


@pytest.mark.parametrize("slip", SLIPS)
@pytest.mark.parametrize("features", [("verlet",), ("adams-bashforth",), ("midpoint", "newtonian", "xsph_continuity")])
def test_exchange_at_a_moving_plate_is_the_map_of_its_images(slip, features):
    """Fluid in front of the plate seen from behind is where, and what, the images of the plate are; so is its beginning."""
    time, rng = 0.31, np.random.default_rng(6)
    wall, behind = (MirrorWall("left", (0.0, 0.0), (side, 0.0), "plain", slip, 1, motion=PLATE) for side in (1.0, -1.0))
    position = np.stack([rng.uniform(-0.15, -0.01, 20), rng.uniform(0.2, 0.9, 20)], axis=1)
    angle = PLATE.signal.at(time)[0]
    position[:, 0] += position[:, 1] * math.tan(angle)
    fields = {"position": position, "velocity": rng.normal(0, 1, (20, 2))}
    if "newtonian" in features:
        fields |= {"strain_rate": rng.normal(0, 1, (20, 3)), "smoothing": rng.normal(0, 1, (20, 2))}
    grid = Grid.around((-1.0, -1.0), (2.0, 2.0), 0.25)
    images = domain_of(grid, fields, [behind], reach=REACH, features=features)
    images.arrange(time)
    rows, _ = images_of(images)
    by_parent = rows[np.argsort(identities(images.particles.tags[rows]))]
    domain = domain_of(grid, fields, [wall], reach=REACH, features=features, exchanging=True)
    p = domain.particles
    dim = 2
    p.private[:20, :dim] = fields["velocity"]
    if "midpoint" in features:
        p.private[:20, dim + 1 :] = fields["position"]
    domain.keep_inside(time)
    assert wall.exchanged == 20 == len(rows)
    for name in fields:
        np.testing.assert_allclose(p.field(name, slice(0, 20)), images.particles.field(name, by_parent), atol=1e-13)
    np.testing.assert_array_equal(p.field("start_velocity", slice(0, 20)), p.field("velocity", slice(0, 20)))
    if "midpoint" in features:
        np.testing.assert_allclose(p.field("start_position", slice(0, 20)), p.field("position", slice(0, 20)), atol=1e-15)


def test_a_particle_in_a_corner_that_leans_ends_in_front_of_both_walls():
    """Its image at the bed is behind the plate again, which takes its turn."""
    time = 0.31
    plate = MirrorWall("left", (0.0, 0.0), (1.0, 0.0), "plain", "free", 1, motion=PLATE)
    bed = MirrorWall("bottom", (0.0, 0.0), (0.0, 1.0), "plain", "free", 2)
    slope = math.tan(PLATE.signal.at(time)[0])
    position = np.array([[0.5 * slope * 0.05, -0.05]])
    grid = Grid.around((-1.0, -1.0), (2.0, 2.0), 0.25)
    domain = domain_of(grid, {"position": position}, [plate, bed], reach=REACH, exchanging=True)
    domain.arrange(time)
    place = domain.particles.field("position", domain.particles.fluid)[0]
    assert plate.distance(place) > 0
    assert bed.distance(place) > 0
    assert (plate.exchanged, bed.exchanged) == (1, 1)


def test_no_particle_is_seen_behind_a_wall():
    """A seiche with the plain law, whose bed attracts the lowest row, at the largest step; energies do not grow."""
    overrides = {
        "walls.exchange": True,
        "walls.treatment": "mirror-plain",
        "numerics.diffusion": "none",
        "fluid.blocks.0.amplitude": 0.02,
        "time.end": 0.3,
        "numerics.density_range": [0.3, 2.0],
    }
    simulation = build(load_scene("seiche", overrides))
    simulation.prepare()
    while simulation.time < simulation.end:
        simulation.advance()
        position = simulation.field("position")
        assert (position >= 0).all()
        assert (position[:, 0] <= 0.2).all()
    assert len(np.unique(simulation.field("id"))) == 400


def test_the_summary_says_how_often_particles_changed_places(tmp_path, capsys):
    overrides = {"walls.exchange": True, "numerics.dx": 0.02, "time.end": 0.02, "gauges": []}
    finished = run("still", overrides, tmp_path / "with")
    assert finished.summary["walls"]["exchanged"] == {"left": 0, "right": 0, "bottom": 0}
    assert json.loads((tmp_path / "with" / "summary.json").read_text())["walls"] == finished.summary["walls"]
    assert "changed places with its image: left 0, right 0, bottom 0" in " ".join(capsys.readouterr().out.split())
    assert "walls" not in run("still", {**overrides, "walls.exchange": False}, tmp_path / "without").summary


# --- faults --------------------------------------------------------------------------------------------------------


CHANNEL = load_scene("poiseuille").model_dump(exclude_unset=True)
FAULTS = {
    "newtonian without nu": ({"numerics.nu": None}, "numerics.nu: is missing"),
    "nu without newtonian": ({"numerics.viscosity": "monaghan"}, "numerics.nu: has no meaning here"),
    "velocity of free slip": ({"walls.left": {"velocity": [0.0, 1.0]}}, "walls.left.velocity: is felt by nothing"),
    "velocity out of its plane": (
        {"walls.left": {"slip": "no", "velocity": [0.1, 1.0]}},
        "walls.left.velocity: moves the wall out of its plane",
    ),
    "velocity of three components": (
        {"walls.left": {"slip": "no", "velocity": [0.0, 1.0, 0.0]}},
        "walls.left.velocity: has 3 components",
    ),
    "a bottom": ({"walls.bottom": {}}, "walls.bottom: there is no such side"),
    "a top": ({"walls.top": {}}, "walls.top: there is no such side"),
    "a level gauge": ({"gauges": [{"kind": "level", "x": 0.5}]}, "gauges.0: there is no surface"),
    "fourtakas": ({"numerics.diffusion": "fourtakas"}, "numerics.diffusion: needs a column of water"),
    "antuono": ({"numerics.diffusion": "antuono"}, "numerics.diffusion: needs a column of water"),
    "too low": ({"domain.size": [1.0, 0.199]}, "domain.size: 0.199 m are too few"),
    "no pressure": ({"fluid.blocks": [{"low": [0, 0], "high": [1, 0.2]}]}, "fluid.blocks.0.pressure: is missing"),
    "no sound speed": ({"numerics.c0": None}, "numerics.c0: is missing"),
    "a wavemaker": (
        {"wavemaker": {"wave": {"kind": "oscillation", "angle": 3.0, "period": 1.0}}},
        "wavemaker: there is no bed to hinge it at",
    ),
    "up twice": ({"domain.periodic": ["up", "up"]}, "domain.periodic: names an axis twice"),
    "an axis that is none": ({"domain.periodic": ["z"]}, "domain.periodic.0"),
    "a seiche": ({"fluid.blocks.0.initial": "seiche"}, "fluid.blocks.0.initial: cannot begin so"),
    "damped densities": (
        {"damping": [{"length": 0.3, "density": "plain"}]},
        "damping.0.density: needs a surface",
    ),
    "summation without a range": ({"numerics.density": "summation"}, "numerics.density: does not fit the usual range"),
    "summation with diffusion": (
        {"numerics.density": "summation", "numerics.density_range": [0.5, 1.2], "numerics.diffusion": "molteni"},
        "numerics.diffusion: has nothing to act on",
    ),
    "summation with spray": (
        {"numerics.density": "summation", "numerics.density_range": [0.5, 1.2], "numerics.spray": "pressureless"},
        "numerics.spray: has nothing to act on",
    ),
    "smoothed continuity without smoothing": ({"numerics.xsph_continuity": True}, "numerics.xsph: does not go with"),
    "smoothed continuity with shifting": (
        {"numerics.xsph_continuity": True, "numerics.xsph": 0.5, "numerics.shifting": "lind"},
        "numerics.shifting: does not go with",
    ),
    "smoothed continuity of sums": (
        {
            "numerics.xsph_continuity": True,
            "numerics.xsph": 0.5,
            "numerics.density": "summation",
            "numerics.density_range": [0.5, 1.2],
        },
        "numerics.density: does not go with",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_what_does_not_fit_together_is_refused(name):
    overrides, text = FAULTS[name]
    with pytest.raises(SceneError) as caught:
        load_scene(CHANNEL, overrides)
    assert text in str(caught.value)


def test_newtonian_viscosity_is_refused_at_polygon_walls():
    polygon = {"points": [[0.0, 0.3], [0.0, 0.0], [0.2, 0.0], [0.2, 0.3]]}
    keys = tank(walls={"polygons": [polygon]}, numerics={"dx": 0.01, "viscosity": "newtonian", "nu": 1e-3})
    with pytest.raises(SceneError, match=r"numerics\.viscosity: needs mirror walls.*carry no strain rate"):
        load_scene(keys)


def test_polygon_walls_are_refused_where_the_vertical_is_periodic():
    polygon = {"points": [[0.0, 0.25], [0.0, 0.0]], "fluid": "right"}
    overrides = {"walls.polygons": [polygon], "numerics.viscosity": "none", "numerics.nu": None, "walls.left": None}
    with pytest.raises(SceneError, match=r"walls\.polygons"):
        load_scene(CHANNEL, overrides)


def test_a_plate_cannot_slide():
    with pytest.raises(SceneError, match=r"walls\.left\.velocity: this wall is moved already"):
        load_scene("pool", {"walls.left": {"slip": "no", "velocity": [0.0, 1.0]}})


def test_channels_are_built_in():
    assert {"poiseuille", "couette"} <= set(builtin_names())
