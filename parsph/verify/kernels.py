"""Kernels, the moments that they should have, and what the linear correction does for them and to a wave."""

import itertools

import numpy as np

from ..errors import RunError
from ..kernels import KERNELS, SPHERES
from ..moments import triangle
from ..parallel import Communicator
from ..scene.build import build
from ..scene.load import load_scene
from ..study.metrics import rms
from .registry import case

REACH = 4.0  # support radius in spacings, Szmidt's choice
DIMS = (1, 2, 3)


@case
def kernels(quick):
    """Integrals by quadrature, and the moments of Szmidt eqs. (23), (24) of a particle of a square lattice, delta = 4 d.

    Lengths are in h, 1D to 3D. Symmetry makes M1, G0 and what G1 has beside its diagonal zero; the diagonal is 1 in the limit.
    """
    for kernel in KERNELS.values():
        yield f"{kernel.name}: integral off 1", max(abs(_integral(kernel, dim) - 1) for dim in DIMS), "", 1e-10
        odd, mended, diagonal = [], [], {}
        for dim in DIMS:
            plain, corrected = _lattice_moments(kernel, dim, REACH)
            off = plain - np.eye(dim + 1)
            diagonal[dim] = np.diag(off).copy()
            odd.append(np.abs(off - np.diag(diagonal[dim])).max())
            mended.append(np.abs(corrected - np.eye(dim + 1)).max())
        yield f"{kernel.name}: moments that are zero by symmetry", max(odd), "", 1e-8
        yield f"{kernel.name}: all moments, corrected kernel", max(mended), "", 1e-8
        fine, _ = _lattice_moments(kernel, 2, 2 * REACH)
        yield f"{kernel.name}: M0 off 1, 2D", diagonal[2][0], "", None
        yield f"{kernel.name}: diagonal of G1 off 1, 2D", diagonal[2][1], "", None
        yield f"{kernel.name}: diagonal of G1 off 1, 2D, delta = 8 d", fine[1, 1] - 1, "", None


def _integral(kernel, dim):
    """Return the integral of W by adaptive quadrature between the knots of all kernels."""
    from scipy.integrate import quad

    def shell(r):
        return float(kernel.value(r, 1.0, dim)) * SPHERES[dim - 1] * r ** (dim - 1)

    pieces = itertools.pairwise(np.arange(0.0, kernel.support + 0.25, 0.5))
    return sum(quad(shell, a, b, epsabs=1e-14, epsrel=1e-14)[0] for a, b in pieces)


def _lattice_moments(kernel, dim, reach):
    """Return the moments of the plain and of the corrected kernel on a lattice, shape (dim + 1, dim + 1), lengths in h.

    ``[[M0, M1], [G0, G1]]``, so that the unit matrix is the ideal; `reach` is the support over the spacing.
    """
    spacing = kernel.support / reach
    axis = spacing * np.arange(-np.ceil(reach), np.ceil(reach) + 1)
    apart = np.stack([each.ravel() for each in np.meshgrid(*[axis] * dim, indexing="ij")], axis=1)
    r = np.linalg.norm(apart, axis=1)
    basis = np.column_stack([np.ones(len(r)), apart])
    value, slope = kernel.value(r, 1.0, dim), kernel.slope(r, 1.0, dim)
    gradient = -apart * (slope / np.where(r > 0, r, 1.0))[:, None]
    plain = spacing**dim * np.column_stack([value, gradient]).T @ basis
    moments = spacing**dim * (basis * value[:, None]).T @ basis
    weights = (np.linalg.inv(moments) @ basis.T) * value * spacing**dim
    return plain, weights @ basis


@case
def correction(quick):
    """The linear correction: linear fields on jittered particles with a free surface; and the seiche, Szmidt Fig. 3.

    Seiche: Gaussian, delta = 4 d = 0.04 m, P0 = 1e5 Pa, predictor-corrector of 0.2 ms, XSPH 1/2, mirror walls, half a period
    (quick: a fifth). The density's disturbance is the RMS of rho/rho_still - 1 over g H/c0^2, of which the wave itself has some
    0.03: a corrected gradient does not feel a constant pressure, so nothing holds p = 0 at the surface, and densities drift;
    the scatter is what is left about their mean.
    """
    for dim in DIMS:
        plain, value, gradient, share = _linear_errors(dim)
        yield f"linear field, {dim}D, corrected", value, "of its range", 1e-10
        yield f"gradient of a linear field, {dim}D, corrected", gradient, "of it", 1e-10
        yield f"linear field, {dim}D, plain kernel", plain, "of its range", None
        yield f"particles that keep the plain kernel, {dim}D", 100 * share, "%", 1.0
    runs = {which: _seiche(named, 0.1 if quick else 0.25) for which, named in (("plain", "none"), ("corrected", "linear"))}
    for which, (disturbance, scatter, energy) in runs.items():
        yield f"seiche, {which} kernel: disturbance of the density", disturbance, "g H/c0^2", None
        yield f"seiche, {which} kernel: scatter of the density", scatter, "g H/c0^2", None
        yield f"seiche, {which} kernel: kinetic energy over the first", energy, "", None
    yield "seiche: disturbance of the density, plain over corrected", runs["plain"][0] / runs["corrected"][0], "", 0.5


def _linear_errors(dim):
    """Return largest errors on a linear field in a jittered tank, sides and free surface included.

    Of the plain value and of the corrected value over the field's range, of the corrected gradient over the gradient, and the
    share of particles that keep the plain kernel, which do not count.
    """
    sides = ("left", "right", "front", "back", "bottom")
    scene = load_scene(
        {
            "domain": {"size": [0.4] * (dim - 1) + [0.6]},
            "fluid": {"blocks": [{"low": [0.0] * dim, "high": [0.4] * dim}]},
            "walls": {side: {} for side in {1: sides[:1], 2: (*sides[:2], "bottom"), 3: sides}[dim]},
            "numerics": {"dx": 0.04, "kernel_correction": "linear", "c0": 30.0},
            "time": {"end": 0.0},
        }
    )
    simulation = build(scene, Communicator())
    p = simulation.particles
    place = p.layout.columns("position")[1]
    p.shared[p.first : p.last, place] += (
        0.2 * scene.numerics.dx * np.random.default_rng(4).uniform(-1, 1, (p.last - p.first, dim))
    )
    simulation.evaluate(0.0)
    p, everyone = simulation.particles, slice(simulation.particles.first, simulation.particles.last)
    x, fluid = p.field("position", everyone), p.fluid - p.first
    apart = x - x[fluid, None]
    W = scene.kernel.value(np.linalg.norm(apart, axis=2), scene.h, dim)
    slope = np.array([1.0, -2.0, 1.5])[:dim]
    linear = 1.0 + x @ slope
    VWf = W * p.field("mass", everyone) / p.field("density", everyone) * linear
    sums = np.concatenate([VWf.sum(axis=1)[:, None], np.einsum("ab,abi->ai", VWf, apart)], axis=1)
    table, (i, j) = p.correction[p.fluid], triangle(dim)
    C = np.empty((len(table), dim + 1, dim + 1))
    C[:, i, j] = C[:, j, i] = table[:, :-1]
    found, good = np.einsum("aij,aj->ai", C, sums), table[:, -1] == 0
    extent = np.ptp(linear[fluid])
    plain, value = (np.abs(each - linear[fluid])[good].max() / extent for each in (sums[:, 0], found[:, 0]))
    return plain, value, np.abs(found[good, 1:] - slope).max() / np.abs(slope).max(), 1 - good.mean()


def _seiche(named, end):
    """Run the seiche with a `kernel_correction` to `end` [s]; return disturbance and scatter of the density, kinetic energy.

    In units of g H/c0^2, and of the energy at the beginning. A run that ends early, as its density leaves the range, counts as
    it is then.
    """
    overrides = {
        "numerics": {
            "dx": 0.01,
            "kernel": "gaussian",
            "h_over_dx": 4 / 3,
            "kernel_correction": named,
            "c0": 700.0**0.5,
            "integrator": "midpoint",
            "xsph": 0.5,
        },
        "time": {"end": end, "dt": 2e-4},
        "gauges": [],
    }
    scene = load_scene("seiche", overrides)
    simulation = build(scene, Communicator())
    simulation.prepare()
    before = (simulation.field("velocity") ** 2).sum()
    try:
        while simulation.time < end:
            simulation.advance()
    except RunError:
        pass
    gravity = scene.domain.gravity
    still = simulation.state.still_density(gravity * (scene.level - simulation.field("position")[:, 1]))
    disturbance = (simulation.field("density") / still - 1) / (gravity * scene.depth / scene.c0**2)
    return rms(disturbance), disturbance.std(), (simulation.field("velocity") ** 2).sum() / before
