"""PySPH's own examples as flows to serve; runs in an environment that has PySPH and no parsph."""

import tempfile

import numpy as np
from pysph.examples import dam_break_2d, elliptical_drop
from serving import serve


class DamBreak(dam_break_2d.DamBreak2D):
    """PySPH's dam break, with the h and m that follow from `--dx`: the example's are always those of dx = 0.03 m."""

    def create_particles(self):
        particles = super().create_particles()
        for array in particles:
            array.h[:] = self.h
            array.m[:] = dam_break_2d.ro * self.dx**2
        return particles


class WideDrop(elliptical_drop.EllipticalDrop):
    """PySPH's drop with the h over dx of parsph's; the example's is always 1.3."""

    def initialize(self):
        super().initialize()
        self.hdx = 2.0


class PySPHFlow:
    """An example of PySPH on one core, without OpenMP and without output, of the settings that `serving.serve` tells."""

    def __init__(self, settings):
        dam = settings["case"] == "dam break"
        wide = settings.get("method") == "parsph"  # of which that code can take over the kernel and its width
        size = ["--dx", settings["dx"]] if dam else ["--nx", settings["per radius"]]
        size += ["--kernel", "WendlandQuintic"] if wide else []
        kind = DamBreak if dam else WideDrop if wide else elliptical_drop.EllipticalDrop
        app = kind(output_dir=tempfile.mkdtemp(prefix="pysph-"))
        app.setup([str(word) for word in (*size, "--disable-output", "--no-openmp")])
        self.solver, self.evaluations = app.solver, 0
        # its walls are a row of particles on the sides of the tank: what they hold begins half a spacing further in
        self.offset = settings["dx"] / 2 if dam else 0.0
        for evaluator in self.solver.acceleration_evals:
            evaluator.compute = self._counted(evaluator.compute)

    def _counted(self, compute):
        def counted(time, dt):
            self.evaluations += 1
            compute(time, dt)

        return counted

    def advance(self, time):
        self.solver.tf = time
        self.solver.solve(show_progress=False)

    @property
    def particles(self):
        return sum(array.get_number_of_particles() for array in self.solver.particles)

    @property
    def fluid(self):
        return self.solver.particles[0].get_number_of_particles()

    def positions(self):
        fluid = self.solver.particles[0]
        return np.stack([fluid.x, fluid.y], axis=1) - self.offset


if __name__ == "__main__":
    serve(PySPHFlow)
