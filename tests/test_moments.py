"""Moments of the kernel and its linear correction, against sums over all pairs, on fields that they must reproduce.

The sums, with ``x_ba = x_b - x_a`` and V_b = m_b/rho_b: ``M0 = sum V W``, ``M1 = sum V x_ba W``, ``G0 = sum V grad_a W``,
``G1_ij = sum V (x_ba)_i (grad_a W)_j``. With ``A = sum V W (1, x_ba)(1, x_ba)^T`` and C = A^-1 the corrected kernel is
``C_00 + C_0 . x_ba`` times W, the corrected derivative along axis i ``C_i0 + C_i . x_ba`` times W.
"""

import dataclasses
import json
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from helpers import SOME_KERNELS, domain_of, grid_around, jittered_lattice, tank, water

from parsph.errors import SceneError
from parsph.kernels import KERNELS
from parsph.moments import MOMENTS, Correction, Moments, triangle
from parsph.run import run
from parsph.scene.build import build
from parsph.scene.load import load_scene
from parsph.scene.plan import costs, print_plan
from parsph.sweep import Sweep
from parsph.terms import CORRECTIONS, DENSITIES, DIFFUSIONS, NONE, VISCOSITIES, XSPH, Terms
from parsph.terms.correction import LARGEST_TRACE
from parsph.timing import Timers

DX, RHO0, C0 = 0.05, 1000.0, 20.0
CELLS = {1: (40,), 2: (13, 11), 3: (8, 7, 8)}
GRAVITY = {1: (0.0,), 2: (1.5, -9.81), 3: (1.5, -2.0, -9.81)}
H_OVER_DX = {"quadratic-spline": 1.8, "wendland-c4": 1.7, "wendland-c6": 1.9}
every_kernel = pytest.mark.parametrize("kernel", SOME_KERNELS)
every_dim = pytest.mark.parametrize("dim", CELLS)
LINEAR = CORRECTIONS["linear"]
TERMS = {
    "force and continuity": Terms(correction=LINEAR),
    "all": Terms(viscosity=VISCOSITIES["monaghan"], diffusion=DIFFUSIONS["fourtakas"], smoothing=XSPH, correction=LINEAR),
    "summation, xsph": Terms(DENSITIES["summation"], VISCOSITIES["monaghan"], NONE, XSPH, correction=LINEAR),
}


def block(dim, seed=3, jitter=0.2):
    """Return fields of a jittered block with random masses, densities and velocities."""
    rng = np.random.default_rng(seed)
    position = jittered_lattice(dim, CELLS[dim], DX, seed, jitter)
    count = len(position)
    density = RHO0 * rng.uniform(0.98, 1.02, count)
    return {
        "position": position,
        "velocity": rng.normal(0, 1.0, (count, dim)),
        "density": density,
        "pressure": water(C0).pressure(density),
        "mass": RHO0 * DX**dim * rng.uniform(0.8, 1.2, count),
    }


def sweep_of(dim, kernel="wendland-c2", terms=None, single=False):
    h = H_OVER_DX.get(kernel, 1.3) * DX
    numbers = {"alpha": 0.1, "delta": 0.1, "epsilon": 0.5, "single": single}
    return Sweep(KERNELS[kernel], terms or TERMS["all"], dim, h, RHO0, C0, GRAVITY[dim], **numbers)


def arranged(fields, sweep):
    """Return a domain of all the particles, with room for whatever the sweep needs."""
    grid = grid_around(fields["position"], sweep.kernel.support * sweep.h)
    domain = domain_of(grid, fields, gravity=sweep.gravity, state=water(C0))
    p = domain.particles
    p.drift = np.zeros((len(p.tags), sweep.dim))
    p.correction = np.zeros((len(p.tags), Correction.width(sweep.dim)))
    domain.arrange(0.0)
    return domain, p.fluid[np.argsort(p.tags[p.fluid])]


def coefficients(fields, sweep):
    """Return the domain after the correction pass, rows in the order of the tags, and what the pass left of them."""
    domain, rows = arranged(fields, sweep)
    correction = Correction(sweep)
    correction(domain.particles, domain.starts, domain.slab)
    table, (i, j) = domain.particles.correction[rows], triangle(sweep.dim)
    C = np.empty((len(rows), sweep.dim + 1, sweep.dim + 1))
    C[:, i, j] = C[:, j, i] = table[:, :-1]
    return domain, rows, SimpleNamespace(C=C, plain=table[:, -1] == 1, count=correction.plain)


def corrected(fields, sweep):
    """Return what the correction pass and then the sweep leave, in the order of the tags."""
    domain, rows, found = coefficients(fields, sweep)
    p = domain.particles
    sweep(p, domain.starts, domain.slab, 1, domain.grid.columns + 1)
    rates = {"acceleration": p.acceleration[rows], "density_rate": p.density_rate[rows], "drift": p.drift[rows]}
    return SimpleNamespace(**vars(found), **rates)


def all_pairs(fields, sweep):
    """Return x_ba, the basis (1, x_ba), V W, and grad_a W, over all pairs."""
    x = fields["position"]
    x_ba = x - x[:, None]
    r = np.sqrt((x_ba**2).sum(axis=2))
    W = sweep.kernel.value(r, sweep.h, sweep.dim)
    F = sweep.kernel.slope(r, sweep.h, sweep.dim) / np.where(r > 0, r, 1.0)
    basis = np.concatenate([np.ones((*r.shape, 1)), x_ba], axis=2)
    return x_ba, basis, W * fields["mass"] / fields["density"], W, -F[:, :, None] * x_ba


@every_dim
@every_kernel
def test_moments_equal_the_sums_over_all_pairs(kernel, dim):
    fields, sweep = block(dim), sweep_of(dim, kernel)
    domain, _ = arranged(fields, sweep)
    p = domain.particles
    found = Moments(sweep)(p, domain.starts, domain.slab)
    assert list(found) == [moment.name for moment in MOMENTS]
    order = np.argsort(p.tags[p.fluid])
    x_ba, basis, VW, _, gradient = all_pairs(fields, sweep)
    V = fields["mass"] / fields["density"]
    first = np.einsum("ab,abi->ai", VW, basis)
    expected = {
        "kernel_moment0": first[:, 0],
        "kernel_moment1": first[:, 1:],
        "gradient_moment0": np.einsum("b,abi->ai", V, gradient),
        "gradient_moment1": np.einsum("b,abi,abj->aij", V, x_ba, gradient),
    }
    for name, values in expected.items():
        assert found[name].shape == values.shape
        np.testing.assert_allclose(found[name][order], values, atol=1e-12 * np.abs(values).max(), err_msg=name)
    inside = np.abs(np.einsum("aii->a", expected["gradient_moment1"]) / dim - 1)
    assert inside.min() < 0.05, "the diagonal is to be 1, not -1, where all is well"


@every_dim
@every_kernel
def test_correction_is_the_inverse_of_the_moment_matrix(kernel, dim):
    """C A = 1 wherever the kernel is corrected: sides and corners of the block, too."""
    fields, sweep = block(dim), sweep_of(dim, kernel)
    *_, found = coefficients(fields, sweep)
    _, basis, VW, _, _ = all_pairs(fields, sweep)
    A = np.einsum("ab,abi,abj->aij", VW, basis, basis)
    unit = np.einsum("aij,ajk->aik", found.C, A)
    scale = np.array([1.0, *[sweep.h] * dim])
    unit *= scale[None, :, None] / scale[None, None, :]
    np.testing.assert_allclose(unit[~found.plain], np.broadcast_to(np.eye(dim + 1), unit.shape)[~found.plain], atol=1e-11)
    assert found.plain.sum() == found.count
    assert (~found.plain).mean() > 0.95


@every_dim
@every_kernel
def test_corrected_sums_reproduce_linear_fields_and_their_gradients(kernel, dim):
    fields, sweep = block(dim), sweep_of(dim, kernel)
    *_, found = coefficients(fields, sweep)
    x = fields["position"]
    slope = np.array([12.0, -7.0, 5.0][:dim])
    linear = 3.0 + x @ slope
    _, basis, VW, _, _ = all_pairs(fields, sweep)
    sums = np.einsum("ab,abi,b->ai", VW, basis, linear)
    value = np.einsum("ai,ai->a", found.C[:, 0], sums)
    gradient = np.einsum("aij,aj->ai", found.C[:, 1:], sums)
    good = ~found.plain
    np.testing.assert_allclose(value[good], linear[good], atol=1e-11 * np.abs(linear).max())
    np.testing.assert_allclose(gradient[good], np.broadcast_to(slope, gradient.shape)[good], atol=1e-10 * np.abs(slope).max())
    plain = np.einsum("ab,b->a", VW, linear)
    assert np.abs(plain - linear).max() > 0.1 * np.abs(linear).max(), "at the sides the plain kernel must fail"


def brute_force(fields, sweep, found):
    """The sums of all terms over all pairs, with the coefficients that the correction pass found."""
    v, rho, p, m = (fields[name] for name in ("velocity", "density", "pressure", "mass"))
    x_ba, basis, _, W, gradient = all_pairs(fields, sweep)
    v_ab = v[:, None] - v
    r = np.sqrt((x_ba**2).sum(axis=2))
    corrected_W = np.einsum("ai,abi->ab", found.C[:, 0], basis) * W
    derivative = np.einsum("aij,abj->abi", found.C[:, 1:], basis) * W[:, :, None]
    derivative[found.plain] = gradient[found.plain]
    pair = (p / rho**2)[:, None] + p / rho**2
    mean = 0.5 * ((1 / rho)[:, None] + 1 / rho)
    if sweep.terms.viscosity is not NONE:
        vx = -(v_ab * x_ba).sum(axis=2)
        mu = sweep.h * vx / (r**2 + 0.01 * sweep.h**2)
        pair = pair + np.where(vx < 0, -sweep.alpha * sweep.c0 * mu * mean, 0.0)
    acceleration = np.array(sweep.gravity) - np.einsum("b,ab,abi->ai", m, pair, derivative)
    density_rate = np.einsum("b,abi,abi->a", m, v_ab, derivative)
    if sweep.terms.diffusion is not NONE:
        e, gamma = rho / sweep.rho0 - 1, sweep.gamma
        enthalpy = e + (gamma - 2) / 2 * e**2 + (gamma - 2) * (gamma - 3) / 6 * e**3
        s = sweep.rho0 * (enthalpy - fields["position"] @ np.array(sweep.gravity) / sweep.c0**2)
        F = sweep.kernel.slope(r, sweep.h, sweep.dim) / np.where(r > 0, r, 1.0)
        diffused = 2 * (s[:, None] - s) * np.where(r > 0, F, 0.0) * m / rho
        density_rate = density_rate + sweep.delta * sweep.h * sweep.c0 * diffused.sum(axis=1)
    if sweep.terms.density.name == "summation":
        density_rate = (m * corrected_W).sum(axis=1)
    drift = -sweep.epsilon * np.einsum("b,ab,ab,abi->ai", m, mean, corrected_W, v_ab)
    return {"acceleration": acceleration, "density_rate": density_rate, "drift": drift}


def with_spray(fields, dim):
    """Add a pair and a single particle far from the block, which keep the plain kernel."""
    far = np.array([[3.0] * dim, [3.0 + 0.6 * DX] + [3.0] * (dim - 1), [5.0] * dim])
    more = {"position": far, "velocity": far * 0.1, "density": np.full(3, 1.01 * RHO0), "mass": np.full(3, RHO0 * DX**dim)}
    more["pressure"] = water(C0).pressure(more["density"])
    return {name: np.concatenate([values, more[name]]) for name, values in fields.items()}


def assert_same_rates(found, expected, sweep, tolerance):
    names = ["acceleration", "density_rate"] + ["drift"] * (sweep.terms.smoothing is not NONE)
    for name in names:
        values = expected[name]
        np.testing.assert_allclose(getattr(found, name), values, atol=tolerance * np.abs(values).max(), rtol=0, err_msg=name)


@every_dim
@pytest.mark.parametrize(
    ("kernel", "terms"), [("wendland-c2", "force and continuity"), ("wendland-c2", "all"), ("gaussian", "all")]
)
def test_corrected_sweep_equals_the_sum_over_all_pairs(dim, kernel, terms):
    fields, sweep = with_spray(block(dim), dim), sweep_of(dim, kernel, TERMS[terms])
    found = corrected(fields, sweep)
    assert found.plain[-1]
    assert found.plain[-3:].all() or dim == 1
    expected = brute_force(fields, sweep, found)
    assert_same_rates(found, expected, sweep, 1e-11)
    plain = corrected(fields, dataclasses.replace(sweep, terms=dataclasses.replace(sweep.terms, correction=NONE)))
    for name in ("acceleration", "density_rate"):
        off = np.abs(getattr(plain, name) - getattr(found, name))
        assert off[~found.plain].max() > 0.01 * np.abs(getattr(found, name)).max(), "the correction must be felt"


def test_corrected_summation_equals_the_sum_over_all_pairs():
    """Where shallow water needs it, in one dimension; the sum is then 1 over the mean volume of a neighbour."""
    fields, sweep = with_spray(block(1), 1), sweep_of(1, terms=TERMS["summation, xsph"])
    found = corrected(fields, sweep)
    assert_same_rates(found, brute_force(fields, sweep, found), sweep, 1e-11)


@every_dim
@pytest.mark.parametrize("kernel", ["wendland-c2", "quintic-spline"])
def test_corrected_sweep_in_single_precision(dim, kernel):
    fields, sweep = with_spray(block(dim), dim), sweep_of(dim, kernel, single=True)
    found = corrected(fields, sweep)
    assert_same_rates(found, brute_force(fields, sweep, found), sweep, 2e-4)


@every_dim
def test_corrected_continuity_knows_the_divergence_of_linear_flow(dim):
    """``drho/dt = -rho div v`` where masses and volumes are even, at the sides as well; the plain one is wrong there."""
    fields, sweep = block(dim), sweep_of(dim, terms=TERMS["force and continuity"])
    fields["density"][:] = RHO0
    rates = np.array([[0.3, -1.1, 0.4], [0.7, 0.9, -0.2], [0.1, 0.5, -0.4]])[:dim, :dim]
    fields["velocity"] = fields["position"] @ rates.T
    found = corrected(fields, sweep)
    expected = -RHO0 * np.trace(rates)
    np.testing.assert_allclose(found.density_rate[~found.plain], expected, rtol=1e-10)


@every_dim
def test_fallback_takes_single_particles_pairs_and_sheets_but_no_corner_of_the_fluid(dim):
    """What is nearly in a line (2D) or a plane (3D) has no derivative across it, however it is turned."""
    sweep = sweep_of(dim)
    *_, found = coefficients(with_spray(block(dim, jitter=0.1), dim), sweep)
    assert not found.plain[:-3].any()
    assert found.plain[-1]
    if dim == 1:
        return
    sheet = block(dim, jitter=0.1)
    one = np.floor(sheet["position"][:, -1] / DX) == CELLS[dim][-1] // 2
    sheet = {name: values[one] for name, values in sheet.items()}
    turned = dict(sheet)
    c = np.sqrt(0.5)
    turn = np.eye(dim)
    turn[[0, 0, -1, -1], [0, -1, 0, -1]] = c, -c, c, c
    turned["position"] = sheet["position"] @ turn.T
    for fields in (sheet, turned):
        assert coefficients(fields, sweep)[-1].plain.all()


def test_particles_that_keep_the_plain_kernel_move_as_in_a_plain_sweep():
    fields = with_spray(block(2), 2)
    for single in (False, True):
        sweep = sweep_of(2, terms=TERMS["all"], single=single)
        plain = corrected(fields, dataclasses.replace(sweep, terms=dataclasses.replace(sweep.terms, correction=NONE)))
        found = corrected(fields, sweep)
        for name in ("acceleration", "density_rate", "drift"):
            a, b = getattr(found, name)[found.plain], getattr(plain, name)[found.plain]
            assert len(a) >= 3
            np.testing.assert_allclose(a, b, rtol=1e-6 if single else 1e-12, atol=1e-9 * np.abs(getattr(plain, name)).max())


def test_largest_trace_leaves_room_on_both_sides():
    """Traces of C on a lattice at usual h/dx: inside, at a flat surface, in a corner; and of a row of particles."""
    for kernel in KERNELS.values():
        h = H_OVER_DX.get(kernel.name, 1.3) * DX
        length = h * kernel.spread(2)
        x, y = (axis.ravel() for axis in np.meshgrid(DX * np.arange(-8, 9), DX * np.arange(-8, 9), indexing="ij"))

        def trace(chosen, x=x, y=y, h=h, kernel=kernel, length=length):
            basis = np.stack([np.ones(chosen.sum()), x[chosen] / length, y[chosen] / length])
            weights = DX**2 * kernel.value(np.hypot(x[chosen], y[chosen]), h, 2)
            return np.trace(np.linalg.inv((basis * weights) @ basis.T))

        inside, surface, corner = trace(x > -9), trace(y <= 0), trace((x <= 0) & (y <= 0))
        assert inside == pytest.approx(3, rel=0.2)
        assert inside < surface < corner < 0.5 * LARGEST_TRACE, kernel.name


def corrected_tank(**numerics):
    return tank(numerics={"dx": 0.02, "viscosity": "monaghan", "alpha": 0.3, "kernel_correction": "linear", **numerics})


def test_a_scene_with_the_correction_has_its_pass_and_a_plain_one_has_no_array():
    plain = build(load_scene(tank()))
    assert plain.correction is None
    assert plain.particles.correction.size == 0
    simulation = build(load_scene(corrected_tank()))
    simulation.run()
    p = simulation.particles
    assert simulation.correction is not None
    assert p.correction.shape == (len(p.tags), 7)
    assert np.abs(p.correction[p.fluid, 0] - 1).max() > 0.1


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_the_plan_names_what_moments_and_correction_add(precision, capsys):
    plain = tank(output={"snapshots": {"every": 0.01, "precision": precision}})
    full = {**plain, "output": {"snapshots": {**plain["output"]["snapshots"], "moments": True}}}
    full["numerics"] = {**plain["numerics"], "kernel_correction": "linear"}
    before, after = (costs(load_scene(keys)) for keys in (plain, full))
    numbers = 2 * 400 * (1 + 3 + 3 + 9)
    assert after["disk"] - before["disk"] == numbers * np.dtype(precision).itemsize
    assert after["core seconds"] > 1.5 * before["core seconds"]
    print_plan(load_scene(full), "full")
    text = " ".join(capsys.readouterr().out.split())
    assert "kernel correction" in text
    assert all(moment.name in text for moment in MOMENTS)


FAULTS = {
    "kernel_correction": {"numerics.kernel_correction": "linear"},
    "moments": {"output.snapshots.moments": True},
}


@pytest.mark.parametrize("key", FAULTS)
def test_a_growing_h_has_neither_correction_nor_moments(key):
    growing = {"numerics.h_growth": 4.0, "numerics.viscosity": "monaghan", "numerics.alpha": 1.0}
    with pytest.raises(SceneError, match=f"{key}.*has no meaning with a growing h"):
        load_scene("swe-dam-break", {**growing, **FAULTS[key]})


def test_moments_of_a_snapshot_are_those_of_its_own_time(tmp_path):
    """Water under pressure that flies apart in empty space: sums over all pairs of what the file itself holds."""
    keys = {
        "domain": {"size": [1.0, 1.0], "gravity": 0.0},
        "fluid": {"blocks": [{"low": [0.3, 0.3], "high": [0.7, 0.7], "pressure": 2e4}]},
        "numerics": {"dx": 0.04, "c0": 20.0, "h_over_dx": 1.3},
        "time": {"end": 0.05},
        "output": {"snapshots": {"every": 0.05, "moments": True}},
    }
    scene = load_scene(keys)
    (tmp_path / "run").mkdir()
    simulation = build(scene, folder=tmp_path / "run")
    simulation.run()
    path = tmp_path / "run" / "snapshots" / "00001.vtkhdf"
    with h5py.File(path) as file:
        found = {name: values[:] for name, values in file["VTKHDF/PointData"].items()}
        found["position"] = file["VTKHDF/Points"][:, :2]
    _, basis, VW, _, _ = all_pairs(found, simulation.sweep)
    np.testing.assert_allclose(found["kernel_moment0"], VW.sum(axis=1), rtol=1e-12)
    np.testing.assert_allclose(found["kernel_moment1"][:, :2], np.einsum("ab,abi->ai", VW, basis)[:, 1:], atol=1e-14)
    before = found["position"] - 0.5 * simulation.last_dt * found["velocity"][:, :2]  # of the last evaluation
    _, _, late, _, _ = all_pairs({**found, "position": before}, simulation.sweep)
    assert np.abs(late.sum(axis=1) / found["kernel_moment0"] - 1).max() > 1e-4


def test_a_look_at_the_present_leaves_everything_as_it_was():
    """Rows, tags, halos, starts, rates: of the object that it was before, all bits."""
    simulation = build(load_scene(corrected_tank(xsph=0.5)))
    simulation.run()

    def everything():
        p, domain = simulation.particles, simulation.domain
        arrays = {
            name: value.copy() for name, value in vars(p).items() if isinstance(value, np.ndarray) and name not in SCRATCH
        }
        return {**arrays, "first": p.first, "last": p.last, "starts": domain.starts.copy(), "time": domain.time}

    before = everything()
    with simulation.present():
        assert simulation.domain.time == simulation.time != before["time"]
        inside = everything()
        simulation.particles.reserve(2 * len(simulation.particles.tags))
    after = everything()
    assert (inside["shared"] != before["shared"]).any()
    for name, value in before.items():
        np.testing.assert_array_equal(after[name], value, err_msg=name)


SCRATCH = ("cells", "order")  # written anew by each sort before it reads them


def test_the_end_summary_counts_who_kept_the_plain_kernel(tmp_path, capsys):
    blocks = {"blocks": [{"low": [0.0, 0.0], "high": [0.2, 0.12]}, {"low": [0.1, 0.2], "high": [0.12, 0.22]}]}
    keys = {**corrected_tank(), "fluid": blocks, "time": {"end": 0.005}}
    (tmp_path / "drop.json").write_text(json.dumps(keys))
    finished = run(tmp_path / "drop.json", (), tmp_path / "out")
    assert finished.summary["kernel correction"] == {"plain kernel per evaluation": 1.0}
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["kernel correction"]
    assert "kernel correction: 1.0 particles with the plain kernel per evaluation" in capsys.readouterr().out
    assert "correction" in finished.summary["phases [s]"]
    (tmp_path / "still.json").write_text(json.dumps(tank()))
    assert "kernel correction" not in run(tmp_path / "still.json", (), tmp_path / "plain").summary


def test_a_phase_within_another_one_counts_for_itself_alone(monkeypatch):
    clock = iter([0.0, 1.0, 4.0, 5.0, 7.0, 10.0])
    monkeypatch.setattr("parsph.timing.time.perf_counter", lambda: next(clock))
    timers = Timers()
    with timers("outer"):
        with timers("inner"):
            pass
        with timers("inner"):
            pass
    assert timers.seconds == {"inner": 5.0, "outer": 5.0}
