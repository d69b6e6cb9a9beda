"""Lower bounds of situations without some actions, many at once against one at a time."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.deciding.random_networks import ANY_BINDING, drawn
from handcart.networks.chains.chance import Chance
from handcart.networks.deciding.process import Process
from handcart.networks.deciding.situation_values import SituationValues
from handcart.networks.graph.network import Action, ActionNetwork, Situation


def ring(count: int, choices: int) -> Process:
    """Return a ring of situations with several actions from each to the next, and a goal besides."""
    names = [f"s{number}" for number in range(count)]
    actions = [
        Action(name, names[(number + 1) % count], ANY_BINDING, 1.0 + choice)
        for number, name in enumerate(names)
        for choice in range(choices)
    ]
    actions.append(Action(names[-1], "z", ANY_BINDING, 3.0))
    network = ActionNetwork.build(map(Situation, [*names, "z"]), actions, names[0], "z")
    return Process(network, [Chance(0.5, 0.01)] * len(actions), 600.0)


@pytest.mark.parametrize(
    "process",
    [
        pytest.param(Process(*drawn("anywhere", 3), 600.0), id="few actions"),
        pytest.param(ring(24, 3), id="more than 64 actions"),
    ],
)
def test_many_bounds_at_once_equal_those_of_one_at_a_time(process: Process) -> None:
    part = max(range(len(process.parts)), key=lambda number: len(process.parts[number]))
    names = [name for name in process.parts[part] if name != process.network.goal]
    actions = [action for name in names for action in process.out[name]]
    draws = np.random.default_rng(0)
    out = draws.random((20, len(actions))) < draws.choice([0.05, 0.3], (20, 1))
    out[10:, :64] = out[:10, :64]
    places = np.tile(np.arange(len(names)), 20)[:20]
    together = SituationValues(process)
    found = np.concatenate(
        [together.without_each(part, out[rows], places[rows]) for rows in (slice(15), slice(15, 20))]
    )
    for mask, place, value in zip(out, places.tolist(), found.tolist(), strict=True):
        alone = SituationValues(process)
        assert value == pytest.approx(alone.without_each(part, mask[None, :], np.array([place]))[0], rel=1e-9)
        excluded = frozenset(action.index for action, is_out in zip(actions, mask, strict=True) if is_out)
        assert value <= alone.without(names[place], excluded) * (1.0 + 1e-9)
