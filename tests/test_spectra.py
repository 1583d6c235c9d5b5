"""Statistics and spectra of irregular records that were made up, so that what is in them is known."""

import math

import numpy as np
import pytest

from parsph.analysis import Spectrum, spectrum, statistics, wave_summary
from parsph.errors import SceneError

PEAK, HEIGHT = 0.8, 0.1  # [Hz], [m]


def jonswap(f, peak=PEAK, height=HEIGHT, gamma=3.3):
    """The shape of JONSWAP, scaled so that 4 sqrt(sum S df) is the height."""
    width = np.where(f <= peak, 0.07, 0.09)
    S = f**-5.0 * np.exp(-1.25 * (f / peak) ** -4) * gamma ** np.exp(-0.5 * ((f / peak - 1) / width) ** 2)
    return S * height**2 / 16 / (S.sum() * (f[1] - f[0]))


DURATION = 400.0  # [s], which is the repeat time too
F = np.arange(round(0.4 * DURATION), round(2.5 * DURATION)) / DURATION
S = jonswap(F)
PHASES = np.random.default_rng(1).uniform(0, 2 * np.pi, F.size)


def irregular(t):
    """Levels of a sea state, of random phases."""
    parts = zip(np.sqrt(2 * S / DURATION), F, PHASES, strict=True)
    return sum(a * np.cos(2 * np.pi * f * t + phase) for a, f, phase in parts)


T = np.arange(0, DURATION, 0.05)
LEVEL = irregular(T)


def moment(n):
    return np.sum(F**n * S) / DURATION


def test_spectral_statistics_are_those_put_in():
    found = statistics(T, 2.0 + LEVEL)
    assert found.spectral_height == pytest.approx(HEIGHT, rel=0.03)
    assert found.peak_period == pytest.approx(1 / PEAK, rel=0.04)
    assert found.energy_period == pytest.approx(moment(-1) / moment(0), rel=0.02)
    assert found.first_moment_period == pytest.approx(moment(0) / moment(1), rel=0.02)
    assert found.second_moment_period == pytest.approx(math.sqrt(moment(0) / moment(2)), rel=0.02)


def test_single_waves_are_those_of_a_narrow_gaussian_process():
    """Rayleigh's distribution: H_1/3 = 4.004 s, H_1/10 = 5.09 s, the mean 2.507 s; JONSWAP has about 5 % less."""
    found = statistics(T, LEVEL)
    deviation = LEVEL.std()
    assert found.significant_height == pytest.approx(0.95 * 4.004 * deviation, rel=0.07)
    assert found.tenth_height == pytest.approx(0.95 * 5.09 * deviation, rel=0.07)
    assert found.mean_height == pytest.approx(0.95 * 2.507 * deviation, rel=0.07)
    assert found.mean_height < found.significant_height < found.tenth_height < found.largest_height
    assert found.mean_period == pytest.approx(found.second_moment_period, rel=0.08)
    assert found.waves == pytest.approx(400 / found.mean_period, abs=2)


def test_thirds_and_tenths_by_hand():
    """Twelve waves of heights 1 to 12 and periods of their own: the highest four, and the highest one."""
    order = np.random.default_rng(2).permutation(12) + 1
    step, level = 1e-3, []
    for height in [6, *order, 6]:  # the first and the last are not whole: they make no two up-crossings of their own
        period = 1 + height / 20
        level.append(0.5 * height * np.sin(2 * np.pi * np.arange(step / 2, period, step) / period))
    level = np.concatenate([-0.5 * np.ones(1), *level, 0.5 * np.ones(1)])
    found = statistics(step * np.arange(level.size), level)
    assert found.waves in (13, 14)
    ordered = np.sort([*order, 6, 6][: found.waves])[::-1]
    third = ordered[: round(found.waves / 3)]
    assert found.significant_height == pytest.approx(third.mean(), rel=1e-3)
    assert found.significant_period == pytest.approx((1 + third / 20).mean(), rel=1e-3)
    assert (found.tenth_height, found.largest_height) == pytest.approx((12, 12), rel=1e-3)


def test_the_sum_over_lines_is_the_variance():
    """Of an untapered, unsegmented density it would be exactly; Hann's window weights times, so of a stationary record."""
    t = np.arange(0, 100, 0.02)
    found = spectrum(t, 3 + 0.5 * t + 0.04 * np.cos(2 * np.pi * 1.3 * t), segments=4)
    assert found.moment(0) == pytest.approx(0.04**2 / 2, rel=1e-3)  # neither mean nor trend count
    assert found.height == pytest.approx(4 * 0.04 / math.sqrt(2), rel=1e-3)
    assert found.peak_period == pytest.approx(1 / 1.3, rel=1e-3)


@pytest.mark.parametrize("off", [0.0, 0.3, 0.5])
def test_the_peak_lies_between_lines_too(off):
    frequency = (20 + off) / 25.0
    t = np.arange(0, 100, 0.05)
    found = spectrum(t, np.cos(2 * np.pi * frequency * t), segments=4)
    assert 1 / found.peak_period == pytest.approx(frequency, abs=0.2 / 25)  # a fifth of what lines are apart


def test_moments_by_hand():
    found = Spectrum(np.array([1.0, 2.0, 3.0]), np.array([0.0, 4.0, 2.0]))
    assert [found.moment(n) for n in (-1, 0, 1, 2)] == pytest.approx([2 + 2 / 3, 6, 14, 34])
    assert found.peak_period == pytest.approx((4**4 + 2**4) / (2 * 4**4 + 3 * 2**4))
    assert found.first_moment_period == pytest.approx(6 / 14)


def test_the_band_leaves_out_what_is_beyond():
    swell = 0.2 * np.cos(2 * np.pi * 0.1 * T) + 0.02 * np.cos(2 * np.pi * 7 * T)
    found = spectrum(T, LEVEL + swell, 0.35, 3.0)
    assert found.height == pytest.approx(HEIGHT, rel=0.03)
    assert (found.frequency.min() >= 0.35) & (found.frequency.max() <= 3.0)
    assert spectrum(T, LEVEL + swell).height > 4 * HEIGHT


def test_samples_at_other_times_are_interpolated():
    """Linearly, which takes a little of the short waves."""
    rng = np.random.default_rng(3)
    t = T + rng.uniform(-0.02, 0.02, T.size)
    uneven, even = spectrum(t, irregular(t), segments=5), spectrum(T, LEVEL, segments=5)
    assert uneven.height == pytest.approx(even.height, rel=0.01)
    assert uneven.peak_period == pytest.approx(even.peak_period, rel=0.005)


def test_more_segments_are_smoother_lines_further_apart():
    few, many = spectrum(T, LEVEL, segments=2), spectrum(T, LEVEL, segments=16)
    assert many.frequency[0] == pytest.approx(8 * few.frequency[0])
    assert len(few.frequency) == pytest.approx(8 * len(many.frequency), rel=0.01)
    roughness = [np.abs(np.diff(found.density, 2)).sum() for found in (few, many)]
    assert roughness[1] < 0.2 * roughness[0]


def test_regular_waves_have_one_height():
    t = np.arange(0, 30, 0.01)
    found, summary = statistics(t, 0.05 * np.cos(2 * np.pi * t / 1.5)), wave_summary(t, 0.05 * np.cos(2 * np.pi * t / 1.5))
    assert found.significant_height == pytest.approx(summary.height, rel=1e-6)
    assert found.spectral_height == pytest.approx(0.1 * math.sqrt(2), rel=0.01)
    for period in (found.mean_period, found.significant_period, found.peak_period):
        assert period == pytest.approx(1.5, rel=0.01)
    short = statistics(t[:700], np.cos(2 * np.pi * t[:700] / 1.5))
    assert short.tenth_height is None
    assert short.waves == 3


FAULTS = {
    "whole wave(s) in 2.95 s; the highest third of the waves needs 3 at least": lambda: statistics(T[:60], LEVEL[:60]),
    "0 whole wave(s) in 399.95 s": lambda: statistics(T, 0 * T),
    "record: the level does not move": lambda: spectrum(T, 0 * T + 1),
    "record: 8000 samples do not make 900 segments; a segment has 16 samples at least; take 14400 samples": lambda: spectrum(
        T, LEVEL, segments=900
    ),
    "do not make 0 segments": lambda: spectrum(T, LEVEL, segments=0),
    "frequencies: low = 2 Hz and high = 1 Hz make no range": lambda: spectrum(T, LEVEL, 2.0, 1.0),
    "take 0 <= low < high <= 10 Hz": lambda: spectrum(T, LEVEL, 2.0, 11.0),
    "two frequencies from 1.001 to 1.019 Hz; segments of 50 s have one every 0.02 Hz; take segments of 111 s": lambda: spectrum(
        T, LEVEL, 1.001, 1.019, segments=8
    ),
    "record: times do not increase": lambda: statistics(T[::-1], LEVEL),
}


@pytest.mark.parametrize("message", FAULTS)
def test_faults_say_what_is_wrong(message):
    with pytest.raises(SceneError) as caught:
        FAULTS[message]()
    assert message in str(caught.value)
