"""`parsph waves` and the rows that it prints."""

import re

import pytest
from helpers import parsph

from parsph import cli
from parsph.errors import SceneError
from parsph.waves import describe, describe_solitary


def values(rows):
    return {name: value for name, value, _ in rows}


def test_waves_prints_a_regular_wave(tmp_path):
    result = parsph("waves", "--depth", "1", "--height", "0.0956", "--wavelength", "6.061", "--gravity", "9.8", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    for part in ("period", "2.237", "phase speed", "group speed", "Ursell", "stokes", "0.17", "breaking height"):
        assert part in result.stdout, part
    assert not list(tmp_path.iterdir())


def test_waves_prints_a_solitary_wave(capsys):
    cli.app(["waves", "--solitary", "--depth", "1", "--height", "0.2"], standalone_mode=False)
    printed = capsys.readouterr().out
    for part in ("1.0328", "1.1314", "0.42413", "0.93629", "1.3443", "3.4276"):
        assert part in printed, part


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--depth", "1"], "exactly one of period, frequency and wavelength"),
        (["--depth", "1", "--period", "2", "--frequency", "0.5"], "but got period and frequency"),
        (["--depth", "1", "--solitary"], "needs --height alone"),
        (["--depth", "1", "--solitary", "--height", "0.1", "--period", "2"], "needs --height alone"),
        (["--depth", "1", "--solitary", "--height", "0.9"], "0.8332 of the depth"),
    ],
)
def test_bad_input_is_an_error(options, text):
    with pytest.raises(SceneError, match=re.escape(text)):
        cli.app(["waves", *options], standalone_mode=False)


def test_rows_of_the_pool():
    """A flap of 5 degrees hinged at the bed, 0.175 m at the still-water level, makes 0.0956 m."""
    rows = values(describe(1.0, 9.8, 0.0956, period=2.236969878))
    assert rows["wavelength"] == pytest.approx(6.061, abs=5e-4)
    assert rows["stroke, flap hinged at the bed"] == pytest.approx(0.1743, abs=2e-4)
    assert rows["regime"] == "stokes"
    assert "wave height" not in values(describe(1.0, 9.8, period=2.0)), "what depends on the height needs one"


def test_notes_say_which_limits_a_wave_is_beyond():
    def notes(*wave, **given):
        return " ".join(value for name, value, _ in describe(*wave, **given) if name == "note")

    assert notes(1.0, 9.81, 0.01, period=2.0) == ""
    assert "it breaks: 0.2 m is more than 0.142 m" in notes(1.0, 9.81, 0.2, wavelength=1.0)
    assert "too long for second-order paddles" in notes(1.0, 9.81, 0.3, wavelength=20.0)
    assert "% of the amplitude" in notes(1.0, 9.81, 0.1, period=3.0)
    with pytest.raises(SceneError, match="height: is -1; a number above 0"):
        describe(1.0, 9.81, -1.0, period=2.0)


def test_rows_of_a_solitary_wave_beyond_the_tables():
    rows = describe_solitary(1.0, 9.81, 0.65)
    names = {name for name, _, _ in rows}
    notes = [value for name, value, _ in rows if name == "note"]
    assert "celerity, rayleigh" in names
    assert not {"celerity, exact", "run-up on a vertical wall"} & names
    assert len(notes) == 2
    assert "up to 0.6 depths" in notes[0]
    assert "heights of 0.05 to 0.5 depths" in notes[1]
