"""Ranks share what columns cost: counted, so that no clock decides."""

import numpy as np
import pytest
from helpers import tank

from parsph.domain import imbalance
from parsph.parallel import Communicator
from parsph.particles import FIRST_GHOST
from parsph.scene.build import build
from parsph.scene.forecast import forecast
from parsph.scene.load import load_scene
from parsph.traffic import traffic

BAR = 1.1  # largest over mean cost of the ranks
NUMERICS = {"dx": 0.008, "h_over_dx": 1.3, "diffusion": "fourtakas", "viscosity": "monaghan", "alpha": 0.1, "c0": 10.0}


def lines(length, height):
    """Return walls of fixed ghosts around a tank."""
    points = [[0.0, height], [0.0, 0.0], [length, 0.0], [length, height]]
    return {"polygons": [{"name": "tank", "points": points, "fluid": "left"}]}


SCENES = {
    "dam break": tank(
        domain={"size": [2.0, 0.4], "gravity": 9.81},
        fluid={"blocks": [{"low": [0.0, 0.0], "high": [0.8, 0.12]}]},
        walls=lines(2.0, 0.4),
        numerics={**NUMERICS, "density_range": [0.5, 2.0]},
        time={"end": 0.8, "cfl": 0.4},
    ),
    "front": tank(
        domain={"size": [1.6, 0.3], "gravity": 9.81},
        fluid={"blocks": [{"low": [0.0, 0.0], "high": [0.3, 0.16]}, {"low": [0.3, 0.0], "high": [1.6, 0.064]}]},
        numerics=NUMERICS,
        time={"end": 0.4, "cfl": 0.4},
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_ranks_stay_balanced_while_a_front_runs(communicator, name):
    """Looked at before each move of the cuts, when they are at their worst; left where they began they would miss the bar."""
    if communicator.size == 1:
        pytest.skip("one rank has nobody to share with")
    simulation = build(load_scene(SCENES[name]), communicator)
    simulation.prepare()
    cuts = simulation.domain.cuts
    while simulation.time < simulation.end:
        simulation.advance()
    assert simulation.imbalance.count > 20
    assert simulation.imbalance.largest <= BAR
    with simulation.present():
        assert imbalance(simulation.domain.column_costs(), cuts) > BAR


def counted_costs(domain):
    """Return the cost of each column, a cell at a time; for one rank."""
    from parsph.domain.cost import MIRROR_POINT, ROW

    shape, starts, tags = (domain.slab.columns + 2, domain.grid.shape[1]), domain.starts, domain.particles.tags
    mirrors = np.bincount(domain.ghosts.share.cells, minlength=len(starts)) if domain.ghosts else np.zeros(len(starts))
    costs = np.zeros(domain.slab.columns)
    for column in range(1, shape[0] - 1):
        for row in range(shape[1]):
            cell, candidates = column * shape[1] + row, 0
            for other in range(column - 1, column + 2):
                low, high = other * shape[1] + max(row - 1, 0), other * shape[1] + min(row + 2, shape[1])
                candidates += starts[high] - starts[low]
            rows = tags[starts[cell] : starts[cell + 1]]
            fluid = np.sum(rows < FIRST_GHOST)
            costs[column - 1] += fluid * candidates + ROW * len(rows) + MIRROR_POINT * mirrors[cell] * candidates
    return costs


@pytest.mark.parametrize("name", SCENES)
def test_cost_is_counted_alike_on_any_number_of_ranks(communicator, name):
    """And as a plain loop over cells counts it."""
    scene = load_scene(SCENES[name])
    mine, alone = build(scene, communicator), build(scene, Communicator())
    for simulation in (mine, alone):
        simulation.prepare()
    costs = alone.domain.column_costs()
    np.testing.assert_array_equal(mine.domain.column_costs(), costs)
    np.testing.assert_array_equal(costs, counted_costs(alone.domain))
    assert costs.sum() > 0


@pytest.mark.parametrize("name", SCENES)
def test_forecast_is_near_what_a_step_sends_and_needs(communicator, name):
    """Messages exactly; bytes within a tenth, memory within 15 %, since particles move and arrays grow in leaps."""
    scene = load_scene(SCENES[name])
    expected = forecast(scene, communicator.size)
    simulation = build(scene, communicator)
    simulation.prepare()
    exchange, calls = simulation.domain.exchange, communicator.collectives["Allreduce"]
    before = exchange.messages, exchange.bytes
    assert imbalance(simulation.domain.column_costs(), simulation.domain.cuts) == pytest.approx(expected.imbalance, abs=0.02)
    for _ in range(10):
        simulation.advance()
    messages, sent = (count / 10 for count in (exchange.messages - before[0], exchange.bytes - before[1]))
    every = communicator.allgather((messages, sent, simulation.particles.nbytes))
    messages, sent, memory = (np.array(values) for values in zip(*every, strict=True))
    assert (messages.mean(), messages.max()) == expected.messages
    assert (sent.mean(), sent.max()) == pytest.approx(expected.bytes, rel=0.1)
    assert memory.max() == pytest.approx(expected.memory, rel=0.15)
    assert (sent.max() > 0) == (communicator.size > 1)
    assert communicator.collectives["Allreduce"] == calls + (10 if communicator.size > 1 else 0)


def test_traffic_is_told_of_the_mean_and_the_largest(communicator):
    """Of three ranks the middle one has two neighbours; a time step is agreed on by one Allreduce."""
    scene = load_scene(SCENES["front"], {"time.end": 0.02})
    simulation = build(scene, communicator)
    simulation.prepare()
    before, at_first = communicator.collectives.copy(), traffic(simulation, simulation.steps)["communication"]["messages"]
    while simulation.time < simulation.end:
        simulation.advance()
    told = traffic(simulation, simulation.steps)
    messages, steps = told["communication"]["messages"], simulation.steps
    assert steps > 20
    neighbours = 2 * (communicator.size - 1) / communicator.size
    assert steps * messages["mean"] - at_first["mean"] == pytest.approx(3 * neighbours * steps)
    assert steps * messages["largest"] - at_first["largest"] == pytest.approx(3 * min(communicator.size - 1, 2) * steps)
    sent = communicator.allgather(simulation.domain.exchange.bytes)
    assert told["communication"]["bytes"]["largest"] == max(sent) / steps
    if communicator.size > 1:
        assert communicator.collectives["Allreduce"] - before["Allreduce"] == steps
        assert told["imbalance"]["largest"] == simulation.imbalance.largest >= told["imbalance"]["mean"] >= 1.0
    else:
        assert told["imbalance"] is None
        assert told["communication"]["collectives"] == {}
