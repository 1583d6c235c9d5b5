"""What absorbers send out again, from made-up records."""

import numpy as np
import pytest

from parsph.errors import SceneError
from parsph.verify.wave_absorption import PLACES, re_reflection
from parsph.waves import dispersion

WAVE = dispersion(1.0, 9.81, period=2.3)
PLACES_IN_M = np.array(PLACES) * WAVE.wavelength


def record(incident, reflected, end, x=PLACES_IN_M):
    """Return times and levels of ``Re[(a_i exp(-ikx) + a_r exp(ikx)) exp(iwt)]``, with a bound second harmonic."""
    t = np.arange(0, end, 0.02)
    turn = np.exp(1j * WAVE.frequency * t)
    first = incident * np.exp(-1j * WAVE.wavenumber * x) + reflected * np.exp(1j * WAVE.wavenumber * x)
    second = 0.03 * incident * np.exp(-2j * WAVE.wavenumber * x)
    return t, (np.outer(first, turn) + np.outer(second, turn**2)).real + 1.0


@pytest.mark.parametrize("rho", [0.0, 0.08, -0.3 + 0.2j])
def test_re_reflection_is_what_goes_out_of_what_came(rho):
    """Whatever the far wall sends back, its phase, and the lengths of the runs."""
    made, quiet_reflection = 0.05 * np.exp(0.4j), 0.0
    for came in (0.04 * np.exp(2j), 0.05 * np.exp(-1j)):
        records = record(made, quiet_reflection, 21.0), record(made + rho * came, came, 37.0)
        found = re_reflection(*records, PLACES_IN_M, WAVE.period, 1.0, 9.81)
        assert found == pytest.approx(rho, abs=2e-3)


def test_gauges_that_tell_nothing_apart_are_a_fault():
    x = np.array([0.0, 0.5, 1.0]) * WAVE.wavelength
    records = record(0.05, 0.0, 21.0, x), record(0.05, 0.04, 21.0, x)
    with pytest.raises(SceneError, match="half a wavelength"):
        re_reflection(*records, x, WAVE.period, 1.0, 9.81)
