"""A seiche from Python, without files: its frequency against linear theory.

    python examples/seiche.py

The velocities are projected on the shape of the first standing wave: the coefficient is cos(omega t) in theory, so its
zeros lie half a period apart.
"""

import math

import numpy as np

import parsph
from parsph.waves import Seiche

scene = parsph.load_scene("seiche", {"time.end": 0.56})  # five periods by default; a little more than one here
simulation = parsph.build(scene)

block = scene.fluid.blocks[0]
theory = Seiche(block.high[0], block.high[1], block.amplitude, scene.domain.gravity)


def mode_coefficient():
    """Return the share of the mode in the flow, 1 at the start; summed over all ranks, should there be several."""
    mass, velocity = simulation.field("mass")[:, None], simulation.field("velocity")
    shape = theory.velocity(simulation.field("position"))
    parts = simulation.communicator.allgather([(mass * velocity * shape).sum(), (mass * shape**2).sum()])
    flow, norm = np.sum(parts, axis=0)
    return flow / norm


simulation.prepare()
times, coefficients = [simulation.time], [mode_coefficient()]
while simulation.time < scene.time.end:
    simulation.advance()
    times.append(simulation.time)
    coefficients.append(mode_coefficient())

t, c = np.array(times), np.array(coefficients)
last = np.flatnonzero(c[:-1] * c[1:] < 0)  # the samples before a change of sign
zeros = t[last] - c[last] * (t[last + 1] - t[last]) / (c[last + 1] - c[last])
frequency = math.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])
error = 100 * (frequency / theory.frequency - 1)

if simulation.communicator.rank == 0:
    print(f"{len(simulation.field('id'))} particles on rank 0, {simulation.steps} steps to t = {simulation.time:g} s")
    print(f"omega: {frequency:.3f} 1/s; theory {theory.frequency:.3f} 1/s; difference {error:+.2f} %")
