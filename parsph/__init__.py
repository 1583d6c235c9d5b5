"""parsph: distributed smoothed-particle hydrodynamics for numerical wave tanks.

>>> import parsph
>>> scene = parsph.load_scene("seiche", {"time.end": 0.1})
>>> simulation = parsph.build(scene)
>>> simulation.run()
>>> simulation.field("position")  # doctest: +SKIP
"""

__version__ = "0.1.0"

__all__ = ["ParsphError", "RunError", "SceneError", "build", "load_scene"]

from .errors import ParsphError, RunError, SceneError


def __getattr__(name):
    """Load what needs numba or pydantic on first use, so that ``--help`` and ``--version`` answer at once."""
    if name == "load_scene":
        from .scene.load import load_scene

        return load_scene
    if name == "build":
        from .scene.build import build

        return build
    raise AttributeError(f"module 'parsph' has no attribute {name!r}")
