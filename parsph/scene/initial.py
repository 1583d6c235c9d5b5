"""What the fluid is at the beginning: the particles of the blocks with their densities, masses and velocities."""

import math

import numpy as np

from ..flows import FLOWS, TaylorGreen
from ..waves import Seiche, pulse


def fill(particles, scene, state, grid, fillings, first_column, last_column):
    """Add the particles of the columns ``first_column:last_column`` of a grid; `fillings` are those of the blocks."""
    number = 0
    for block, filling in zip(scene.fluid.blocks, fillings, strict=True):
        ids, position = filling.between(grid, first_column, last_column)
        density, velocity = _initial(scene, state, block, position)
        particles.add(
            number + ids,
            position=position,
            velocity=velocity,
            density=density,
            mass=density * filling.volume / _lattice_sum(scene, filling),
        )
        number += filling.count


def flow_of(scene, block):
    """Return the exact flow without weight (`parsph.flows`) that a block begins with, None where it begins with none."""
    flow, low, high = FLOWS.get(block.initial), tuple(block.low), tuple(block.high)
    if flow is TaylorGreen:
        return flow(low, high[0] - low[0], block.speed, scene.numerics.nu or 0.0, scene.fluid.rho0)
    return flow and flow(low, high, block.rate, scene.fluid.rho0)


def _initial(scene, state, block, position):
    """Return density [kg/m^3] and velocity [m/s] of a block's particles at `position` [m] at the beginning."""
    velocity = np.zeros_like(position)
    if block.velocity is not None:
        velocity += block.velocity
    if block.initial == "pulse":
        place = block.depth, block.amplitude, block.center, block.width
        depth, speed = pulse(position[:, 0], *place, scene.domain.gravity)
        velocity[:, 0] += speed
        return depth, velocity
    if scene.shallow:
        return np.full(len(position), block.depth), velocity
    if block.initial == "seiche":
        length, depth = np.subtract(block.high, block.low)
        seiche = Seiche(length, depth, block.amplitude, scene.domain.gravity)
        velocity += seiche.velocity(position - np.array(block.low))
    flow = flow_of(scene, block)
    if flow is not None:
        velocity += flow.velocity(position)
        return state.density((block.pressure or 0.0) + flow.pressure(position)), velocity
    if block.pressure is not None:
        return np.full(len(position), state.density(block.pressure)), velocity
    return state.still_density(abs(scene.gravity[-1]) * (scene.level - position[:, -1])), velocity


def _lattice_sum(scene, filling):
    """Return the sum of W V over the lattice of a block, by which summed densities would be wrong; 1 where none are summed."""
    if scene.numerics.density != "summation":
        return 1.0
    lattice = getattr(filling, "lattice", filling)
    numbers = [math.ceil(scene.kernel.support * scene.h / step) for step in lattice.step]
    axes = [step * np.arange(-n, n + 1) for n, step in zip(numbers, lattice.step, strict=True)]
    distance = np.sqrt(sum(x**2 for x in np.meshgrid(*axes, indexing="ij")))
    return float(lattice.volume * scene.kernel.value(distance, scene.h, scene.dim).sum())
