"""Analysis of records that were made up, so that what is in them is known."""

import cmath
import itertools
import math
import subprocess
import sys

import numpy as np
import pytest

from parsph.analysis import (
    energy_difference,
    harmonics,
    kinetic_energy,
    level_difference,
    mean_height,
    reflection,
    reflection_ratio,
    reflection_spectrum,
    separate,
    wave_summary,
    waves_of,
)
from parsph.errors import SceneError
from parsph.waves import wavenumber

PERIOD, DEPTH, GRAVITY = 2.0, 1.0, 9.81
K = wavenumber(2 * math.pi / PERIOD, DEPTH, GRAVITY)
WAVELENGTH = 2 * math.pi / K
LAYOUTS = {2: [3.0, 4.1], 3: [3.0, 3.6, 4.5], 5: [7.3, 2.0, 2.9, 4.45, 5.5]}


def levels_of(t, x, incident, reflected, period=PERIOD, still=0.0):
    """Levels (gauges, samples) of the two waves, complex amplitudes at x = 0, written with cosines."""
    k, w = wavenumber(2 * math.pi / period, DEPTH, GRAVITY), 2 * math.pi / period
    x = np.asarray(x)[:, None]
    there = abs(incident) * np.cos(w * t - k * x + cmath.phase(incident))
    back = abs(reflected) * np.cos(w * t + k * x + cmath.phase(reflected))
    return still + there + back


# Records


@pytest.mark.parametrize("uniform", [True, False])
def test_harmonics_are_those_put_in(uniform):
    rng = np.random.default_rng(5)
    t = np.linspace(10.3, 17.0, 300) if uniform else np.sort(rng.uniform(10.3, 17.0, 300))
    w = 2 * math.pi / PERIOD
    level = 0.7 + 0.05 * np.cos(w * t + 1.1) + 0.01 * np.cos(2 * w * t - 2.3)
    expected = [0.7, cmath.rect(0.05, 1.1), cmath.rect(0.01, -2.3)]
    np.testing.assert_allclose(harmonics(t, level, PERIOD), expected, atol=1e-13)
    np.testing.assert_allclose(harmonics(t, level, PERIOD, count=4), [*expected, 0, 0], atol=1e-13)


def test_a_whole_period_survives_rounding():
    t = np.linspace(0, PERIOD * (1 - 1e-12), 50)
    assert harmonics(t, np.cos(2 * math.pi * t / PERIOD), PERIOD)[1] == pytest.approx(1)


def test_mean_height_of_growing_waves():
    t = np.arange(401) / 100
    level = np.where(t < 2, 1.0, 3.0) * np.sin(2 * math.pi * t / PERIOD)
    assert mean_height(t, level, PERIOD) == pytest.approx((2 + 6) / 2)
    assert mean_height(t[:350], level[:350], PERIOD) == pytest.approx(2)  # the second wave is not whole


def test_waves_of_a_polygon():
    """Three up-crossings on straight lines; the first and the last wave are not whole."""
    t = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0])
    level = np.array([-1.0, 1.0, -2.0, 2.0, -2.0, 2.0])
    mean = np.array([1.0, 1.0, 1.5, 1.5, 1.0, 1.0]) @ level / 7  # each sample by the time it stands for
    crossings = [0 + (mean + 1) / 2, 2 + (mean + 2) / 2, 5 + (mean + 2) / 4]
    heights, periods = waves_of(t, level)
    np.testing.assert_allclose(heights, [3, 4])
    np.testing.assert_allclose(periods, np.diff(crossings))


def test_waves_of_a_record_of_different_waves():
    """Waves of 1, 2 and 1.5 s between half waves."""
    step, pieces = 1e-3, [(1.0, -0.2, 0.5), (1.0, 0.1, 1), (2.0, 0.3, 1), (1.5, 0.2, 1), (1.0, 0.2, 0.5)]
    level = np.concatenate([a * np.sin(2 * math.pi * np.arange(0, part * T - step / 2, step) / T) for T, a, part in pieces])
    t = 7 + step * np.arange(level.size)
    heights, periods = waves_of(t, level + 1.5)
    np.testing.assert_allclose(heights, [0.2, 0.6, 0.4], rtol=1e-4)
    np.testing.assert_allclose(periods, [1.0, 2.0, 1.5], atol=1e-3)
    summary = wave_summary(t, level + 1.5)
    assert (summary.height, summary.period, summary.waves) == pytest.approx((0.4, 1.5, 3), rel=1e-3)


@pytest.mark.parametrize("period", [None, PERIOD])
def test_wave_summary_of_a_regular_record(period):
    t = np.arange(-0.2, 9.9, 0.005)
    summary = wave_summary(t, 1.2 + 0.04 * np.cos(2 * math.pi * t / PERIOD - 0.8), period)
    assert summary.mean == pytest.approx(1.2, abs=1e-6)
    assert summary.height == pytest.approx(0.08, rel=1e-4)
    assert summary.period == pytest.approx(PERIOD, rel=1e-5)
    assert summary.phase == pytest.approx(-0.8, abs=1e-4)
    assert summary.waves == (5 if period else 4)  # up-crossings at 1.75, 3.75, ..., 9.75 s


def test_a_given_period_is_not_cut_in_two_by_noise():
    t = np.arange(0, 10.001, 0.01)
    noise = np.random.default_rng(1).normal(0, 0.003, t.size)
    level = 0.05 * np.sin(2 * math.pi * t / PERIOD) + noise
    assert waves_of(t, level)[0].size > 5
    summary = wave_summary(t, level, PERIOD)
    assert summary.waves == 5
    assert summary.height == pytest.approx(0.1, rel=0.2)
    assert summary.phase == pytest.approx(-math.pi / 2, abs=5 * 0.003 / 0.05 * math.sqrt(2 / t.size))


# Reflection


@pytest.mark.parametrize("gauges", LAYOUTS)
@pytest.mark.parametrize(("ratio", "phase"), [(0, 0.0), (0.02, 1.0), (0.3, -2.5), (0.7, 3.0), (1, 0.4)])
def test_known_reflection_is_recovered(gauges, ratio, phase):
    t, x = np.arange(4.0, 13.7, 0.02), LAYOUTS[gauges]
    incident, reflected = cmath.rect(0.05, 0.9), cmath.rect(0.05 * ratio, phase)
    w = 2 * math.pi / PERIOD
    levels = levels_of(t, x, incident, reflected, still=DEPTH) + 0.004 * np.cos(2 * w * t - 1.0)
    method = "goda-suzuki" if gauges == 2 else "mansard-funke"
    found = reflection(t, levels, x, PERIOD, DEPTH, GRAVITY, method)
    assert found.incident == pytest.approx(0.05, rel=1e-10)
    assert found.reflected == pytest.approx(0.05 * ratio, abs=1e-10 * 0.05)
    assert found.coefficient == pytest.approx(ratio, abs=1e-10)
    assert found.residual < 1e-10
    assert found.wavenumber == K
    amplitudes = [harmonics(t, level, PERIOD)[1] for level in levels]
    np.testing.assert_allclose(separate(x, amplitudes, K), [incident, reflected], atol=1e-11)


@pytest.mark.parametrize("gauges", LAYOUTS)
def test_noise_moves_the_reflection_as_statistics_say(gauges):
    """A gauge's amplitude has variance 4 s^2/N (2 s^2/N a part), a wave's 4 s^2/N / (n (1 - |mean exp(2ikx)|^2))."""
    t, x, noise = np.arange(200) * PERIOD / 50, np.array(LAYOUTS[gauges]), 0.002
    clean = levels_of(t, x, 0.05, 0.01)
    rng, found = np.random.default_rng(11), []
    method = "goda-suzuki" if gauges == 2 else "mansard-funke"
    for _ in range(400):
        separation = reflection(t, clean + rng.normal(0, noise, clean.shape), x, PERIOD, DEPTH, GRAVITY, method)
        found.append((separation.incident, separation.reflected, separation.residual))
    incident, reflected, residual = np.array(found).T
    whole = 3 * 50  # samples used: the last three whole periods
    variance = 4 * noise**2 / whole
    one = variance / (gauges * (1 - abs(np.mean(np.exp(2j * K * x))) ** 2))
    for amplitude, expected in ((incident, 0.05), (reflected, 0.01)):
        assert abs(amplitude.mean() - expected) < 5 * math.sqrt(0.5 * one / 400) + one / expected
        assert amplitude.std() == pytest.approx(math.sqrt(0.5 * one), rel=0.2)
    left = math.sqrt(variance * (gauges - 2) / gauges) / 0.05  # two of n complex numbers are fitted
    assert math.sqrt(np.mean(residual**2)) == pytest.approx(left, rel=0.1, abs=1e-12)


def test_residual_is_the_root_mean_square_of_what_no_two_waves_explain():
    t, x = np.arange(0, 6.001, 0.02), np.array(LAYOUTS[5])
    two_waves = np.exp(1j * K * np.outer([-1, 1], x))
    unexplained = np.linalg.svd(two_waves.conj())[2][-1].conj()  # of length one, orthogonal to both
    levels = levels_of(t, x, 0.05, 0.01) + np.real(0.003 * unexplained[:, None] * np.exp(2j * math.pi * t / PERIOD))
    found = reflection(t, levels, x, PERIOD, DEPTH, GRAVITY)
    assert (found.incident, found.reflected) == pytest.approx((0.05, 0.01), rel=1e-9)
    assert found.residual == pytest.approx(0.003 / math.sqrt(5) / 0.05, rel=1e-9)


def test_three_gauges_are_the_closed_form_of_mansard_and_funke():
    """Z_I and Z_R of Mansard & Funke (1980), beta = k x12, gamma = k x13, with the other sign of i.

    The amplitudes are not those of two waves, so that the least squares count.
    """
    rng = np.random.default_rng(2)
    for x12, x13 in [(0.1, 0.25), (0.1, 0.3), (0.07, 0.33), (-0.1, 0.2)]:
        beta, gamma = 2 * math.pi * x12, 2 * math.pi * x13
        B = rng.normal(size=3) + 1j * rng.normal(size=3)
        sin, cos = math.sin, math.cos
        D = 2 * (sin(beta) ** 2 + sin(gamma) ** 2 + sin(gamma - beta) ** 2)
        R = np.array([sin(beta) ** 2 + sin(gamma) ** 2, sin(gamma) * sin(gamma - beta), -sin(beta) * sin(gamma - beta)])
        Q = np.array(
            [
                sin(beta) * cos(beta) + sin(gamma) * cos(gamma),
                sin(gamma) * cos(gamma - beta) - 2 * sin(beta),
                sin(beta) * cos(gamma - beta) - 2 * sin(gamma),
            ]
        )
        found = separate(WAVELENGTH * np.array([0, x12, x13]), B, K)
        np.testing.assert_allclose(found, [B @ (R - 1j * Q) / D, B @ (R + 1j * Q) / D], rtol=1e-12)


def test_two_gauges_are_the_closed_form_of_goda_and_suzuki():
    """a_I, a_R of Goda & Suzuki (1976) from A cos wt + B sin wt at two gauges."""
    rng = np.random.default_rng(4)
    for part in (0.06, 0.2, 0.44, 0.7):
        (A1, A2), (B1, B2), kD = rng.normal(size=2), rng.normal(size=2), 2 * math.pi * part
        sin, cos = math.sin(kD), math.cos(kD)
        incident = math.hypot(A2 - A1 * cos - B1 * sin, B2 + A1 * sin - B1 * cos) / (2 * abs(sin))
        reflected = math.hypot(A2 - A1 * cos + B1 * sin, B2 - A1 * sin - B1 * cos) / (2 * abs(sin))
        found = separate([2.0, 2.0 + part * WAVELENGTH], [A1 - 1j * B1, A2 - 1j * B2], K)
        np.testing.assert_allclose(np.abs(found), [incident, reflected], rtol=1e-10)


@pytest.mark.parametrize(
    ("part", "good"), [(0.049, False), (0.051, True), (0.449, True), (0.451, False), (0.549, False), (0.551, True)]
)
def test_two_gauges_have_the_range_of_goda_and_suzuki(part, good):
    x = [1.0, 1.0 + part * WAVELENGTH]
    if good:
        separate(x, [1, 1], K)
    else:
        with pytest.raises(SceneError, match=f"{part} of the wavelength 5.2.* m; .*half a wavelength.*; take 0.05 to 0.45"):
            separate(x, [1, 1], K)


@pytest.mark.parametrize("start", [0.0, 31.7])
def test_spectrum_of_known_reflections(start):
    """Three frequencies of one repeat time; all others in the range, its ends included, are empty."""
    t, x, repeat = start + np.arange(800) * 0.04, [3.0, 3.6, 4.5], 32.0
    waves = {20 / repeat: (0.02, 0.004), 25 / repeat: (0.03, 0.0), 12 / repeat: (0.01, 0.01j)}
    levels = DEPTH + sum(levels_of(t, x, *pair, period=1 / f) for f, pair in waves.items())
    levels += 0.05 * np.cos(2 * math.pi * 3 / repeat * t)  # outside of the range
    found = reflection_spectrum(t, levels, x, DEPTH, GRAVITY, 10 / repeat, 28 / repeat)
    frequencies = np.arange(10, 29) / repeat
    np.testing.assert_allclose(found.frequency, frequencies, rtol=1e-9)
    expected = np.abs([waves.get(f, (0, 0)) for f in frequencies])
    np.testing.assert_allclose(np.stack([found.incident, found.reflected], axis=1), expected, atol=1e-12)
    assert found.coefficient == pytest.approx(math.sqrt((0.004**2 + 0.01**2) / (0.02**2 + 0.03**2 + 0.01**2)), rel=1e-10)


def test_spectrum_leaves_out_frequencies_where_the_gauges_are_blind():
    t, repeat = np.arange(400) * 0.05, 20.0
    blind = wavenumber(2 * math.pi * 16 / repeat, DEPTH, GRAVITY)
    x = [2.0, 2.0 + math.pi / blind, 2.0 + 2 * math.pi / blind]
    levels = levels_of(t, x, 0.02, 0.01, period=repeat / 12) + levels_of(t, x, 0.02, 0.02, period=repeat / 16)
    found = reflection_spectrum(t, levels, x, DEPTH, GRAVITY, 0.5, 0.9)
    np.testing.assert_allclose(found.frequency * repeat, [10, 11, 12, 13, 14, 15, 17, 18], rtol=1e-9)
    assert found.coefficient == pytest.approx(0.5, rel=1e-9)


# Differences between runs


def run_of(ids, position, density, velocity, mass=2.0):
    columns = {"id": np.array(ids), "position": position, "density": density, "velocity": velocity}
    return {key: np.asarray(column) * (1 if key == "id" else 1.0) for key, column in columns.items()} | {
        "mass": np.full(len(ids), mass)
    }


X = np.arange(10.0)
INFINITE = run_of(range(10), X, 1 + 0 * X, 0.1 * X)
WALL = run_of(range(10), X + 0.3, 1 + 0.02 * np.sin(X), 0.1 * X + 0.03 * np.cos(X))


def mixed(run, seed):
    order = np.random.default_rng(seed).permutation(run["id"].size)
    return {key: column[order] for key, column in run.items()}


def test_energy_difference_by_hand():
    energy = energy_difference(*np.array([[2.0, 3.0], [1.0, 0.0], [4.0, 6.0], [1.0, 3.0], [0.0, 2.0]]), 10.0)
    assert energy == 4 / 1 * (5 * 1 + 0.5 * 2 * 1) + 6 / 3 * (0 + 0.5 * 3 * 4)


def test_reflection_ratio_of_no_total_and_half_a_reflection():
    half = run_of(range(10), X, 1 + 0.01 * np.sin(X), 0.1 * X)
    full = run_of(range(10), X, 1 + 0.02 * np.sin(X), 0.1 * X)
    assert reflection_ratio(INFINITE, WALL, INFINITE, 9.8, (0, 9)) == 0
    assert reflection_ratio(WALL, WALL, INFINITE, 9.8, (0, 9)) == 1
    assert reflection_ratio(half, full, INFINITE, 9.8, (0, 9)) == pytest.approx(0.5, rel=1e-12)


def test_reflection_ratio_matches_particles_by_id_in_the_window_of_the_infinite_run():
    layer = run_of(range(10), X, 1 + 0.01 * np.sin(X), 0.1 * X)
    layer["density"][9] = 5.0  # outside of the window
    longer = run_of(range(2, 14), np.arange(2.0, 14), np.ones(12), 0.1 * np.arange(2.0, 14))
    fewer = {key: np.delete(column, 4) for key, column in WALL.items()}
    straight = reflection_ratio(layer, fewer, longer, 9.8, (1, 8))
    ids = [2, 3, 5, 6, 7, 8]
    parts = [
        sum(0.5 * 9.8 * (run["density"] - 1)[ids] ** 2 + 0.5 * run["density"][ids] * (run["velocity"] - 0.1 * X)[ids] ** 2)
        for run in (layer, WALL)
    ]
    assert straight == pytest.approx(math.sqrt(parts[0] / parts[1]), rel=1e-12)
    for seeds in itertools.product((1, 2), repeat=3):
        shuffled = [mixed(run, seed) for run, seed in zip((layer, fewer, longer), seeds, strict=True)]
        assert reflection_ratio(*shuffled, 9.8, (1, 8)) == pytest.approx(straight, rel=1e-12)


def test_kinetic_energy_of_a_box():
    position = np.array([[0.0, 0.0], [1.0, 0.5], [2.0, 0.5], [1.0, 2.0]])
    velocity = np.array([[3.0, 4.0], [1.0, 1.0], [9.0, 9.0], [9.0, 9.0]])
    assert kinetic_energy(position, velocity, np.array([2.0, 3.0, 1.0, 1.0]), (0, 0), (2, 1)) == 0.5 * (2 * 25 + 3 * 2)
    assert kinetic_energy(position, velocity, np.ones(4), (5, 5), (6, 6)) == 0


def test_level_difference_is_relative_to_the_motion_of_the_reference():
    t = np.arange(100) * 0.1
    reference = np.stack([1 + np.sin(2 * math.pi * t / 2), 3 + 2 * np.cos(2 * math.pi * t / 2)])
    assert level_difference(t, reference, reference) == 0
    assert level_difference(t, reference + 0.1, reference) == pytest.approx(0.1 / math.sqrt(0.5 * (1 + 4) / 2))
    assert level_difference(t, 1.2 * reference - 0.2 * np.array([[1], [3]]), reference) == pytest.approx(0.2)


def test_level_difference_weights_samples_by_their_time():
    fine, coarse = np.arange(0, 10, 0.01), np.arange(10, 20, 0.1)
    t = np.concatenate([fine, coarse])
    reference = np.sin(math.pi * t)[None]
    levels = reference + np.where(t < 10, 0.0, 0.1)
    assert level_difference(t, levels, reference) == pytest.approx(0.1 * math.sqrt(0.5) / math.sqrt(0.5), rel=0.01)


# Errors

T = np.arange(0, 8, 0.05)
LEVELS = levels_of(T, LAYOUTS[3], 0.05, 0.01)
SINE = np.sin(math.pi * T)
TWO_COLUMNS = INFINITE | {"velocity": np.ones((10, 2))}
FAULTS = {
    "record: times have shape (160,), levels (159,)": lambda: harmonics(T, SINE[1:], 2.0),
    "record: times do not increase": lambda: waves_of(T[::-1], SINE),
    "record: levels are not all finite": lambda: waves_of(T, SINE * np.where(T > 7, np.nan, 1)),
    "record: 7.95 s are shorter than a period of 8.5 s": lambda: harmonics(T, SINE, 8.5),
    "record: 7.95 s are shorter than a period of 9 s; no whole wave": lambda: wave_summary(T, SINE, 9.0),
    "period: 0 is not positive": lambda: harmonics(T, SINE, 0.0),
    "too few samples: 4 in 3 periods": lambda: harmonics([0, 2, 4, 6], [0, 0, 0, 0], 2.0),
    "too few samples: 160 in 159 periods": lambda: harmonics(T, SINE, 0.05),
    "5 unknowns in each period; sample more often": lambda: harmonics(T[::10], SINE[::10], 2.0),
    "record: no whole wave is in it; the level crosses its mean upwards fewer": lambda: wave_summary(T[:30], SINE[:30]),
    "no whole wave": lambda: wave_summary(T, 0 * T + 0.1),
    "gauges: positions have shape (3,), amplitudes (2,)": lambda: separate([0, 1, 2], [1, 1], K),
    "gauges: positions have shape (1,)": lambda: separate([0], [1], K),
    "wavenumber: 0 is not positive": lambda: separate([0, 1], [1, 1], 0.0),
    "all of the 3 gauges stand": lambda: separate(np.array([0, 0.5, 1.51]) * WAVELENGTH, [1, 1, 1], K),
    "positions have shape (2,), levels (3, 160)": lambda: reflection(T, LEVELS, [0, 1], PERIOD, DEPTH, GRAVITY),
    'method "mansard-funke" does not suit 2 gauge(s); take method "goda-suzuki" for two': lambda: reflection(
        T, LEVELS[:2], LAYOUTS[2], PERIOD, DEPTH, GRAVITY
    ),
    'method "goda-suzuki" does not suit 3': lambda: reflection(T, LEVELS, LAYOUTS[3], PERIOD, DEPTH, GRAVITY, "goda-suzuki"),
    'method "guess" does not suit': lambda: reflection(T, LEVELS, LAYOUTS[3], PERIOD, DEPTH, GRAVITY, "guess"),
    "depth: -1 is not positive": lambda: reflection(T, LEVELS, LAYOUTS[3], PERIOD, -1.0, GRAVITY),
    "shorter than a period of 20 s": lambda: reflection(T, LEVELS, LAYOUTS[3], 20.0, DEPTH, GRAVITY),
    "no incident wave": lambda: reflection(T, 0 * LEVELS + 1, LAYOUTS[3], PERIOD, DEPTH, GRAVITY),
    "times are not uniform": lambda: reflection_spectrum(T + 1e-3 * SINE, LEVELS, LAYOUTS[3], DEPTH, GRAVITY, 0.3, 0.9),
    "take 0 < low < high < 10 Hz": lambda: reflection_spectrum(T, LEVELS, LAYOUTS[3], DEPTH, GRAVITY, 0.3, 11.0),
    "no usable frequency from 0.3 to 0.9 Hz; the record of 8 s has 5 there": lambda: reflection_spectrum(
        T, LEVELS, [1.0, 1.0, 1.0], DEPTH, GRAVITY, 0.3, 0.9
    ),
    "of 8 s has 0 there": lambda: reflection_spectrum(T, LEVELS, LAYOUTS[3], DEPTH, GRAVITY, 0.51, 0.52),
    "gauges: no incident wave": lambda: reflection_spectrum(T, 0 * LEVELS, LAYOUTS[3], DEPTH, GRAVITY, 0.3, 0.9),
    "layer run: velocity has shape (10, 2) for 10 particles": lambda: reflection_ratio(
        TWO_COLUMNS, WALL, INFINITE, 9.8, (0, 9)
    ),
    "no particle of all three runs lies from 20 to 30 m": lambda: reflection_ratio(WALL, WALL, INFINITE, 9.8, (20, 30)),
    "the reflecting run equals the infinite one": lambda: reflection_ratio(WALL, INFINITE, INFINITE, 9.8, (0, 9)),
    "levels have shape (2, 160), the reference (3, 160)": lambda: level_difference(T, LEVELS[:2], LEVELS),
    "times have shape (159,)": lambda: level_difference(T[1:], LEVELS, LEVELS),
    "gauges: the reference stands still": lambda: level_difference(T, LEVELS, 0 * LEVELS + 0.1),
}


@pytest.mark.parametrize("message", FAULTS)
def test_faults_say_what_is_wrong(message):
    with pytest.raises(SceneError) as caught:
        FAULTS[message]()
    assert message in str(caught.value)


def test_analysis_loads_neither_numba_nor_the_solver():
    heavy = "{'numba', 'mpi4py', 'scipy', 'parsph.jit', 'parsph.simulation'}"
    code = f"import sys, parsph.analysis; sys.exit(bool({heavy} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_the_last_periods_are_as_many_as_asked_for():
    """At a sampling interval that does not divide the period too: the last two of heights 9, 2, 6 have the mean 4."""
    period, t = 2.236969878, np.arange(0, 3 * 2.236969878, 0.02)
    t = t + 3 * period - t[-1]
    level = np.choose(np.minimum((t / period).astype(int), 2), [4.5, 1.0, 3.0]) * np.sin(2 * np.pi * t / period)
    assert mean_height(t, level, period, 2) == pytest.approx(4.0, rel=2e-3)


@pytest.mark.parametrize("periods", [1, 2, 3])
def test_reflection_takes_the_last_periods_and_no_others(periods):
    """The waves before them are of another reflection."""
    period, depth, gravity, x = 2.236969878, 1.0, 9.8, np.array([2.0, 2.6, 3.5])
    k = wavenumber(2 * np.pi / period, depth, gravity)
    t = np.arange(0, 6 * period, 0.02)
    share = np.where(t > t[-1] - periods * period, 0.1, 0.5)
    turn = 2 * np.pi * t / period
    levels = np.array([0.05 * np.cos(turn - k * place) + 0.05 * share * np.cos(turn + k * place) for place in x])
    found = reflection(t, levels, x, period, depth, gravity, periods=periods)
    assert found.coefficient == pytest.approx(0.1, abs=1e-3)
    assert reflection(t, levels, x, period, depth, gravity, periods=periods + 1).coefficient > 0.15
