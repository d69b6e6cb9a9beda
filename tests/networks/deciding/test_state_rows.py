"""States as rows against the states that the process computes one by one."""

from __future__ import annotations

import random

import numpy as np
import pytest

from benchmarks.deciding.random_networks import ANY_BINDING
from handcart.networks.chains.chance import Chance
from handcart.networks.chains.step_maker import State
from handcart.networks.deciding.process import Process
from handcart.networks.deciding.state_rows import StateRows
from handcart.networks.graph.network import Action, ActionNetwork, Ending, FailEnding, Situation

COUNT = 7
RENEWING_SEED = 5


def drawn_process(seed: int) -> Process:
    """Draw a network with shared and renewed attempts, several results and Fails by cause."""
    draws = random.Random(seed)

    def there() -> str:
        return f"s{draws.randrange(COUNT)}"

    actions = []
    for here in range(COUNT - 1):
        for number in range(draws.randint(1, 3)):
            renews = draws.random() < 0.3
            actions.append(
                Action(
                    f"s{here}",
                    f"s{here + 1}" if number == 0 else there(),
                    ANY_BINDING,
                    draws.uniform(1.0, 9.0),
                    attempts=2,
                    on_fail=there() if draws.random() < 0.4 else None,
                    p=0.5,
                    p_give_up=0.05,
                    others=(Ending(there(), "other", 0.1),) if draws.random() < 0.4 else (),
                    unlimited=not renews and draws.random() < 0.2,
                    renewals=2 if renews else 0,
                    fresh_after=("MODIFY",) if renews else (),
                    budget="both" if not renews and draws.random() < 0.2 else "",
                    fail_endings=(FailEnding("blocked", there(), 0.1),) if draws.random() < 0.4 else (),
                )
            )
    actions = [
        Action(**{**vars(action), "unlimited": False}) if action.budget else action for action in actions
    ]
    names = [Situation(f"s{number}") for number in range(COUNT)]
    network = ActionNetwork.build(names, actions, "s0", f"s{COUNT - 1}")
    chances = [Chance(action.p_success or 0.0, action.p_give_up) for action in network.actions]
    return Process(network, chances, 600.0)


def following(process: Process, part: int, state: State) -> dict[tuple[int, State], float]:
    """Return the states that follow as rows, by action and state, with their probabilities."""
    rows = StateRows(process, part)
    after = rows.following(rows.row(state))
    found: dict[tuple[int, State], float] = {}
    for option, p, row in zip(after.option, after.p, after.rows, strict=True):
        assert np.array_equal(rows.row(rows.state(row))[0], row), "equal states have equal rows"
        key = rows.actions[int(after.action[option])].index, rows.state(row)
        found[key] = found.get(key, 0.0) + float(p)
    return found


@pytest.mark.parametrize("seed", range(8))
def test_rows_are_followed_by_the_states_of_the_process(seed: int) -> None:
    process = drawn_process(seed)
    ahead, seen = [State("s0", ())], set[State]()
    while ahead and len(seen) < 60:
        state = ahead.pop()
        if state in seen or state.situation == process.network.goal:
            continue
        seen.add(state)
        expected: dict[tuple[int, State], float] = {}
        for option in process.options(state):
            own = [(option.stays, state)] if option.stays else []
            for p, item in (*option.leads, *own):
                expected[option.action.index, item] = p
                ahead.append(item)
        assert following(process, process.part[state.situation], state) == pytest.approx(expected)
    assert len(seen) > 5


def test_attempts_left_are_unlimited_where_they_come_back() -> None:
    process = drawn_process(RENEWING_SEED)
    rows = StateRows(process, process.part["s0"])
    assert {bool(action.renewals) for action in rows.actions} == {True, False}
    for fails, left in ((0, 2.0), (1, 1.0), (2, 0.0)):
        counts = np.full((1, 1 + len(rows.counters)), fails, np.uint16)
        found = rows.attempts(counts)[0]
        for place, action in enumerate(rows.actions):
            assert found[place] == (np.inf if action.renewals or action.unlimited else left)
