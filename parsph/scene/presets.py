"""Presets: numbers and terms that go together, for how much accuracy to buy. What each is worth: the study work-precision.

A preset says what a scene's `numerics` leaves open; keys beside it win. It says nothing of what depends on the flow: viscosity,
tensile control, shifting, spray, the time step.
"""

PRESETS = {
    "draft": {
        "kernel": "wendland-c2",
        "h_over_dx": 1.5,
        "c0_factor": 8.0,
        "integrator": "verlet",
        "density": "continuity",
        "diffusion": "fourtakas",
        "delta": 0.1,
        "precision": "float32",
    },
    "standard": {
        "kernel": "wendland-c2",
        "h_over_dx": 2.0,
        "c0_factor": 12.0,
        "integrator": "adams-bashforth",
        "density": "renormalised",
        "diffusion": "fourtakas",
        "delta": 0.04,
        "precision": "float32",
    },
    "accurate": {
        "kernel": "wendland-c4",
        "h_over_dx": 2.6,
        "c0_factor": 15.0,
        "integrator": "adams-bashforth",
        "density": "renormalised",
        "diffusion": "fourtakas",
        "delta": 0.04,
        "precision": "float32",
    },
}
GOVERNED = tuple(dict.fromkeys(key for preset in PRESETS.values() for key in preset))  # keys of `numerics`


def without_governed(keys):
    """Return the keys of a scene without what a preset that comes on top of them says anew."""
    numerics = keys.get("numerics")
    if not isinstance(numerics, dict):
        return keys
    return keys | {"numerics": {key: value for key, value in numerics.items() if key not in (*GOVERNED, "preset")}}
