"""Every wall treatment on slabs: every rank runs the whole scene alone too, and compares all bits."""

import numpy as np
import pytest
from test_ghost_slabs import both
from test_slabs import assert_same_run, gathered

import parsph.simulation
from parsph.scene.load import load_scene
from parsph.walls import REPULSIONS, TREATMENTS, WEIGHTS

BED = {
    "name": "tank",
    "points": [[0.0, 0.5], [0.0, 0.06], [1.0, 0.06], [1.0, 0.5]],
    "bulge": {"edge": 1, "amplitude": 0.03, "period": 0.05},
}
FLAP = {
    "name": "flap",
    "points": [[0.48, 0.19], [0.62, 0.19], [0.62, 0.33], [0.48, 0.33]],
    "fluid": "outside",
    "motion": {"way": [0.05, 0.01], "angle": 20.0, "period": 0.1, "ramp": 0.02},
}
SIDES = {"left": {}, "right": {}, "bottom": {}}
MARKERS = [name for name, treatment in TREATMENTS.items() if treatment.family == "markers"]
WALLS = {
    **{name: {**SIDES, "treatment": name} for name in TREATMENTS},
    **{f"deficiency, {name}": {**SIDES, "treatment": "deficiency", "weights": name} for name in WEIGHTS},
    **{
        f"{treatment}, {law}": {**SIDES, "treatment": treatment, "repulsion": law}
        for treatment in MARKERS
        for law in REPULSIONS
        if law != "none"
    },
    **{f"{name} that bulge": {"polygons": [BED], "treatment": name} for name in ("ghosts", "strip", "deficiency")},
    **{
        f"{name} with a flap": {**SIDES, "polygons": [FLAP], "treatment": name} for name in ("strip", "deficiency", "repulsion")
    },
}


def scene(walls):
    """Return a scene whose water begins out of balance: a high column at the left, a low one at the right."""
    low = 0.06 if any("bulge" in wall for wall in walls.get("polygons", [])) else 0.0
    blocks = [{"low": [0.0, low], "high": [0.44, low + 0.4]}, {"low": [0.44, low], "high": [1.0, low + 0.28]}]
    if FLAP in walls.get("polygons", []):
        blocks = [{"low": [0.0, low], "high": [1.0, low + 0.28]}]
    return load_scene(
        {
            "domain": {"size": [1.0, 0.6]},
            "fluid": {"blocks": blocks},
            "walls": walls,
            "numerics": {
                "dx": 0.04,
                "h_over_dx": 1.5,
                "density_range": [0.4, 2.0],
                "diffusion": "fourtakas",
                "viscosity": "monaghan",
                "alpha": 0.1,
            },
            "time": {"end": 0.03, "cfl": 0.3},
            "gauges": [
                {"kind": "pressure", "point": [0.5, 0.1], "extent": [0.4, 0.1], "every": 0.005},
                {"kind": "energy", "every": 0.005},
                *[{"kind": "power", "every": 0.005}] * (walls.get("treatment") not in MARKERS),
            ],
        }
    )


@pytest.mark.parametrize("name", WALLS)
def test_walls_of_every_treatment_are_the_same_on_all_ranks_to_the_bit(communicator, monkeypatch, name):
    """Fields, masses and gauges, while cuts move every ten steps."""
    monkeypatch.setattr(parsph.simulation, "BALANCE_EVERY", 10)
    mine, alone, _ = both(scene(WALLS[name]), communicator)
    assert alone.steps > 20
    assert_same_run(mine, alone)
    np.testing.assert_array_equal(gathered(mine, "mass"), alone.field("mass"))
    if mine.domain.markers and mine.domain.markers.weights:
        share = mine.domain.markers.share
        np.testing.assert_array_equal(mine.domain.markers.strength[share.mine], alone.domain.markers.strength[share.mine])
        assert (alone.domain.markers.strength < 0).sum() > 2
