"""Solitary waves: profiles, speeds, Goring's piston for them, and what they do to a vertical wall.

All profiles here have the form

    ``eta = H sech^2(kX) sum_j p_j tanh^2j(kX)``,  ``X = x - ct``,  ``p_0 = 1``,

so that the volume ahead of a place is ``(H/k) sum_j p_j/(2j + 1) (1 - tanh^(2j+1)(kX))`` and the piston is explicit.

Sources: Boussinesq (1871); Rayleigh (1876), On waves, Phil. Mag. 5(1), 257-279; Grimshaw (1971), The solitary wave in water of
variable depth, part 2, J. Fluid Mech. 46, 611-622; Goring (1978), Tsunamis: the propagation of long waves onto a shelf, PhD
thesis, California Institute of Technology. "exact" interpolates numerically exact steady potential flow (Babenko's equation,
residual of Bernoulli's below 1e-12), computed for this project; the heads of the files in ``data/`` say what they hold.
"""

import csv
import math
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import numpy as np

from ..errors import SceneError, did_you_mean
from .limits import HIGHEST_SOLITARY

DATA = resources.files(__package__) / "data"
TAIL = 1e-3  # of the wave height: where the piston starts and ends
IN_HEIGHT, IN_PROFILE = 6, 10  # degrees of the exact profiles' fit; it is within 1e-5 H of the rows


def _boussinesq(ratio):
    """Boussinesq (1871): ``k d = sqrt(3a/4)``, ``c^2 = g (d + H)``."""
    return 1 + ratio, math.sqrt(0.75 * ratio), np.ones(1)


def _rayleigh(ratio):
    """Rayleigh (1876): ``k d = sqrt(3a/(4 (1 + a)))``, ``c^2 = g (d + H)``."""
    return 1 + ratio, math.sqrt(0.75 * ratio / (1 + ratio)), np.ones(1)


def _grimshaw(ratio):
    """Grimshaw (1971), third order.

    ``k d = sqrt(3a/4) (1 - 5a/8 + 71a^2/128)``, ``c^2 = gd (1 + a - a^2/20 - 3a^3/70)``,
    ``eta/d = a s^2 - 3/4 a^2 s^2 t^2 + a^3 (5/8 s^2 t^2 - 101/80 s^4 t^2)``, s = sech kX, t = tanh kX.
    """
    decay = math.sqrt(0.75 * ratio) * (1 - 5 / 8 * ratio + 71 / 128 * ratio**2)
    twist = 101 / 80 * ratio**2
    return _speed_of_grimshaw(ratio), decay, np.array([1, -0.75 * ratio + 5 / 8 * ratio**2 - twist, twist])


def _speed_of_grimshaw(ratio):
    return 1 + ratio - ratio**2 / 20 - 3 * ratio**3 / 70


def _exact(ratio):
    """Interpolated from numerically exact waves; far out ``eta ~ exp(-2kX)`` with ``c^2 = g tan(2kd) / 2k``, Stokes (1880)."""
    speed, fit, largest = _exact_fit()
    if ratio > largest:
        why = f"the exact profiles are tabulated for heights up to {largest:g} depths"
        raise SceneError(f"is {ratio:g} of the depth", "height", why, f"at most {largest:g} of the depth, or another theory")
    squared = float(speed(ratio))
    powers = ratio ** np.arange(1, IN_HEIGHT + 1)
    return squared, _decay(squared), np.concatenate([[1.0], powers @ fit])


def _decay(squared):
    """Return the k d that solves ``c^2/(gd) = tan(2kd)/2kd``."""
    from scipy.optimize import brentq

    # its series gives c^2 - 1 > m^2/3 for m = 2kd
    return 0.5 * brentq(lambda m: math.sin(m) - squared * m * math.cos(m), 1e-9, math.pi / 2, xtol=1e-15)


@lru_cache
def _exact_fit():
    """Return c^2/(gd) as a function of H/d, the profile's coefficients, shape (IN_HEIGHT, IN_PROFILE), the largest H/d.

    ``p_j = sum_i fit_ij a^i``, j >= 1: the wave of no height is sech^2, and each crest is as high as it should be.
    """
    from scipy.interpolate import CubicSpline

    table = _table("solitary_celerity")
    ratios = np.concatenate([[0.0], table["a"]])
    rest = np.concatenate([[0.0], table["c_exact"] ** 2 - _speed_of_grimshaw(table["a"])])
    spline = CubicSpline(ratios, rest, bc_type=((1, 0.0), "not-a-knot"))

    def speed(ratio):
        return _speed_of_grimshaw(ratio) + spline(ratio)

    rows = _table("solitary_profiles_exact")
    a = rows["a"]
    decays = {ratio: _decay(float(speed(ratio))) for ratio in np.unique(a)}
    slope = np.tanh(np.array([decays[ratio] for ratio in a]) * rows["x"]) ** 2
    hump = a * (1 - slope)
    terms = [hump * a**i * slope**j for i in range(1, IN_HEIGHT + 1) for j in range(1, IN_PROFILE + 1)]
    fit = np.linalg.lstsq(np.stack(terms, axis=1), rows["eta_exact"] - hump, rcond=None)[0]
    return speed, fit.reshape(IN_HEIGHT, IN_PROFILE), float(a.max())


SOLITARY_THEORIES = {"boussinesq": _boussinesq, "rayleigh": _rayleigh, "grimshaw": _grimshaw, "exact": _exact}


@dataclass(frozen=True)
class Solitary:
    """A solitary wave to the right, its crest at ``X = x - ct = 0``.

    Attributes
    ----------
    height, depth : float
        H and d [m].
    gravity : float
        [m/s^2]
    theory : str
        One of `SOLITARY_THEORIES`.

    Raises
    ------
    SceneError
        When there is no such theory or it has no such wave.
    """

    height: float
    depth: float
    gravity: float
    theory: str = "exact"

    def __post_init__(self):
        if self.theory not in SOLITARY_THEORIES:
            cure = f"{did_you_mean(self.theory, SOLITARY_THEORIES)}one of: {', '.join(SOLITARY_THEORIES)}"
            raise SceneError(f"there is no theory {self.theory!r} of solitary waves", "theory", cure=cure)
        for name in ("height", "depth", "gravity"):
            if not 0 < getattr(self, name) < math.inf:
                raise SceneError(f"is {getattr(self, name):g}", name, cure="a number above 0")
        ratio = self.height / self.depth
        if ratio > HIGHEST_SOLITARY:
            why = f"the highest solitary wave has {HIGHEST_SOLITARY:g} of the depth"
            raise SceneError(f"is {ratio:g} of the depth", "height", why, "a lower wave or deeper water")
        squared, decay, shape = SOLITARY_THEORIES[self.theory](ratio)
        for name, value in (("_squared", squared), ("_decay", decay), ("_shape", shape)):
            object.__setattr__(self, name, value)

    @property
    def celerity(self):
        """Speed c [m/s]."""
        return math.sqrt(self.gravity * self.depth * self._squared)

    @property
    def outskirts(self):
        """Decay rate k [1/m]: far from the crest ``eta ~ exp(-2k|X|)``."""
        return self._decay / self.depth

    @property
    def length(self):
        """Width [m] of the wave where it has 5 % of its height."""
        return 2 * self.reach(0.05)

    @property
    def volume(self):
        """Volume above the still-water level, per width [m^2]."""
        return 2 * float(self.volume_ahead(0.0))

    def elevation(self, X):
        """Return the surface elevation [m] at ``X = x - ct`` [m], shape (...)."""
        tau = np.tanh(self.outskirts * np.asarray(X, float)) ** 2
        return self.height * (1 - tau) * np.polynomial.polynomial.polyval(tau, self._shape)

    def volume_ahead(self, X):
        """Return the volume ``int_X^inf eta dX`` [m^2] ahead of `X` [m], shape (...)."""
        t = np.tanh(self.outskirts * np.asarray(X, float))
        powers = 2 * np.arange(len(self._shape)) + 1
        return self.height / self.outskirts * ((1 - t[..., None] ** powers) * self._shape / powers).sum(-1)

    def reach(self, part):
        """Return the distance [m] from the crest at which the wave has fallen to `part` of its height."""
        from scipy.optimize import brentq

        return brentq(lambda X: float(self.elevation(X)) / self.height - part, 0.0, 18 / self.outskirts)

    @property
    def stroke(self):
        """Stroke [m] of the piston that makes all of the wave: its volume over the depth."""
        return self.volume / self.depth

    @property
    def duration(self):
        """Time [s] that `paddle` takes, between elevations of `TAIL` of the height at the piston."""
        return float(self.paddle(2)[0][-1])

    def paddle(self, count=401, tail=TAIL):
        """Return the motion of a piston that makes the wave, Goring (1978).

        The piston moves with the depth-averaged water, ``dxi/dt = c eta/(d + eta)`` at ``theta = ct - xi``, which gives
        ``dxi/dtheta = eta/d`` for any steady wave: xi is the volume ahead of the piston over the depth and
        ``t = (theta + xi)/c``, both exactly.

        Parameters
        ----------
        count : int
            Rows of the table.
        tail : float
            The table begins and ends where the elevation at the piston has so much of the wave's height; what is left out
            shortens the stroke by about half of it (relative).

        Returns
        -------
        tuple of ndarray, shape (count,)
            Times [s] and displacements [m], both from 0.
        """
        reach = self.reach(tail)
        theta = np.linspace(-reach, reach, count)
        xi = (self.volume_ahead(-theta) - self.volume_ahead(reach)) / self.depth
        return (theta + reach + xi) / self.celerity, xi


@dataclass(frozen=True)
class WallImpact:
    """What a solitary wave does to a vertical wall.

    Attributes
    ----------
    runup : float
        Largest run-up above the still-water level over the depth, R/d.
    force : float
        Largest horizontal force per width over ``rho g d^2``, the still water's 0.5 included.
    pressure : float
        Largest pressure at the foot of the wall over ``rho g d``, the still water's 1 included.
    delay : float
        By how much later than a wave that ran on at the speed c the crest is at the wall, over ``sqrt(d/g)``.
    """

    runup: float
    force: float
    pressure: float
    delay: float


def solitary_on_wall(ratio):
    """Return what a solitary wave of H/d = `ratio` does to a vertical wall on a flat bed.

    Interpolated (cubic) from numerically exact potential flow, computed for this project: exact solitary waves, unsteady
    conformal mapping, relative error of the energy below 4e-7. Up to 0.2 the run-up is within 1 % of ``2a + a^2/2``,
    Byatt-Smith (1971), An integral equation for unsteady surface waves and a comment on the Boussinesq equation, J. Fluid Mech.
    49, 625-633, and within 0.5 % of ``2a + a^2/2 + 3a^3/4``, Su & Mirie (1980), On head-on collisions between two solitary
    waves, J. Fluid Mech. 98, 509-525. Above 0.4 the force is largest before the run-up is.

    Parameters
    ----------
    ratio : float
        H/d between 0.05 and 0.5.

    Returns
    -------
    WallImpact

    Raises
    ------
    SceneError
        Outside that range.
    """
    from scipy.interpolate import CubicSpline

    table = _table("solitary_wall_runup_exact")
    low, high = table["a"][[0, -1]]
    if not low <= ratio <= high:
        why = f"run-up on a wall is tabulated for heights of {low:g} to {high:g} depths"
        raise SceneError(f"is {ratio:g} of the depth", "height", why, f"a height between {low:g} and {high:g} of the depth")
    values = np.stack([table[name] for name in ("R_num", "Fmax", "pbottom_max", "phase_delay")], axis=1)
    return WallImpact(*map(float, CubicSpline(table["a"], values)(ratio)))


def _table(name):
    """Return {column: ndarray, shape (n,)} of a file in ``data/``."""
    lines = (DATA / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    header, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    return dict(zip(header, np.array(rows, float).T, strict=True))
