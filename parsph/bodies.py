"""Walls that the flow moves: bodies under its force, and wavemakers that take up what comes back to them.

Their way is a `Yielding` signal: the acceleration of a step is decided at its beginning, by what the fluid does then, and
holds through it. So way and speed have no jumps, every evaluation of the step knows where the wall is, and since rank 0
decides and tells all, the result has the same bits on any number of ranks.
"""

import math

import numpy as np

from .io.gauges import LevelGauge, force_on


class MovableWall:
    """A wall that moves along a line under the force of the fluid.

    ``m X'' = F - F_0 - k X - c X' - f sign(X')``: F the force of the fluid's pressure along the way, F_0 the part of it that a
    support carries, in the end that of still water (Huang et al. 2019, section 4.4, with a damper and friction added). It rests
    until ``|F - F_0 - k X|`` exceeds the resistance, (threshold - 1) |F_0| with the threshold of that section, and sticks again
    where it comes to a halt with less than that. At a stop it loses its speed.

    Parameters
    ----------
    name : str
        Of the wall.
    signal : Yielding
        Its way.
    motion : Slide
        What moves the wall, by that signal.
    surface : tuple of ndarray
        Pieces of the wall at rest: midpoints [m], normals into the fluid, lengths [m].
    mass, stiffness, damping, friction, resistance, preload : float
        Per metre of width: m [kg/m], k [N/m^2], c [N s/m^2], f [N/m], [N/m], F_0 [N/m].
    start : float
        It is held until then [s].
    """

    def __init__(self, name, signal, motion, surface, mass, stiffness, damping, friction, resistance, preload, start):
        self.name, self.signal, self.motion, self.surface = name, signal, motion, surface
        self.mass, self.stiffness, self.damping, self.friction = mass, stiffness, damping, friction
        self.resistance, self.preload, self.start = resistance, preload, start
        self.force, self.work = None, 0.0

    def advance(self, simulation, time):
        """Go on to `time` [s], the end of a step, and decide on the acceleration of the next one; collective."""
        before = self.signal.way
        way, speed, _ = self.signal.at(time)
        push = force_on(simulation, *self.surface, self.motion, time)
        force = simulation.communicator.broadcast(float(push[:2] @ np.array(self.motion.direction)) if len(push) else 0.0)
        if self.force is not None:
            self.work += 0.5 * (force + self.force) * (way - before)
        self.force = force
        self.signal.go_on(time, *self._next(time, way, speed))

    def _next(self, time, way, speed):
        """Return way [m], speed [m/s] and acceleration [m/s^2] that the next step begins with."""
        least, largest = self.signal.extent
        pull = self.force - self.preload - self.stiffness * way
        turned = speed == 0.0 or speed * self.signal.speed < 0.0  # at rest, or come to a halt in this step
        if time < self.start or (turned and abs(pull) <= max(self.resistance, self.friction)):
            return way, 0.0, 0.0
        if (way >= largest and pull >= 0.0) or (way <= least and pull <= 0.0):
            return min(max(way, least), largest), 0.0, 0.0
        if not least < way < largest:  # it has hit a stop, and is pulled back
            way, speed = min(max(way, least), largest), 0.0
        heading = speed if speed != 0.0 else pull
        pull -= self.damping * speed + math.copysign(self.friction, heading)
        return way, speed, pull / self.mass

    @property
    def memory(self):
        """What it must know to go on: its way, force [N/m] and work [J/m]."""
        return [self.signal.memory, self.force, self.work]

    @memory.setter
    def memory(self, known):
        way, self.force, self.work = known
        self.signal.go_on(*way)

    @property
    def resting(self):
        """Whether it stands still, and will in the next step."""
        return self.signal.speed == 0.0 and self.signal.acceleration == 0.0

    @property
    def state(self):
        """Force of the fluid along the way [N/m], way [m], speed [m/s], acceleration [m/s^2], work of that force [J/m]."""
        signal = self.signal
        return (self.force or 0.0), signal.way, signal.speed, signal.acceleration, self.work


class Absorber:
    """What a wavemaker adds to its motion to take up the waves that come back to it.

    Long waves of the level eta' that run to the plate are not reflected by a piston that goes along with their water,
    ``X' = -eta' sqrt(g/d)``; eta' is the level in front of the plate less the one that the plate's own waves should have
    there (Schaeffer & Klopman 2000; Altomare et al. 2017). `parsph.waves.absorption` says with what gain and lag that holds
    for waves of a period, and for flaps. The plate follows within the lag tau, ``X'' = (X'_wanted - X')/tau``, with a limit.
    What waves leave of the mean level (they carry water along) would let it drift: eta' is taken less its mean over a longer
    time, in which the plate comes back to its course, too.

    Parameters
    ----------
    signal : Yielding
        What it adds to the plate's way at the still-water level.
    motion : Slide or Flap
        Of the plate, that signal included.
    expected : object
        ``expected.at(time, x)`` is the level [m] of the plate's own waves at `x` [m] from its place at rest.
    place : float
        x of the plate at rest [m].
    distance : float
        Of the gauge in front of the plate [m].
    level : float
        Of still water [m].
    gain, lag : float
        X' over -eta' [1/s], tau [s].
    centering : float
        Time over which the mean is taken, and within which the plate drifts back [s].
    largest : float
        Acceleration [m/s^2].
    """

    def __init__(self, signal, motion, expected, place, distance, level, gain, lag, centering, largest):
        self.signal, self.motion, self.expected = signal, motion, expected
        self.place, self.distance, self.level = place, distance, level
        self.gain, self.lag, self.centering, self.largest = gain, lag, centering, largest
        self.mean = 0.0

    def advance(self, simulation, time):
        """Go on to `time` [s], the end of a step, and decide on the acceleration of the next one; collective."""
        plate = self.motion.at(time).place(np.array([[self.place, self.level]]))[0, 0]
        x = float(plate) + self.distance
        gauge = LevelGauge("", None, (x,), ((-np.inf, 0.0), (np.inf, np.inf)))
        measured = simulation.communicator.broadcast(gauge.measure(simulation))[0]
        way, speed, _ = self.signal.at(time)
        unexplained = measured - self.level - self.expected.at(time, x - self.place)
        self.mean += (time - self.signal.time) / self.centering * (unexplained - self.mean)
        wanted = -self.gain * (unexplained - self.mean) - way / self.centering
        least, largest = self.signal.extent
        wanted = max(min(wanted, self._fastest(largest - way)), -self._fastest(way - least))
        pull = min(max((wanted - speed) / self.lag, -self.largest), self.largest)
        self.signal.go_on(time, way, speed, pull)

    @property
    def memory(self):
        """What it must know to go on: its way, and the mean level [m] so far."""
        return [self.signal.memory, self.mean]

    @memory.setter
    def memory(self, known):
        way, self.mean = known
        self.signal.go_on(*way)

    def _fastest(self, room):
        """Return how fast the plate may go when there is so much `room` [m] left, so that it comes to a halt in it [m/s]."""
        room = max(room, 0.0)  # the first is critically damped, the second leaves half of the acceleration for the delay
        return min(room / (4.0 * self.lag), math.sqrt(self.largest * room))
