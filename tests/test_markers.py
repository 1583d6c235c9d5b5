"""Walls of markers: repulsion, correction of the boundary deficiency, walls that move and bulge."""

import math

import numpy as np
import pytest
from helpers import SOME_KERNELS, parsph, settings

from parsph.errors import SceneFaults
from parsph.kernels import KERNELS
from parsph.parallel import Communicator
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.walls import REPULSIONS, WEIGHTS, Line, Markers
from parsph.walls.deficiency import jones_weight, outer_integral, outer_integrals, sample_weight
from parsph.walls.repulsion import repulsion
from parsph.wavemakers import Bulge

LAWS = {name: law for name, law in REPULSIONS.items() if law.code}
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
every_kernel = pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)


# --- repulsion -----------------------------------------------------------------------------------------------------


@every_law
def test_repulsion_pushes_the_harder_the_nearer_and_ends_at_its_reach(law):
    spacing, reach = 0.01, 0.03
    r = np.linspace(1.02 * spacing, reach, 200)
    force = np.array([repulsion(law.code, x, reach, spacing) for x in r])
    assert (force[:-1] > 0).all()
    assert (np.diff(force) < 0).all()
    assert force[-1] == pytest.approx(0, abs=1e-9 * force[0])
    assert all(repulsion(law.code, x, reach, spacing) == 0 for x in (reach, 1.001 * reach, 9.0))
    assert np.isfinite(repulsion(law.code, 0.0, reach, spacing))


def test_monaghan_kajtar_is_that_of_the_paper():
    """Phi(q) / (r - d) with Phi = 1.77/32 (1 + 5q/2 + 2 q^2)(2 - q)^5, q = r/h and the support 2h as the reach."""
    h, spacing, r = 0.02, 0.005, 0.013
    q = r / h
    expected = 1.77 / 32 * (1 + 2.5 * q + 2 * q**2) * (2 - q) ** 5 / (r - spacing)
    assert repulsion(REPULSIONS["monaghan-kajtar"].code, r, 2 * h, spacing) == pytest.approx(expected, rel=1e-12)


def test_lennard_jones_is_that_of_the_paper():
    """((r0/r)^4 - (r0/r)^2) / r."""
    expected = ((0.02 / 0.013) ** 4 - (0.02 / 0.013) ** 2) / 0.013
    assert repulsion(REPULSIONS["lennard-jones"].code, 0.013, 0.02, 0.005) == pytest.approx(expected, rel=1e-12)


def test_a_particle_that_slides_along_a_wall_feels_no_bumps():
    """Monaghan & Kajtar, three markers per particle: the force along the wall is nothing, that off it hardly varies."""
    dx, code = 0.01, REPULSIONS["monaghan-kajtar"].code
    marker = np.arange(-300, 301) * dx / 3
    pushes, drags = [], []
    for s in np.linspace(0, dx / 3, 21):
        r = np.hypot(s - marker, 0.7 * dx)
        force = np.array([repulsion(code, x, 2 * dx, dx / 3) for x in r])
        pushes.append((force * 0.7 * dx / r).sum())
        drags.append((force * (s - marker) / r).sum())
    assert np.ptp(pushes) < 0.01 * np.mean(pushes)
    assert np.abs(drags).max() < 0.01 * np.mean(pushes)


# --- weights -------------------------------------------------------------------------------------------------------


def test_weight_is_that_of_the_paper():
    """Jones et al. (2010) eq. (8): activation^2 + (glancing^2 + 1/2) distance."""
    expected = (0.25 / 0.4) ** 2 + (0.6**2 + 0.5) * (1 - 0.4 / 0.775)
    assert jones_weight(0.4, 0.6, 0.25, 0.775) == pytest.approx(expected, rel=1e-12)


def test_near_particles_count_most_and_those_beyond_the_sample_not_at_all():
    counts = [sample_weight(r**2, 1.0) for r in np.linspace(0, 1.2, 50)]
    assert counts[0] == 1
    assert (np.diff(counts) <= 0).all()
    assert sample_weight(1.0, 1.0) == 0


@every_kernel
@pytest.mark.parametrize("dim", [1, 2, 3])
def test_what_is_left_of_a_kernel_beyond_a_radius_is_its_integral(kernel, dim):
    from scipy.integrate import quad

    tails, norm = outer_integrals(kernel, dim), kernel.norms[dim - 1]
    for q in (0.0, 0.31, 0.9, 1.4, kernel.support - 0.01):
        expected, _ = quad(lambda x: kernel.value(x, 1.0, dim) / norm * x ** (dim - 1), q, kernel.support)
        assert outer_integral(tails, q) == pytest.approx(expected, abs=3e-5 * outer_integral(tails, 0.0))
    assert outer_integral(tails, kernel.support) == 0
    assert outer_integral(tails, 99.0) == 0


def tank(**overrides):
    keys = {"walls.repulsion": "none", "numerics.dx": 0.1, "numerics.h_over_dx": 2.5, "gauges": [], **overrides}
    return load_scene("tank-rectangle", keys)


def corrected(scene):
    """Return (simulation, positions, accelerations before, after) of a scene at its beginning."""
    simulation = build(scene, Communicator())
    p, markers = simulation.particles, simulation.domain.markers
    simulation.domain.markers = None
    simulation.evaluate(0.0)
    before = p.acceleration[p.fluid].copy()
    simulation.domain.markers = markers
    simulation.evaluate(0.0)
    return simulation, simulation.field("position"), before, p.acceleration[p.fluid].copy()


@pytest.mark.parametrize("kernel", [KERNELS[name] for name in SOME_KERNELS], ids=SOME_KERNELS)
def test_sums_over_markers_are_what_the_kernel_lacks_behind_the_walls(kernel):
    """S_i is the integral of W n along the wall and gamma_i that of W over the tank, beside walls and in corners."""
    simulation, x, _, _ = corrected(
        tank(**{"numerics.kernel": kernel.name, "numerics.h_over_dx": 2.0, "walls.markers_per_dx": 10})
    )
    sums, h, reach = simulation.domain.markers.sums[simulation.particles.fluid], simulation.sweep.h, 0.2 * kernel.support
    step = 0.01
    axis = step * (np.arange(-int(reach / step) - 1, int(reach / step) + 1) + 0.5)
    ax, ay = np.meshgrid(axis, axis, indexing="ij")
    weight = kernel.value(np.hypot(ax, ay), h, 2) * step**2
    for place in ((0.05, 1.05), (0.15, 1.05), (0.05, 0.05), (1.55, 0.15), (2.95, 1.85)):
        i = np.linalg.norm(x - place, axis=1).argmin()
        inside = (x[i, 0] + ax > 0) & (x[i, 0] + ax < 3) & (x[i, 1] + ay > 0) & (x[i, 1] + ay < 2)
        assert sums[i, 2] == pytest.approx(weight[inside].sum(), abs=5e-3), place
        for d, (wall, side) in enumerate(((0.0, 1), (0.0, 1))):
            wall, side = (3.0, -1) if d == 0 and x[i, 0] > 1.5 else (2.0, -1) if d == 1 and x[i, 1] > 1 else (wall, side)
            along = x[i, 1 - d] + axis
            on = (along > 0) & (along < (2.0 if d == 0 else 3.0))
            expected = side * (kernel.value(np.hypot(x[i, d] - wall, axis[on]), h, 2) * step).sum()
            assert sums[i, d] == pytest.approx(expected, abs=0.02 * kernel.value(0.0, h, 2) * h), place


def test_moments_give_back_what_constant_pressure_lacks_in_corners_too():
    _, x, before, after = corrected(tank())
    distance = np.minimum(np.minimum(x, [3.0, 2.0] - x)[:, 0], np.minimum(x, [3.0, 2.0] - x)[:, 1])
    near = distance < 0.5
    corner = near & (np.minimum(x, [3.0, 2.0] - x).max(axis=1) < 0.5)
    for rows in (near & ~corner, corner):
        assert rows.sum() > 20
        size = [np.sqrt((a[rows] ** 2).sum(axis=1).mean()) for a in (before, after)]
        assert size[1] < 0.1 * size[0]


def test_weights_as_printed_give_back_less():
    """They share C_j among markers by W_ij, which falls off faster from a marker than the deficiency does from a wall."""
    sizes = {}
    for name in WEIGHTS:
        _, _, before, after = corrected(tank(**{"walls.weights": name}))
        sizes[name] = math.sqrt((after**2).sum() / (before**2).sum())
    assert sizes["moments"] < 0.1
    assert 0.1 < sizes["jones2010"] < 0.5


@pytest.mark.parametrize("name", WEIGHTS)
def test_one_end_in_one_dimension_needs_no_weights(name):
    """With one marker in reach both forms are C W_ij: the deficiency of constant pressure is proportional to the kernel."""
    _, x, before, after = corrected(load_scene("column-1d", {"walls.repulsion": "none", "walls.weights": name}))
    near = (x[:, 0] < 1) | (x[:, 0] > 3)
    assert np.abs(after[near]).max() < 0.05 * np.abs(before[near]).max()
    kernel = KERNELS["cubic-spline"].value(x[:10, 0], 0.5, 1)
    np.testing.assert_allclose(before[:10, 0] / before[0, 0], kernel / kernel[0], atol=0.03)


@pytest.mark.parametrize("name", WEIGHTS)
def test_fluid_beside_a_wall_is_accelerated_as_the_wall_is(name):
    """A row of particles at rest, a wall that is accelerated: the mean acceleration along the normal becomes the wall's."""
    simulation = build(tank(**{"walls.weights": name}), Communicator())
    markers = simulation.domain.markers
    markers.wall[:, 2:] = [0.0, 0.7]
    simulation.evaluate(0.0)
    p = simulation.particles
    x, a = simulation.field("position"), p.acceleration[p.fluid]
    lowest = (x[:, 1] < 0.1) & (np.abs(x[:, 0] - 1.5) < 0.6)
    assert lowest.sum() > 8
    if name == "moments":
        np.testing.assert_allclose(a[lowest, 1], 0.7, rtol=0.1)
    else:
        assert (a[lowest, 1] > 0.3).all()


def test_fluid_that_is_pulled_off_a_wall_is_not_held():
    """Gravity upwards off the bed of a tank without pressure: no strength pulls."""
    scene = tank(**{"fluid.blocks.0.pressure": 0.0, "domain.gravity": 9.81, "numerics.c0": 30.0})
    simulation = build(scene, Communicator())
    simulation.evaluate(0.0)
    markers, p = simulation.domain.markers, simulation.particles
    top = np.isclose(markers.position[:, 1], 2.0)
    assert (markers.strength <= 0).all()
    assert np.abs(markers.strength[top]).max() < 1e-3 * np.abs(markers.strength).max()
    x = simulation.field("position")
    high = (x[:, 1] > 1.9) & (np.abs(x[:, 0] - 1.5) < 0.5)
    np.testing.assert_allclose(p.acceleration[p.fluid][high, 1], -9.81, rtol=1e-3)


def test_velocities_off_and_into_the_wall_decay():
    """Relaxation of the relative normal velocity, with moments alone."""
    accelerations = {}
    for speed in (-0.1, 0.0, 0.1):
        simulation = build(tank(), Communicator())
        p = simulation.particles
        p.shared[p.first : p.last, 3] = speed
        simulation.evaluate(0.0)
        x = simulation.field("position")
        bed = (x[:, 1] < 0.1) & (np.abs(x[:, 0] - 1.5) < 0.6)
        accelerations[speed] = p.acceleration[p.fluid][bed, 1].mean()
    assert accelerations[-0.1] > accelerations[0.0] + 0.01
    assert accelerations[0.1] < accelerations[0.0]


def test_summed_densities_are_whole_beside_walls():
    """Without its share of the kernel a sum falls to a half at a wall, to a quarter in a corner."""
    keys = {"numerics.density": "summation", "numerics.density_range": [0.1, 5.0], "numerics.diffusion": "none"}
    simulation, _, _, _ = corrected(tank(**keys))
    p = simulation.particles
    density = p.density_rate[p.fluid]
    np.testing.assert_allclose(density, 1000.0, rtol=0.03)
    simulation.domain.markers = None
    simulation.evaluate(0.0)
    assert p.density_rate[p.fluid].min() < 500


# --- markers -------------------------------------------------------------------------------------------------------


def test_markers_stand_on_the_walls_with_normals_into_the_fluid():
    markers = build(tank(**{"walls.markers_per_dx": 4}), Communicator()).domain.markers
    assert markers.count == 4 * 2 * (30 + 20)
    middle = np.array([1.5, 1.0])
    assert ((markers.position - middle) * markers.normal).sum(axis=1).max() < 0
    np.testing.assert_allclose(np.linalg.norm(markers.normal, axis=1), 1)
    np.testing.assert_allclose(markers.size, 0.025)


BULGE = Bulge((0.2, 0.1), (1.2, 0.1), 0.1, 0.8, 0.3, 0.2)


@pytest.mark.parametrize("depth", [0.0, -0.05, 0.05])
def test_a_bulging_wall_takes_its_points_along_its_normal(depth):
    now = BULGE.at(0.7)
    s = np.linspace(0.21, 1.19, 41)
    rest = np.stack([s, np.full(41, 0.1 + depth)], axis=1)
    surface = now.place(np.stack([s, np.full(41, 0.1)], axis=1))
    normal = now.turn(np.tile([0.0, 1.0], (41, 1)), rest)
    np.testing.assert_allclose(now.place(rest), surface + depth * normal, atol=1e-12)
    tangent = np.gradient(surface, axis=0)
    assert np.abs((tangent * normal).sum(axis=1)[1:-1]).max() < 2e-3 * np.linalg.norm(tangent, axis=1).max()
    np.testing.assert_allclose(surface[20], [0.7, 0.1 + now.amplitude], atol=1e-12)


def test_a_bulging_wall_grows_longer():
    now = BULGE.at(0.7)
    s = np.linspace(0.2, 1.2, 4001)
    line = now.place(np.stack([s, np.full(4001, 0.1)], axis=1))
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    middle = np.stack([0.5 * (s[1:] + s[:-1]), np.full(4000, 0.1)], axis=1)
    assert length > 1.01
    assert now.stretch(middle).mean() == pytest.approx(length, rel=1e-6)


def test_velocity_and_acceleration_of_a_bulging_wall_are_derivatives():
    rest, time, step = np.array([[0.3, 0.1], [0.7, 0.1], [1.0, 0.1]]), 0.55, 1e-4
    before, now, after = (BULGE.at(t).place(rest) for t in (time - step, time, time + step))
    np.testing.assert_allclose(BULGE.at(time).velocity(now), (after - before) / (2 * step), atol=1e-5)
    np.testing.assert_allclose(BULGE.at(time).acceleration(now), (after - 2 * now + before) / step**2, atol=1e-4)


def test_what_is_no_part_of_a_bulging_edge_stays():
    now = BULGE.at(0.7)
    elsewhere = np.array([[0.1, 0.1], [1.3, 0.1], [0.2, 0.1], [1.2, 0.1], [0.7, 0.4]])
    np.testing.assert_allclose(now.place(elsewhere), elsewhere, atol=1e-15)
    np.testing.assert_allclose(now.turn(np.ones((5, 2)), elsewhere), 1, atol=1e-15)
    np.testing.assert_array_equal(now.stretch(elsewhere), 1)


def test_markers_follow_a_bulging_wall():
    scene = load_scene("bulging-wall", {"numerics.dx": 0.02})
    markers = build(scene, Communicator()).domain.markers
    rest, length = markers.position.copy(), markers.size.sum()
    markers.move(1.125)  # three quarters of a period, the ramp over: out of the fluid by the whole amplitude
    bed = np.isclose(rest[:, 1], 0.1)
    assert (markers.position[bed, 1] - 0.1).min() == pytest.approx(-0.06, rel=0.01)
    np.testing.assert_array_equal(markers.position[~bed], rest[~bed])
    assert markers.size.sum() > length
    np.testing.assert_allclose(np.linalg.norm(markers.normal, axis=1), 1)


def test_strengths_need_fluid():
    """A marker without fluid near it has none, and fluid out of reach of all markers is left alone."""
    kernel = KERNELS["wendland-c2"]
    line = Line(np.array([[50.0, 50.0]]), np.array([[0.0, 1.0]]), np.ones(1))
    markers = Markers(
        [line], WEIGHTS["moments"], LAWS["monaghan-kajtar"], kernel, 0.02, 0.01, 0.003, 1.0, 0.01, (0.0, -9.81), 20.0
    )
    simulation = build(load_scene("still", {"time.end": 0.1, "numerics.dx": 0.03}), Communicator())
    simulation.evaluate(0.0)
    p = simulation.particles
    before = p.acceleration[p.fluid].copy()
    simulation.domain.markers = markers
    markers.distribute(simulation.domain.grid, simulation.domain.cuts, 0)
    simulation.evaluate(0.0)
    np.testing.assert_array_equal(p.acceleration[p.fluid], before)
    assert (markers.strength == 0).all()


@pytest.mark.parametrize("treatment", ["deficiency", "repulsion"])
@pytest.mark.parametrize("law", LAWS)
def test_still_water_stays_between_markers(treatment, law):
    """Half a second; with the correction the water is calmer than without."""
    keys = {"walls.treatment": treatment, "walls.repulsion": law, "time.end": 0.5, "numerics.dx": 0.02, "gauges": []}
    simulation = build(load_scene("still", keys), Communicator())
    simulation.run()
    x = simulation.field("position")
    assert ((x[:, 0] > 0) & (x[:, 0] < 0.6) & (x[:, 1] > 0)).all()
    speed = np.sqrt((simulation.field("velocity") ** 2).sum(axis=1).mean())
    assert speed < (0.03 if treatment == "deficiency" else 0.2)


# --- scenes --------------------------------------------------------------------------------------------------------

FAULTS = {
    "polygons as mirrors": ("still-tank", {"walls.treatment": "mirror"}, "walls.polygons.0", "cannot be mirrors"),
    "nothing holds": ("still", {"walls.treatment": "repulsion", "walls.repulsion": "none"}, "walls.repulsion", "nothing holds"),
    "no walls": ("still", {"walls": {"treatment": "ghosts"}}, "walls.treatment", "there are no walls"),
    "ghosts in 1D": ("column-1d", {"walls.treatment": "ghosts"}, "walls.treatment", "not for 1D"),
    "shallow water": ("swe-pulse-reflecting", {"walls.treatment": "repulsion"}, "walls.treatment", "not for shallow water"),
    "push too far": ("still", {"walls.treatment": "repulsion", "walls.push_reach": 0.5}, "walls.push_reach", "too far"),
    "strip too smooth": ("still", {"walls.treatment": "strip"}, "numerics.h_over_dx", "too large for a strip"),
    "no such edge": ("bulging-wall", {"walls.polygons.0.bulge.edge": 3}, "walls.polygons.0.bulge.edge", "there is no edge 3"),
    "bulge out of the domain": (
        "bulging-wall",
        {"walls.polygons.0.bulge.amplitude": 0.2},
        "walls.polygons.0.bulge.amplitude",
        "leaves the domain",
    ),
    "bulge and motion": (
        "bulging-wall",
        {"walls.polygons.0.motion": {"period": 1.0}},
        "walls.polygons.0.bulge",
        "given beside motion",
    ),
    "unknown treatment": ("still", {"walls.treatment": "ghost"}, "walls.treatment", "mirror"),
    "half an ellipse": ("tank-ellipse", {"fluid.blocks.0.ellipse": {"center": [2, 1]}}, "fluid.blocks.0.ellipse", "axes"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_walls_that_cannot_be_are_refused(name):
    source, overrides, where, what = FAULTS[name]
    with pytest.raises(SceneFaults) as caught:
        load_scene(source, overrides)
    told = str(caught.value)
    assert where in told
    assert what in told


@pytest.mark.parametrize("name", ["ghosts", "deficiency", "repulsion"])
def test_one_key_switches_the_walls_of_a_scene(name):
    simulation = build(load_scene("seiche", {"walls.treatment": name}), Communicator())
    domain = simulation.domain
    assert not domain.walls
    assert (domain.ghosts is not None) == (name == "ghosts")
    assert (domain.markers is not None) == (name != "ghosts")
    assert bool(domain.markers and domain.markers.weights) == (name == "deficiency")


def test_mirrors_are_the_default_and_plain_ones_a_key_away():
    for treatment, law in ((None, "hydrostatic"), ("mirror", "hydrostatic"), ("mirror-plain", "plain")):
        walls = build(load_scene("seiche", {"walls.treatment": treatment} if treatment else {}), Communicator()).domain.walls
        assert [wall.law for wall in walls] == [law] * 3


def test_an_ellipse_becomes_a_polygon_of_its_area():
    scene = load_scene("tank-ellipse")
    x, y = np.array(scene.walls.polygons[0].points).T
    area = 0.5 * abs((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    assert area == pytest.approx(math.pi * 1.8 * 0.9, rel=1e-12)
    assert load_scene(scene.model_dump()) == scene


def test_plan_names_what_the_walls_are_made_of(tmp_path):
    result = parsph("plan", "still", *settings(walls__treatment="deficiency"), cwd=tmp_path)
    text = " ".join(result.stdout.split())
    assert result.returncode == 0
    for words in ("moments:", "monaghan-kajtar:", "markers", "Jones et al. (2010)", "450, 0.00333 m apart"):
        assert words in text, words
