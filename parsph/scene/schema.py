"""The schema of a scene: every key, its unit, its limits and its default.

Units are SI. The last axis points up. An unknown key is an error.
"""

import math
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator

from ..damping import KILLINGS, PROFILES, SWITCHES
from ..flows import FLOWS
from ..kernels import KERNELS
from ..states import STATES
from ..stepping import INTEGRATORS
from ..terms import CORRECTIONS, DENSITIES, DIFFUSIONS, FILTERS, SHIFTINGS, SPRAYS, TENSILE_CONTROLS, VISCOSITIES
from ..walls import INTERPOLATORS, REPULSIONS, TREATMENTS, WEIGHTS
from ..walls.mirror import SLIPS
from ..waves import dispersion
from .fields import LARGEST, Count, Duration, NotNegative, Number, Point, Positive, Section, Text, Vector
from .makers_schema import Body, Relaxation, Wavemaker
from .presets import GOVERNED, PRESETS

ELLIPSE_POINTS = 180
MOST_POINTS, MOST_POLYGONS, MOST_BLOCKS = 2000, 100, 200  # of one polygon, of a scene: each is checked against all others
MOST_GAUGES = 500  # each keeps a file open
# Sides of the domain: the axis across them, and the way into the domain along it. Side walls come first, so that the bed
# mirrors their images too: corners come of themselves.
SILL = "left-sill"  # the wall below a flap that is hinged above the bed
SIDES = {"left": (0, 1), "right": (0, -1), "front": (1, 1), "back": (1, -1), "bottom": (-1, 1), "top": (-1, -1)}
ENDS = {"x": ("left", "right"), "y": ("front", "back"), "up": ("bottom", "top")}  # of each axis, the sides


class DomainSection(Section):
    """The box that holds everything: from the origin to `size`."""

    size: Vector = Field(description="extent [m] in x and up (2D), x alone (1D), x, y and up (3D); no particle may leave it")
    gravity: NotNegative = Field(9.81, description="gravity [m/s^2], downwards along the last axis; without effect in 1D")
    periodic: list[Literal[*ENDS]] = Field(
        [],
        description="axes along which everything repeats, from end to end of the domain: x; y (3D); up, the vertical (2D, 3D)",
    )


class Ellipse(Section):
    """An ellipse, in place of a polygon's points."""

    center: Point = Field(description="[m]")
    axes: Annotated[list[Positive], Field(min_length=2, max_length=2)] = Field(description="half axes along x and up [m]")


def _with_ellipse(keys):
    """Return the keys of a wall or block whose `ellipse` has become `points`, a polygon of the same area."""
    if not isinstance(keys, dict) or keys.get("ellipse") is None or keys.get("points") is not None:
        return keys
    try:
        ellipse = Ellipse.model_validate(keys["ellipse"])
    except ValidationError:
        return keys  # said of the key itself
    angle = 2 * math.pi * np.arange(ELLIPSE_POINTS) / ELLIPSE_POINTS
    swell = math.sqrt(angle[1] / math.sin(angle[1]))
    points = np.array(ellipse.center) + swell * np.array(ellipse.axes) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return {**keys, "ellipse": None, "points": points.tolist()}


class Block(Section):
    """A block of fluid, filled with a square lattice: a rectangle, or a polygon (2D). Obstacles in it stay dry."""

    low: Vector = Field(description="lower corner [m]")
    high: Vector = Field(description="upper corner [m]")
    points: Annotated[list[Point], Field(min_length=3, max_length=MOST_POINTS)] | None = Field(
        None, description="vertices [m] of a polygon, in place of low and high (2D)"
    )
    ellipse: Ellipse | None = Field(None, description="an ellipse, in place of points (2D)")
    initial: Literal["still", "seiche", "pulse", *FLOWS] = Field(
        "still",
        description="still: at rest; seiche: velocities of the first standing wave of the block (2D); "
        "pulse: a hump that travels to the right (shallow water); without gravity (2D): rotation of a rectangle, stretching of "
        "an ellipse, vortices (Taylor-Green) in a square that fills a periodic domain, each with its pressure",
    )
    velocity: Vector | None = Field(None, description="of the whole block, beside that of its initial flow [m/s]")
    amplitude: NotNegative = Field(0.0, description="amplitude of the seiche, height of the pulse [m]")
    rate: Number | None = Field(
        None, description="angular velocity of the rotation, counter-clockwise; A of the stretching u = -A x, v = A y [1/s]"
    )
    speed: Positive | None = Field(None, description="largest velocity of the vortices [m/s]")
    pressure: Number | None = Field(
        None,
        description="the same pressure everywhere in the block at the beginning, beside that of its initial flow [Pa]; "
        "default: that of water at rest",
    )
    depth: Positive | None = Field(None, description="still-water depth [m]; for state shallow, and needed there")
    center: Number | None = Field(None, description="where the pulse begins [m]")
    width: Positive | None = Field(None, description="A [m] of the pulse exp(-(x - center)^2/A^2)")

    @model_validator(mode="before")
    @classmethod
    def _corners(cls, keys):
        """A polygon's low and high are those of its vertices."""
        keys = _with_ellipse(keys)
        if not isinstance(keys, dict) or keys.get("points") is None:
            return keys
        try:
            axes = list(zip(*keys["points"], strict=True))
            corners = {"low": [min(axis) for axis in axes], "high": [max(axis) for axis in axes]}
        except (TypeError, ValueError):  # what is wrong with the points is said of them, not of the corners
            corners = {"low": [0.0], "high": [0.0]}
        return {**corners, **keys}


class FluidSection(Section):
    """The fluid at the beginning; it is compressed by its own weight, pressure follows from the state equation."""

    rho0: Positive = Field(
        1000.0, description="density [kg/m^3], on average over the depth of still water; shallow water needs none"
    )
    level: Number | None = Field(
        None, description="still-water level [m]; default: top of the highest block, in shallow water the largest depth"
    )
    blocks: list[Block] = Field(min_length=1, max_length=MOST_BLOCKS, description="blocks of fluid")


class Wall(Section):
    """A wall along a side of the domain."""

    slip: Literal[*SLIPS] = Field("free", description="free slip or no slip")
    velocity: Vector | None = Field(
        None, description="with what the wall slides in its plane [m/s]; needs no slip; default: it stands still"
    )


class Swing(Section):
    """A rigid motion to and fro, ramp(t) sin(2 pi t / period) times its amplitudes."""

    way: Point = Field([0.0, 0.0], description="amplitude of the way [m]")
    angle: Annotated[float, Field(ge=-45, le=45)] = Field(
        0.0, description="amplitude of the angle, counter-clockwise [degrees]"
    )
    center: Point | None = Field(None, description="what it turns about, at rest [m]; default: its first point")
    period: Positive = Field(description="period [s]")
    ramp: NotNegative = Field(0.0, description="duration of the smooth start [s]; 0: sudden")


class Bulge(Section):
    """A deformation: an edge moves along its normal by ramp(t) sin(2 pi t / period) amplitude sin^2(pi s / length)."""

    edge: Annotated[int, Field(ge=0, le=MOST_POINTS)] = Field(
        description="which edge bulges: that from this point to the next, from 0"
    )
    amplitude: Number = Field(description="of its middle [m]; positive: first into the fluid")
    period: Positive = Field(description="period [s]")
    ramp: NotNegative = Field(0.0, description="duration of the smooth start [s]; 0: sudden")


class PolygonWall(Section):
    """A wall along a line of any shape (2D)."""

    name: Text | None = Field(None, description="what gauges and messages call it; default: wall and number")
    ellipse: Ellipse | None = Field(None, description="an ellipse, in place of points")
    points: Annotated[list[Point], Field(min_length=2, max_length=MOST_POINTS)] = Field(description="vertices [m]")
    fluid: Literal["left", "right", "inside", "outside"] = Field(
        "left",
        description="where the fluid is: left or right of an open line, walking from point to point, inside a closed polygon "
        "(a basin) or outside it (an obstacle)",
    )
    slip: Literal[*SLIPS] = Field("free", description="free slip or no slip")
    motion: Swing | None = Field(None, description="how it moves; default: it stands still")
    bulge: Bulge | None = Field(None, description="how it deforms; default: it keeps its shape")

    @model_validator(mode="before")
    @classmethod
    def _points(cls, keys):
        return _with_ellipse(keys)


class WallsSection(Section):
    """Walls: at the sides of the domain, and lines of any shape; a side without one is open (the fluid must not leave the
    domain there).
    """

    treatment: Literal[*TREATMENTS] | None = Field(
        None,
        description="what all walls are made of: mirror, mirror-plain (sides alone), ghosts, strip (2D), deficiency, repulsion "
        "(1D, 2D); default: sides mirror, polygons are of ghosts",
    )

    left: Wall | None = Field(None, description="wall at x = 0, or the wavemaker's plate")
    right: Wall | None = Field(None, description="wall at the largest x")
    front: Wall | None = Field(None, description="wall at y = 0 (3D)")
    back: Wall | None = Field(None, description="wall at the largest y (3D)")
    bottom: Wall | None = Field(None, description="bed")
    top: Wall | None = Field(None, description="lid")
    exchange: bool = Field(
        False, description="fluid that gets behind a mirror wall changes places with its image, where it would end the run else"
    )
    polygons: list[PolygonWall] = Field([], max_length=MOST_POLYGONS, description="walls of any shape (2D)")
    interpolation: Literal[*INTERPOLATORS] = Field(
        "hydrostatic", description="how fixed ghosts get pressure and velocity of the fluid at their mirror points"
    )
    markers_per_dx: Annotated[int, Field(ge=1, le=10)] = Field(
        3, description="markers per particle spacing, for deficiency and repulsion [-]"
    )
    weights: Literal[*WEIGHTS] = Field("moments", description="how a correction of the deficiency is shared among markers")
    repulsion: Literal[*REPULSIONS] = Field("monaghan-kajtar", description="law of the repulsion by markers")
    push: Positive | None = Field(None, description="strength K of the repulsion [m^2/s^2]; default: g depth, or c0^2/400")
    push_reach: Positive | None = Field(
        None, description="how far the repulsion reaches [m]; default: dx, with deficiency 0.5 dx"
    )


class Damping(Section):
    """An absorbing layer along the left or right end of the domain."""

    side: Literal["left", "right"] = Field("right", description="end of the domain")
    length: Positive = Field(description="length L of the layer [m]")
    profile: Literal[*PROFILES] = Field(
        "hyperbolic", description="sigma = sigma0 times depth / (L - depth + softening), or power: (depth / L)^exponent"
    )
    softening: Positive | None = Field(None, description="of the hyperbolic profile's outer end [m]; default: 0.5 h")
    exponent: Annotated[int, Field(ge=1, le=20)] = Field(1, description="m of the power profile [-]")
    v_ref: Positive | None = Field(None, description="sigma0 = v_ref / L [m/s]; default: c0")
    sigma0: Positive | None = Field(None, description="strength [1/s], instead of v_ref")
    density: Literal["none", "plain", "matched"] = Field(
        "none",
        description="damp the density towards that of still water too: plain, as hard as the velocity; matched, so hard that "
        "the waves of the wavemaker (without one: long waves) meet no change of impedance",
    )
    switch: Literal[*SWITCHES] = Field(
        "none", description="damp those only that move against the wave (vx), and down (vx-vy), or are driven so (fx-vx)"
    )
    killing: Literal[*KILLINGS] = Field(
        "none", description="horizontal force in the layer falls as f1 = 1 - depth/L or f2 = 1 - (depth/L)^2"
    )


class LevelGauge(Section):
    """Water level at a place; in shallow water the depth there."""

    kind: Literal["level"]
    name: Text | None = Field(None, description="name of the table; default: kind and number")
    x: Number = Field(description="position [m]")
    y: Number | None = Field(None, description="position across [m] (3D)")
    every: Positive = Field(0.02, description="sampling interval [s]")


class PressureGauge(Section):
    """Pressure at a point of the fluid or of a wall, or averaged over the extent of a transducer."""

    kind: Literal["pressure"]
    name: Text | None = Field(None, description="name of the table; default: kind and number")
    point: Vector = Field(description="position [m]; the middle, where there is an extent")
    extent: Vector | None = Field(None, description="from end to end of the line that is averaged over [m]; default: a point")
    wall: Text | None = Field(
        None, description="what it is fixed to and moves with: a polygon wall, or a side with a wall (2D); default: nothing"
    )
    every: Positive = Field(0.01, description="sampling interval [s]")


class EnergyGauge(Section):
    """Mass, energies and momentum of a region."""

    kind: Literal["energy"]
    name: Text | None = Field(None, description="name of the table; default: kind and number")
    low: Vector | None = Field(None, description="lower corner of the region [m]; default: everything")
    high: Vector | None = Field(None, description="upper corner of the region [m]; default: everything")
    every: Positive = Field(0.05, description="sampling interval [s]")


class PowerGauge(Section):
    """Power that viscosity, diffusion and all else give the fluid: with an energy gauge, its energy books."""

    kind: Literal["power"]
    name: Text | None = Field(None, description="name of the table; default: kind and number")
    every: Positive = Field(0.05, description="sampling interval [s]; a sample costs two evaluations")


class ForceGauge(Section):
    """Force and moment of the fluid's pressure on a wall (2D, per metre of width)."""

    kind: Literal["force"]
    name: Text | None = Field(None, description="name of the table; default: kind and number")
    wall: Text = Field(description="name of a polygon wall, or a side of the domain: left, right, bottom, top")
    about: Point = Field([0.0, 0.0], description="what the moment is taken about [m]")
    every: Positive = Field(0.01, description="sampling interval [s]")


class RunupGauge(Section):
    """Run-up and shoreline: how far up a wall the water reaches (2D)."""

    kind: Literal["runup"]
    name: Text | None = Field(None, description="name of the table; default: kind and number")
    wall: Text = Field(description="name of a polygon wall, or a side of the domain: left, right")
    x: Number | None = Field(
        None, description="near which place still water meets the wall that is meant [m]; needed where there are several"
    )
    every: Positive = Field(0.02, description="sampling interval [s]")


class BodyGauge(Section):
    """Force on a body, its way, velocity and acceleration, and the work of the force."""

    kind: Literal["body"]
    name: Text | None = Field(None, description="name of the table; default: kind and number")
    wall: Text = Field(description="wall of the body")
    every: Positive = Field(0.01, description="sampling interval [s]")


GAUGE_KINDS = ("level", "pressure", "energy", "power", "force", "runup", "body")
GaugeSection = Annotated[
    LevelGauge | PressureGauge | EnergyGauge | PowerGauge | ForceGauge | RunupGauge | BodyGauge, Field(discriminator="kind")
]


class Numerics(Section):
    """How it is computed."""

    dx: Positive = Field(description="particle spacing [m]")
    preset: Literal[*PRESETS] | None = Field(
        None,
        description=f"what the keys {', '.join(GOVERNED)} are where the scene does not say so: draft, standard or accurate; a "
        "preset that is named on top of a scene replaces that scene's own of these keys",
    )
    kernel: Literal[*KERNELS] = Field("wendland-c2", description="smoothing kernel")
    h_over_dx: Positive = Field(2.0, description="smoothing length over spacing [-]")
    h_growth: Annotated[float, Field(ge=1, le=100)] = Field(
        1.0, description="shallow water: h grows with the spacing of thinning water, up to so many times its length [-]"
    )
    kernel_correction: Literal[*CORRECTIONS] = Field(
        "none", description="linear: forces and density rates reproduce linear fields (Szmidt eqs. (25) to (31))"
    )
    c0: Positive | None = Field(None, description="sound speed [m/s]; default: c0_factor sqrt(g depth)")
    c0_factor: Annotated[float, Field(ge=5, le=LARGEST)] = Field(
        20.0, description="sound speed over sqrt(g depth) [-], at least 5"
    )
    state: Literal[*STATES] = Field("tait", description="equation of state")
    gamma: Annotated[float, Field(ge=1, le=15)] = Field(7.0, description="exponent of the Tait equation [-], 1 to 15")
    viscosity: Literal[*VISCOSITIES] = Field("none", description="viscosity of the momentum equation")
    alpha: NotNegative = Field(0.02, description="strength of monaghan viscosity [-]")
    nu: Positive | None = Field(None, description="kinematic viscosity of newtonian viscosity [m^2/s], and needed there")
    diffusion: Literal[*DIFFUSIONS] = Field("none", description="density diffusion")
    delta: Annotated[float, Field(ge=0, le=0.5)] = Field(0.1, description="strength of the diffusion [-], up to 0.5")
    density: Literal[*DENSITIES] = Field(
        "continuity",
        description="integrated by the continuity equation, or by one whose divergence is exact beside a free surface too, "
        "where waves keep their height; or summed over neighbours, which outside shallow water needs density_range, since sums "
        "fall off at a free surface",
    )
    reinitialise: Literal[*FILTERS] = Field("none", description="densities are summed over neighbours anew from time to time")
    reinitialise_every: Count = Field(20, description="steps between two re-initialisations")
    tensile_control: Literal[*TENSILE_CONTROLS] = Field("none", description="particles under suction repel instead of clumping")
    shifting: Literal[*SHIFTINGS] = Field(
        "none", description="particles shift towards where there are fewer: lind, as fast as they move; sun, as fast as c0/10"
    )
    shift: Annotated[float, Field(gt=0, le=10)] = Field(2.0, description="strength of the shifting [-]")
    spray: Literal[*SPRAYS] = Field(
        "none", description="pressureless: particles with hardly any neighbours lose their pressure"
    )
    xsph: Annotated[float, Field(ge=0, le=1)] = Field(0.0, description="velocity smoothing epsilon [-]; 0: none")
    xsph_continuity: bool = Field(False, description="the smoothed velocity is used in the continuity equation too; needs xsph")
    integrator: Literal[*INTEGRATORS] = Field("verlet", description="time integration")
    precision: Literal["float64", "float32"] = Field(
        "float64", description="of the arithmetic of pairs; the state is always float64"
    )
    density_range: Point | None = Field(
        None,
        description="the run stops when a density over rho0 leaves this range [-]; default: 0.7 to 1.3, "
        "in shallow water, where rho0 is the largest depth, 0 to 2",
    )

    @model_validator(mode="before")
    @classmethod
    def _with_preset(cls, keys):
        """Fill in what a preset says, before defaults."""
        preset = PRESETS.get(keys["preset"]) if isinstance(keys, dict) and isinstance(keys.get("preset"), str) else None
        return preset | keys if preset else keys


class TimeSection(Section):
    """When it ends, and how long a step is."""

    end: NotNegative = Field(description="end of the run [s]")
    settle: NotNegative = Field(
        0.0,
        description="so long before t = 0 the fluid comes to rest, its velocities decaying [s]; for blocks that fit no lattice",
    )
    walltime: Duration | None = Field(
        None,
        description="how long the run may take by the clock, seconds or hours:minutes:seconds; before that it writes a "
        "checkpoint and ends with exit code 85; default: as long as it takes",
    )
    dt: Positive | None = Field(None, description="constant time step [s]; default: from cfl")
    cfl: Positive | None = Field(None, description="dt = cfl min(h/(c0 + |v|), sqrt(h/|a|)); default: the integrator's")


class Snapshots(Section):
    """Files of all particles."""

    every: Positive | None = Field(None, description="interval [s]; default: a hundredth of the run")
    precision: Literal["float64", "float32"] = Field("float64", description="of the numbers in the files")
    moments: bool = Field(
        False,
        description="zeroth and first moments of kernel and kernel gradient too (Szmidt eqs. (23), (24)): where sums over "
        "neighbours reproduce linear fields, and where not",
    )


class Log(Section):
    """What is printed while it runs."""

    every: Positive | None = Field(None, description="interval of log lines [s of the flow]; default: a 25th of the run")


class CheckpointSection(Section):
    """Files that a run goes on from, see `parsph resume`; the last two are kept."""

    every: Duration = Field(
        900.0,
        description="interval by the clock, seconds or hours:minutes:seconds, longer where they take more than a fiftieth "
        "of the time; there is one at the end of the run too; 0: only when the run is asked to end",
    )


class Output(Section):
    """What is written."""

    snapshots: Snapshots = Snapshots()
    log: Log = Log()
    checkpoints: CheckpointSection = CheckpointSection()


class Scene(Section):
    """A scene: what is modelled and how.

    Units are SI; the last axis points up. What a scene does not name is not modelled.
    """

    title: Text = Field("", description="one line for lists and plots")
    domain: DomainSection
    fluid: FluidSection
    walls: WallsSection = WallsSection()
    wavemaker: Wavemaker | None = None
    relaxation: Annotated[list[Relaxation], Field(max_length=2)] = []
    bodies: Annotated[list[Body], Field(max_length=MOST_POLYGONS)] = []
    damping: Annotated[list[Damping], Field(max_length=2)] = []
    gauges: Annotated[list[GaugeSection], Field(max_length=MOST_GAUGES)] = []
    numerics: Numerics
    time: TimeSection
    output: Output = Output()

    # --- what follows from the keys ---------------------------------------------------------------------------------

    @property
    def dim(self):
        """Number of space dimensions."""
        return len(self.domain.size)

    @property
    def features(self):
        """What needs fields of its own (`parsph.particles.FIELDS`)."""
        n = self.numerics
        drifts = n.xsph > 0 or n.shifting != "none"
        return (n.integrator, n.viscosity, n.diffusion, *["xsph_continuity"] * n.xsph_continuity, *["drift"] * drifts)

    @property
    def gravity(self):
        """Gravity as a vector [m/s^2]."""
        down = 0.0 if self.dim == 1 else -self.domain.gravity
        return (0.0,) * (self.dim - 1) + (down,)

    @property
    def periodic(self):
        """{name: axis} of the axes along which everything repeats, in the order of the axes."""
        axes = {"x": 0, "y": 1, "up": self.dim - 1}
        return {name: axis for name, axis in axes.items() if name in self.domain.periodic}

    @property
    def endless_vertical(self):
        """Whether the vertical is periodic: there is then no surface, and no column of water."""
        return "up" in self.domain.periodic

    @property
    def mirrors(self):
        """Whether the sides of the domain mirror the fluid."""
        return self.walls.treatment is None or TREATMENTS[self.walls.treatment].family == "mirror"

    @property
    def sill(self):
        """Height [m] up to which the left wall stands still below the hinge of a flap, None where there is no such sill."""
        maker = self.wavemaker
        at_side = maker is not None and maker.wall == "left" and maker.kind == "flap" and maker.hinge is not None
        return maker.hinge if at_side and maker.hinge > self.level - self.depth else None

    @property
    def wave_period(self):
        """Period [s] of what the wavemaker makes, the peak period of irregular waves; without one that of the relaxation zones'
        waves; None where there are none.
        """
        wave = self.wavemaker.wave if self.wavemaker else None
        if wave is None:
            periods = (zone.own_period(self.depth, self.domain.gravity) for zone in self.relaxation)
            return next((period for period in periods if period is not None), None)
        if wave.kind == "regular":
            return dispersion(self.depth, self.domain.gravity, wave.period, wave.frequency, wave.wavelength).period
        if getattr(wave, "spectrum", "") == "table":
            return 1.0 / wave.frequencies[int(np.argmax(wave.densities))]
        return getattr(wave, "period", None)

    @property
    def endless_waves(self):
        """Whether a wavemaker or a relaxation zone makes waves of a period without end."""
        wave = self.wavemaker.wave if self.wavemaker else None
        if wave is None:
            return any(zone.height > 0 for zone in self.relaxation)
        return wave.kind in ("regular", "irregular") or getattr(wave, "cycles", 0) is None

    @property
    def moved_sides(self):
        """Names of the sides of the domain whose walls move, but within their planes."""
        walls = [maker.wall for maker in (self.wavemaker, *self.bodies) if maker]
        return [wall for wall in walls if wall in SIDES]

    @property
    def treatment(self):
        """The `Treatment` of the walls that are lines."""
        return TREATMENTS["ghosts" if self.mirrors else self.walls.treatment]

    @property
    def sides(self):
        """Names of the sides of the domain that have walls."""
        return [side for side in SIDES if getattr(self.walls, side) is not None]

    @cached_property
    def lines(self):
        """The walls that are lines: polygon walls, and in 2D sides that do not mirror."""
        lines = list(self.walls.polygons)
        if self.mirrors or self.dim != 2:
            return lines
        right, top = self.domain.size
        corners = {"left": [(0, top), (0, 0)], "bottom": [(0, 0), (right, 0)], "right": [(right, 0), (right, top)]}
        corners["top"] = [(right, top), (0, top)]
        for side in self.sides:
            slip = getattr(self.walls, side).slip
            points, sill = corners[side], self.sill if side == "left" else None
            parts = {side: points} if sill is None else {side: [points[0], (0, sill)], SILL: [(0, sill), points[1]]}
            for name, ends in parts.items():
                lines.append(PolygonWall(name=name, points=[list(map(float, point)) for point in ends], slip=slip))
        return lines

    def line_key(self, number):
        """Return the key of one of the `lines`."""
        polygons = len(self.walls.polygons)
        return f"walls.polygons.{number}" if number < polygons else f"walls.{self.lines[number].name}"

    @property
    def wall_names(self):
        """Names of the `lines`."""
        return [wall.name or f"wall-{number:02d}" for number, wall in enumerate(self.lines)]

    @property
    def shallow(self):
        """Whether this is shallow water: one dimension, the depth plays the density."""
        return self.numerics.state == "shallow"

    @property
    def rho0(self):
        """Density without pressure [kg/m^3]; in shallow water the largest depth [m] at the beginning.

        So much below `fluid.rho0` that a column of still water, compressed by its own weight, has that density on average:
        the bed carries rho0 g depth.
        """
        if self.shallow:
            return max(block.depth for block in self.fluid.blocks)
        if self.endless_vertical:  # no column, and no weight that compresses it
            return self.fluid.rho0
        return self.fluid.rho0 / (1.0 + 0.5 * abs(self.gravity[-1]) * max(self.depth, 0.0) / self.c0**2)

    @property
    def level(self):
        """Still-water level [m]."""
        if self.fluid.level is not None:
            return self.fluid.level
        return self.rho0 if self.shallow else max(block.high[-1] for block in self.fluid.blocks)

    @property
    def depth(self):
        """Still-water depth [m], over the lowest point of the fluid."""
        return self.level - (0.0 if self.shallow else min(block.low[-1] for block in self.fluid.blocks))

    @property
    def h(self):
        """Smoothing length [m]."""
        return self.numerics.h_over_dx * self.numerics.dx

    @property
    def kernel(self):
        """The smoothing kernel."""
        return KERNELS[self.numerics.kernel]

    @property
    def density_range(self):
        """What the density may become, over rho0 [-]."""
        return tuple(self.numerics.density_range or ((0.0, 2.0) if self.shallow else (0.7, 1.3)))

    @property
    def reach(self):
        """Largest distance [m] at which particles feel each other."""
        return self.kernel.support * self.h * self.numerics.h_growth

    @property
    def c0(self):
        """Sound speed [m/s]; in shallow water that of long waves on the largest depth."""
        if self.shallow:
            return (self.domain.gravity * self.rho0) ** 0.5
        return self.numerics.c0 or self.numerics.c0_factor * (self.domain.gravity * self.depth) ** 0.5

    @property
    def cfl(self):
        """Factor of the time-step limit [-]."""
        return self.time.cfl or INTEGRATORS[self.numerics.integrator].cfl

    @property
    def snapshot_interval(self):
        """[s]"""
        return self.output.snapshots.every or self.time.end / 100 or None

    @property
    def log_interval(self):
        """[s]"""
        return self.output.log.every or self.time.end / 25 or None
