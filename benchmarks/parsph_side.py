"""The flows of PySPH's examples as scenes of parsph to serve."""

import math

from serving import serve

from parsph.parallel import Communicator
from parsph.run import load_code
from parsph.scene.build import build
from parsph.scene.load import load_scene

FAR = 100.0  # s, beyond any end: flows go where they are told
PHYSICS = {  # of PySPH's scheme "wcsph" as both examples set it
    "numerics.density": "continuity",
    "numerics.diffusion": "none",
    "numerics.viscosity": "monaghan",
    "numerics.alpha": 0.1,
    "numerics.xsph": 0.5,
    "numerics.h_over_dx": 1.3,
    "time.cfl": 0.3,
}
RATE, C0 = 100.0, 1400.0  # of the drop [1/s], [m/s]


def dam_break(dx):
    """Return PySPH's dam break as a scene: the same places of particles, mirrors half a spacing outside of the first ones."""
    keys = {
        "domain": {"size": [4.0 - dx, 6.0]},
        "fluid": {"blocks": [{"low": [0.0, 0.0], "high": [1.0 + dx, 2.0 + dx]}]},
        "walls": {"left": {}, "right": {}, "bottom": {}, "exchange": True},  # what a splash pushes behind a mirror comes back
        "numerics": {"dx": dx, "c0": 10 * math.sqrt(2 * 9.81 * 2.0), "density_range": [0.2, 5.0]},
        "time": {"end": FAR},
    }
    return load_scene(keys, PHYSICS)


def drop(per_radius, method):
    """Return parsph's drop at the speeds of PySPH's, with the `method` of "parsph" or of "PySPH"."""
    keys = {"gauges": [], "numerics.dx": 1.0 / per_radius, "numerics.c0": C0, "fluid.blocks.0.rate": RATE, "time.end": FAR}
    if method == "PySPH":
        keys |= PHYSICS | {"numerics.kernel": "gaussian", "numerics.integrator": "midpoint"}
    return load_scene("elliptical-drop", keys)


class ParsphFlow:
    """A scene of parsph on one core, without output, of the settings that `serving.serve` tells."""

    def __init__(self, settings):
        dam = settings["case"] == "dam break"
        scene = dam_break(settings["dx"]) if dam else drop(settings["per radius"], settings["method"])
        load_code(scene, Communicator())
        self.simulation = build(scene, Communicator())
        self.simulation.prepare()
        self.particles = self.fluid = len(self.simulation.particles.fluid)

    @property
    def evaluations(self):
        return self.simulation.evaluations

    def advance(self, time):
        self.simulation.end = time
        while self.simulation.time < time:
            self.simulation.advance()

    def positions(self):
        return self.simulation.field("position")


if __name__ == "__main__":
    serve(ParsphFlow)
