"""Spectra have the energy that they are asked for, and so have their waves."""

import math

import numpy as np
import pytest

from parsph.errors import SceneError
from parsph.waves import SPECTRA, Jonswap, PiersonMoskowitz, Tabulated, components, dispersion, focused

SEA = Jonswap(0.12, 1.6)
TABLE = Tabulated([0.3, 0.6, 0.7, 1.5], [0.0, 0.004, 0.003, 0.0])
every_spectrum = pytest.mark.parametrize("spectrum", [SEA, Jonswap(0.12, 1.6, 7.0), PiersonMoskowitz(0.12, 1.6), TABLE])


@every_spectrum
def test_energy_is_the_integral_of_the_density(spectrum):
    f = np.linspace(0.0, 40, 400001)
    assert np.trapezoid(spectrum.density(f), f) == pytest.approx(spectrum.height**2 / 16, rel=1e-4)
    assert spectrum.energy == pytest.approx(spectrum.height**2 / 16)


def test_pierson_moskowitz_in_closed_form():
    """``S = (5/16) Hs^2 fp^4 f^-5 exp(-5/4 (fp/f)^4)``."""
    f, fp = np.array([0.4, 0.625, 1.0, 2.0]), 1 / 1.6
    expected = 5 / 16 * 0.12**2 * fp**4 * f**-5 * np.exp(-1.25 * (fp / f) ** 4)
    np.testing.assert_allclose(PiersonMoskowitz(0.12, 1.6).density(f), expected, rtol=1e-6)
    np.testing.assert_allclose(Jonswap(0.12, 1.6, 1.0).density(f), expected, rtol=1e-6)


def test_jonswap_peaks_at_its_period_gamma_times_as_high():
    """The usual fit of the factor for Hs = 4 sqrt(m0): ``0.0624/(0.230 + 0.0336 g - 0.185/(1.9 + g))``, good to 1 %."""
    f = np.linspace(0.3, 2, 17001)
    assert f[SEA.density(f).argmax()] == pytest.approx(1 / 1.6, abs=2e-4)
    factor = 0.0624 / (0.230 + 0.0336 * 3.3 - 0.185 / 5.2)
    expected = factor * 0.12**2 * 1.6 * math.exp(-1.25) * 3.3
    assert SEA.density(1 / 1.6) == pytest.approx(expected, rel=0.01)
    width = [SEA.density(ratio / 1.6) / PiersonMoskowitz(0.12, 1.6).density(ratio / 1.6) for ratio in (0.93, 1.09)]
    assert width[0] == pytest.approx(width[1]), "one sigma off on either side"


@every_spectrum
@pytest.mark.parametrize("jitter", [True, False])
def test_components_have_all_of_the_energy(spectrum, jitter):
    found = components(spectrum, 0.3, 2.0, 150, seed=4, jitter=jitter)
    assert found.height == pytest.approx(spectrum.height, rel=1e-12)
    assert (np.diff(found.frequency) > 0).all()
    assert found.frequency.min() >= 0.3
    assert found.frequency.max() <= 2.0
    assert ((found.phase >= 0) & (found.phase < 2 * math.pi)).all()


def test_the_same_seed_gives_the_same_waves():
    one, same, other = (components(SEA, 0.3, 2.0, 50, seed) for seed in (1, 1, 2))
    for name in ("amplitude", "frequency", "phase"):
        assert (getattr(one, name) == getattr(same, name)).all()
        assert (getattr(one, name) != getattr(other, name)).any()
    assert one.phase[0] == pytest.approx(2 * math.pi * np.random.Generator(np.random.PCG64(1)).random(), rel=1e-12)


def test_amplitudes_follow_the_density():
    found = components(SEA, 0.3, 2.5, 400, jitter=False)
    step = 2.2 / 400
    np.testing.assert_allclose(found.amplitude, np.sqrt(2 * SEA.density(found.frequency) * step), rtol=0.02)
    np.testing.assert_allclose(found.frequency, 0.3 + step * (np.arange(400) + 0.5))


def test_a_record_has_the_significant_height_and_does_not_repeat():
    """Over many periods: 4 times the standard deviation, with the scatter of so many waves."""
    found, t = components(SEA, 0.3, 2.1, 90, seed=7), np.arange(0, 600, 0.1)
    record = found.elevation(2.0, t, 0.8, 9.81)
    assert 4 * record.std() == pytest.approx(0.12, rel=0.05)
    back = 500  # rows: 1/df = 50 s, after which waves in the middle of their steps come back, here upside down

    def likeness(record):
        return np.corrcoef(record[:-back], record[back:])[0, 1]

    even = components(SEA, 0.3, 2.1, 90, seed=7, jitter=False).elevation(2.0, t, 0.8, 9.81)
    assert likeness(even) < -0.999
    assert abs(likeness(record)) < 0.5


def test_focused_waves_meet_in_the_crest_that_was_asked_for():
    found = focused(SEA, 0.09, 0.3, 2.0, 80, place=4.2, time=11.0, depth=0.8, gravity=9.81)
    x, t = np.linspace(3.2, 5.2, 201), np.linspace(1.0, 21.0, 401)
    assert found.elevation(4.2, 11.0, 0.8, 9.81) == pytest.approx(0.09, rel=1e-12)
    assert found.elevation(x, 11.0, 0.8, 9.81).argmax() == 100
    assert found.elevation(4.2, t, 0.8, 9.81).argmax() == 200
    ratio = found.amplitude / SEA.density(found.frequency)
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-12)


def test_one_component_is_a_linear_wave():
    found = components(Tabulated([0.49, 0.5, 0.51], [0.0, 1.0, 0.0]), 0.49, 0.51, 1, jitter=False)
    wave = dispersion(0.8, 9.81, period=2.0)
    assert found.wavenumbers(0.8, 9.81)[0] == pytest.approx(wave.wavenumber)
    later = found.elevation(1.0 + wave.phase_speed * 0.3, 0.3, 0.8, 9.81)
    assert later == pytest.approx(found.elevation(1.0, 0.0, 0.8, 9.81), abs=1e-12)


def test_faults_say_what_is_valid():
    with pytest.raises(SceneError, match=r"between 1 and 2 Hz there is .* % of the energy; about 0.5 to 3 times the peak"):
        components(SEA, 1.0, 2.0, 50)
    with pytest.raises(SceneError, match="0 < low < high"):
        components(SEA, 2.0, 1.0, 50)
    with pytest.raises(SceneError, match=r"gamma: is 0\.5"):
        Jonswap(0.1, 1.0, 0.5)
    for rows in (([1.0], [1.0]), ([1.0, 0.5], [1.0, 1.0]), ([1.0, 2.0], [1.0, -1.0]), ([1.0, 2.0], [0.0, 0.0])):
        with pytest.raises(SceneError, match="is no table of a spectrum"):
            Tabulated(*rows)


def test_all_spectra_are_known_by_name():
    assert set(SPECTRA) == {"jonswap", "pierson-moskowitz", "table"}
