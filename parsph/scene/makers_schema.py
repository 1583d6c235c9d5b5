"""The keys of what makes waves and of what they move: wavemaker, its absorption, relaxation zones, bodies."""

from typing import Annotated, Literal

from pydantic import Field

from ..wavemakers.series import LENGTHS, TIMES
from ..waves import REGULAR_THEORIES, SOLITARY_THEORIES, SPECTRA, dispersion, regular_wave
from .fields import LARGEST, Count, FilePath, NotNegative, Number, Point, Positive, Section, Text

MOST_ROWS = 10_000  # of a table of a spectrum
_PERIOD = "one of period [s], frequency [Hz] and wavelength [m]"


class Oscillation(Section):
    """A prescribed oscillation of the plate, ramp(t) sin(2 pi t / period) times its amplitude."""

    kind: Literal["oscillation"]
    angle: Annotated[float, Field(gt=0, lt=45)] | None = Field(None, description="amplitude of a flap's angle [degrees]")
    stroke: Positive | None = Field(None, description="twice the amplitude of its way at the still-water level [m]")
    period: Positive = Field(description="period [s]")
    ramp: NotNegative = Field(0.0, description="duration of the smooth start [s]; 0: sudden")
    cycles: Count | None = Field(None, description="so many oscillations; default: without end")


class Regular(Section):
    """Regular waves of a height and a period."""

    kind: Literal["regular"]
    height: Positive = Field(description="wave height, crest to trough [m]")
    period: Positive | None = Field(None, description=f"[s]; {_PERIOD}")
    frequency: Positive | None = Field(None, description=f"[Hz]; {_PERIOD}")
    wavelength: Positive | None = Field(None, description=f"[m]; {_PERIOD}")
    order: Literal[1, 2] = Field(2, description="of the paddle's motion: 2 cancels the free second harmonic")
    ramp: NotNegative | None = Field(None, description="duration of the smooth start [s]; default: two periods")


class _OfSpectrum(Section):
    spectrum: Literal[*SPECTRA] = Field("jonswap", description="shape of the spectrum")
    period: Positive | None = Field(None, description="peak period Tp [s]; of jonswap and pierson-moskowitz")
    gamma: Annotated[float, Field(ge=1, le=20)] = Field(3.3, description="peak enhancement of jonswap [-]")
    frequencies: Annotated[list[Positive], Field(min_length=2, max_length=MOST_ROWS)] | None = Field(
        None, description="of the spectrum table, increasing [Hz]"
    )
    densities: Annotated[list[Annotated[float, Field(ge=0, le=LARGEST)]], Field(min_length=2, max_length=MOST_ROWS)] | None = (
        Field(None, description="of the spectrum table, at its frequencies [m^2/Hz]")
    )
    ramp: NotNegative | None = Field(None, description="duration of the smooth start [s]; default: two peak periods")


class Irregular(_OfSpectrum):
    """Irregular waves of a spectrum, long-crested."""

    kind: Literal["irregular"]
    height: Positive | None = Field(
        None, description="significant wave height Hs [m]; default, of table alone: that of the densities"
    )
    seed: Annotated[int, Field(ge=0, lt=2**64)] = Field(
        1, description="of the random phases; the same seed gives the same waves"
    )
    duration: Positive | None = Field(None, description="after so long the waves repeat [s]; default: the length of the run")


class Focused(_OfSpectrum):
    """A focused group: the crests of all components meet at a place and a time."""

    kind: Literal["focused"]
    crest: Positive = Field(description="height of the crest at the focus over the still water, by linear theory [m]")
    place: Positive = Field(description="distance of the focus from the wavemaker [m]")
    time: Positive = Field(description="when it focuses [s]")


class SolitaryWave(Section):
    """A solitary wave (Goring 1978)."""

    kind: Literal["solitary"]
    height: Positive = Field(description="of the crest over the still water [m]")
    theory: Literal[*SOLITARY_THEORIES] = Field("exact", description="whose profile and celerity the piston follows")
    start: NotNegative = Field(0.0, description="when the piston sets out [s]")


class Series(Section):
    """A measured motion of the plate, from a file of two columns, time and way."""

    kind: Literal["series"]
    file: FilePath = Field(
        description="text file of two columns, time and way at the still-water level (or angle); # begins a comment; "
        "relative to the scene's file"
    )
    unit: Literal[*LENGTHS] = Field(description="of the second column")
    time_unit: Literal[*TIMES] = Field("s", description="of the first column")
    start: NotNegative | None = Field(
        None,
        description="duration of a smooth start from rest [s], added before the record; default: as long as its speed needs",
    )


WAVE_KINDS = ("oscillation", "regular", "irregular", "focused", "solitary", "series")
Wave = Annotated[Oscillation | Regular | Irregular | Focused | SolitaryWave | Series, Field(discriminator="kind")]


class Absorption(Section):
    """Active absorption: the plate takes up what comes back to it."""

    distance: Positive | None = Field(
        None, description="of the level gauge in front of the plate [m]; default: the support radius"
    )
    filter: Positive | None = Field(
        None,
        description="time within which the plate follows the gauge [s]; default: what theory asks for",
    )
    reach: Positive | None = Field(None, description="how far it may leave its course [m]; default: half the depth")
    acceleration: Positive | None = Field(None, description="largest it may add [m/s^2]; default: 0.5 g")
    centering: Positive | None = Field(
        None, description="time within which it drifts back to its course [s]; default: 60 sqrt(depth/g)"
    )


class Wavemaker(Section):
    """A plate that makes waves, in place of the left wall or of a polygon wall."""

    kind: Literal["piston", "flap"] = Field("flap", description="a plate that slides along x, or one that turns about a hinge")
    wall: Text = Field("left", description="the wall that it moves: left, or the name of a polygon wall")
    hinge: Number | None = Field(
        None, description="height of a flap's hinge [m], on the vertical axis; may be below the bed; default: at the bed"
    )
    wave: Wave = Field(description="what it makes")
    absorption: Absorption | None = Field(None, description="active absorption; default: none")


class Relaxation(Section):
    """A zone at an end of the domain in which the flow is relaxed towards that of a wave to larger x, or towards still water.

    At the left it makes that wave, and takes up what comes back to it; at the right, with height 0, it takes up what comes.
    The phase is the same everywhere: a crest at x = 0 at t = 0.
    """

    side: Literal["left", "right"] = Field("left", description="end of the domain")
    length: Positive = Field(description="of the zone [m]; half a wavelength or more")
    height: NotNegative = Field(description="wave height, crest to trough [m]; 0 relaxes to still water")
    period: Positive | None = Field(None, description=f"[s]; {_PERIOD}")
    frequency: Positive | None = Field(None, description=f"[Hz]; {_PERIOD}")
    wavelength: Positive | None = Field(None, description=f"[m]; {_PERIOD}")
    theory: Literal[*REGULAR_THEORIES] = Field("fenton", description="of the wave")
    ramp: NotNegative | None = Field(None, description="duration of the smooth start [s]; default: two periods")
    rate: Positive | None = Field(None, description="of the relaxation at the end of the domain [1/s]; default: 40 per period")
    density: Literal["none", "matched"] = Field(
        "matched",
        description="relax the density too: matched, so hard that differences in level decay as fast as those in velocity, "
        "with the mass that takes; none: the velocity alone, which takes a wavelength, and a rate of about 30 per period",
    )

    def target(self, depth, gravity):
        """Return the `RegularWave` that the flow is relaxed to, on `depth` [m] under `gravity` [m/s^2]; None: still water.

        Raises
        ------
        SceneError
            When there is no such wave.
        """
        if self.height == 0:
            return None
        return regular_wave(self.height, depth, gravity, self.period, self.frequency, self.wavelength, self.theory)

    def own_period(self, depth, gravity):
        """Return the period [s] of its waves, None where it names none."""
        wave = self.target(depth, gravity)
        if wave is not None:
            return wave.period
        if self.period is None and self.frequency is None and self.wavelength is None:
            return None
        return dispersion(depth, gravity, self.period, self.frequency, self.wavelength).period


class Body(Section):
    """A wall that moves under the force of the fluid, along a line."""

    wall: Text = Field(description="the wall that moves: right or left (mirrors), or the name of a polygon wall")
    direction: Point = Field([1.0, 0.0], description="of its way, x and up; of any length")
    mass: Positive = Field(description="per metre of width [kg/m]")
    stiffness: NotNegative = Field(0.0, description="of the spring that pulls it back, per metre of width [N/m^2]")
    damping: NotNegative = Field(0.0, description="of a damper, per metre of width [N s/m^2]")
    threshold: Annotated[float, Field(ge=1, le=LARGEST)] = Field(
        1.0, description="it rests until the force is so many times that of still water [-]; and sticks again below it"
    )
    friction: NotNegative = Field(0.0, description="force against the motion while it moves, per metre of width [N/m]")
    preload: Number | None = Field(
        None, description="force of the fluid along the way that a support carries [N/m]; default: that of still water"
    )
    stops: Point = Field(description="least and largest way [m]; it ends there, without bouncing")
    start: NotNegative = Field(0.0, description="it is held until then [s]")
