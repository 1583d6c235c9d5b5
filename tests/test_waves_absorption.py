"""Theory of active absorption: what a paddle that follows the level in front of it sends back."""

import math

import pytest

from parsph.waves import dispersion, sent_back, tuned_absorption

G, DEPTH = 9.81, 0.7


def period(kd):
    return dispersion(DEPTH, G, wavelength=2 * math.pi * DEPTH / kd).period


@pytest.mark.parametrize("hinge", [None, 0.0, 0.4, -0.5])
@pytest.mark.parametrize("kd", [0.3, 1.0, 2.0])
def test_a_tuned_paddle_sends_nothing_back(kd, hinge):
    keys = {"hinge": hinge, "distance": 0.2 * DEPTH}
    gain, lag = tuned_absorption(period(kd), DEPTH, G, **keys)
    assert abs(sent_back(period(kd), DEPTH, G, gain, lag, **keys)) < 1e-12
    assert lag > 0 or hinge == 0.4  # whose near field is in advance of it


def test_a_paddle_at_rest_sends_all_back_and_a_tuned_one_little_of_other_waves():
    assert sent_back(period(1.0), DEPTH, G, 0.0, 0.0) == 1.0
    gain, lag = tuned_absorption(period(1.0), DEPTH, G, distance=0.4 * DEPTH)
    for kd, most in ((0.3, 0.025), (0.5, 0.025), (1.5, 0.07)):
        assert abs(sent_back(period(kd), DEPTH, G, gain, lag, distance=0.4 * DEPTH)) < most


def test_long_waves_ask_for_the_speed_of_their_water():
    """A piston moves with ``eta sqrt(g/d)``, a flap at the bed twice as fast at the level, since it moves half of the water."""
    assert tuned_absorption(period(0.02), DEPTH, G)[0] == pytest.approx(math.sqrt(G / DEPTH), rel=1e-3)
    assert tuned_absorption(period(0.02), DEPTH, G, 0.0)[0] == pytest.approx(2 * math.sqrt(G / DEPTH), rel=1e-3)


def test_a_gauge_in_front_sees_waves_earlier_than_the_paddle_does():
    """So the lag grows by the way over the phase speed."""
    near, far = (tuned_absorption(period(0.1), DEPTH, G, distance=x)[1] for x in (0.5, 0.7))
    assert far - near == pytest.approx(0.2 / dispersion(DEPTH, G, period=period(0.1)).phase_speed, rel=0.05)
