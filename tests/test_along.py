"""Regular waves along a tank that were made up: harmonics, bound and free second harmonic, decay."""

import cmath
import math

import numpy as np
import pytest

from parsph.analysis import decay_along, expected_decay, harmonics_along, second_harmonic
from parsph.errors import SceneError
from parsph.waves import phase_speed, wavenumber

PERIOD, DEPTH, GRAVITY = 1.6, 0.4, 9.81
W = 2 * math.pi / PERIOD
K, FREE = wavenumber(W, DEPTH, GRAVITY), wavenumber(2 * W, DEPTH, GRAVITY)
BEAT = 2 * math.pi / (FREE - 2 * K)
X = np.array([1.0, 1.4, 2.1, 2.9, 3.3, 4.2])
FIRST, BOUND, RUNS, BACK, THIRD = cmath.rect(0.04, 0.3), cmath.rect(5e-3, 0.6), cmath.rect(3e-3, -2.0), 1e-3j, 4e-4 + 0j


def tank(t, x, decay=0.0, back=BACK):
    """Levels (gauges, samples): the first harmonic with its bound second and third one, and free second ones both ways."""
    x = np.asarray(x)[:, None]
    first = FIRST * np.exp(1j * (W * t - K * x) - decay * x)
    bound = BOUND * np.exp(2j * (W * t - K * x)) + THIRD * np.exp(3j * (W * t - K * x))
    free = (RUNS * np.exp(-1j * FREE * x) + back * np.exp(1j * FREE * x)) * np.exp(2j * W * t)
    return DEPTH + np.real(first + bound + free)


T = np.arange(0, 8.2 * PERIOD, 0.01)


def test_harmonics_along_the_tank_are_those_put_in():
    found = harmonics_along(T, tank(T, X), X, PERIOD)
    expected = np.array([FIRST * np.exp(-1j * K * X), BOUND * np.exp(-2j * K * X), THIRD * np.exp(-3j * K * X)]).T
    expected[:, 1] += RUNS * np.exp(-1j * FREE * X) + BACK * np.exp(1j * FREE * X)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert harmonics_along(T, tank(T, X), X, PERIOD, count=1).shape == (6, 1)


def test_harmonics_are_of_the_last_periods():
    levels = tank(T, X) + np.where(T < 5 * PERIOD, 0.1 * np.sin(W * T) ** 3, 0.0)
    late = harmonics_along(T, levels, X, PERIOD, periods=3)
    np.testing.assert_allclose(late, harmonics_along(T, tank(T, X), X, PERIOD), atol=1e-12)
    assert abs(harmonics_along(T, levels, X, PERIOD) - late).max() > 1e-3


@pytest.mark.parametrize("reflected", [False, True])
def test_free_and_bound_second_harmonics_are_told_apart(reflected):
    amplitudes = harmonics_along(T, tank(T, X, back=BACK if reflected else 0), X, PERIOD)[:, 1]
    found = second_harmonic(X, amplitudes, 2 * K, FREE, reflected)
    expected = [BOUND, RUNS, BACK if reflected else 0]
    np.testing.assert_allclose([found.bound, found.free, found.reflected], expected, atol=1e-11)
    assert found.residual < 1e-11
    assert found.beat_length == pytest.approx(BEAT)


def test_a_wave_that_comes_back_is_misfit_where_it_is_not_asked_for():
    amplitudes = harmonics_along(T, tank(T, X), X, PERIOD)[:, 1]
    found = second_harmonic(X, amplitudes, 2 * K, FREE)
    assert 0.2 * abs(BACK) < found.residual < abs(BACK)
    assert abs(found.bound) == pytest.approx(abs(BOUND), rel=0.3)


def test_the_second_harmonic_meets_itself_after_a_beat_length():
    amplitudes = harmonics_along(T, tank(T, [1.0, 1.0 + BEAT / 2, 1.0 + BEAT], back=0), [0, 1, 2], PERIOD)[:, 1]
    assert abs(amplitudes[0]) == pytest.approx(abs(amplitudes[2]), rel=1e-9)
    assert abs(amplitudes[0]) != pytest.approx(abs(amplitudes[1]), rel=0.1)


@pytest.mark.parametrize("reflected", [False, True])
def test_noise_moves_no_part_by_more_than_the_bound_says(reflected):
    """At the bound of a hundredth a part has the error of a gauge, times ten, over the root of their number."""
    rng, noise = np.random.default_rng(4), 1e-4
    for _ in range(200):
        x = np.sort(rng.uniform(0, BEAT, 5))
        try:
            second_harmonic(x, np.ones(5), 2 * K, FREE, reflected)
        except SceneError:
            continue
        errors = rng.normal(0, noise / math.sqrt(2), (50, 5, 2)) @ [1, 1j]
        found = [second_harmonic(x, some, 2 * K, FREE, reflected) for some in errors]
        for part in ("bound", "free", "reflected"):
            size = math.sqrt(np.mean([abs(getattr(one, part)) ** 2 for one in found]))
            assert size < 1.5 * 10 * noise / math.sqrt(5)


@pytest.mark.parametrize("rate", [0.0, 0.03, -0.01])
def test_decay_is_the_one_put_in(rate):
    found = decay_along(X, 0.05 * np.exp(-rate * X))
    assert (found.amplitude, found.rate) == pytest.approx((0.05, rate), abs=1e-14)
    assert found.error < 1e-14
    np.testing.assert_allclose(found.at([0.0, 2.0]), [0.05, 0.05 * math.exp(-2 * rate)])
    amplitudes = harmonics_along(T, tank(T, X, decay=rate), X, PERIOD)[:, 0]
    assert decay_along(X, amplitudes).rate == pytest.approx(rate, abs=1e-12)


def test_the_standard_error_is_that_of_repeated_fits():
    rng, x = np.random.default_rng(6), np.linspace(0, 10, 12)
    fits = [decay_along(x, np.exp(-0.05 * x + rng.normal(0, 0.02, x.size))) for _ in range(600)]
    rates = np.array([fit.rate for fit in fits])
    assert rates.mean() == pytest.approx(0.05, abs=5 * rates.std() / math.sqrt(600))
    assert math.sqrt(np.mean([fit.error**2 for fit in fits])) == pytest.approx(rates.std(), rel=0.1)


def test_reflection_averages_out_of_the_decay_over_whole_half_wavelengths():
    x = 1.0 + np.arange(12) * math.pi / K / 6  # twelve places on two halves of a wavelength, twice the same six phases
    standing = np.abs(np.exp(-1j * K * x) + 0.05 * np.exp(1j * K * x))
    found = decay_along(x, standing * np.exp(-0.03 * x))
    assert abs(found.rate - 0.03) < 2 * found.error


@pytest.mark.parametrize("depth", [0.05, 0.4, 50.0])
def test_expected_decay_is_that_of_time_over_the_speed_of_the_group(depth):
    """The group speed is dw/dk."""
    nu, k = 1e-4, wavenumber(W, depth, GRAVITY)

    def frequency(k):
        return math.sqrt(GRAVITY * k * math.tanh(k * depth))

    group = (frequency(k * 1.0001) - frequency(k * 0.9999)) / (0.0002 * k)
    assert expected_decay(PERIOD, depth, GRAVITY, nu) == pytest.approx(2 * nu * k**2 / group, rel=1e-6)
    assert expected_decay(PERIOD, depth, GRAVITY, 0.0) == 0.0


def test_expected_decay_in_deep_and_shallow_water():
    deep = expected_decay(PERIOD, 500.0, GRAVITY, 1e-3)
    assert deep == pytest.approx(4e-3 * (W**2 / GRAVITY) ** 2 / phase_speed(PERIOD, 500.0, GRAVITY), rel=1e-9)
    shallow = expected_decay(1000.0, 1.0, GRAVITY, 1e-3)
    assert shallow == pytest.approx(2e-3 * (2 * math.pi / 1000) ** 2 / GRAVITY**1.5, rel=1e-4)


LEVELS = tank(T, X)
FAULTS = {
    "gauges: positions have shape (2,), levels (6, 1312)": lambda: harmonics_along(T, LEVELS, X[:2], PERIOD),
    "shorter than a period of 20 s": lambda: harmonics_along(T, LEVELS, X, 20.0),
    "13 unknowns in each period; sample more often": lambda: harmonics_along(T[::20], LEVELS[:, ::20], X, PERIOD, 6),
    "gauges: positions have shape (3,), amplitudes (2,)": lambda: second_harmonic(X[:3], [1, 1], 2 * K, FREE),
    "3 waves need 3 gauges at least": lambda: second_harmonic(X[:2], [1, 1], 2 * K, FREE, reflected=True),
    "bound wavenumber: 0 is not positive": lambda: second_harmonic(X, np.ones(6), 0.0, FREE),
    f"multiples of the beat length apart, {BEAT:.3g} m; spread them over half a beat length, {BEAT / 2:.3g} m": lambda: (
        second_harmonic([1.0, 1.0 + BEAT, 1.0 + 2 * BEAT], np.ones(3), 2 * K, FREE)
    ),
    "gauges, over 0.02 m, do not tell bound from free waves": lambda: second_harmonic(
        1 + np.arange(5) * 0.005, np.ones(5), 2 * K, FREE
    ),
    f"beat length, and of half the free wavelength, {math.pi / FREE:.3g} m, apart": lambda: second_harmonic(
        np.arange(5) * math.pi / FREE, np.ones(5), 2 * K, FREE, reflected=True
    ),
    "do not tell": lambda: second_harmonic(X, np.ones(6), FREE, FREE),
    "need three places at least": lambda: decay_along([1.0, 2.0, 2.0], [1, 1, 1]),
    "positions have shape (3,), amplitudes (4,)": lambda: decay_along([1.0, 2.0, 3.0], np.ones(4)),
    "gauges: an amplitude is zero; it has no logarithm": lambda: decay_along(X, 0 * X),
    "depth: 0 is not positive": lambda: expected_decay(PERIOD, 0.0, GRAVITY, 1e-6),
}


@pytest.mark.parametrize("message", FAULTS)
def test_faults_say_what_is_wrong(message):
    with pytest.raises(SceneError) as caught:
        FAULTS[message]()
    assert message in str(caught.value)
