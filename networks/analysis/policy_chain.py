"""The absorbing Markov chain of what the coordinator does in a part of a network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .chance import Chance
from .ends import AT_GOAL, NOTHING_LEFT, Ends
from .moments import certain
from .policy import Policy, State, Step

Chances = Sequence[Chance | None]
"""For each action by its number; None for a skip, which always succeeds."""


@dataclass(frozen=True)
class Chain:
    """What is known of the part, for runs that enter it."""

    ends: Ends
    starts: tuple[float, ...]
    """For each action how often it is started, on average."""
    slopes: tuple[float, ...]
    """For each action by how much P(goal) grows with its probability of Success, the Fails becoming fewer."""


def policy_chain(policy: Policy, chances: Chances) -> Chain:
    """The exact figures: one pass back over the states, one forward.

    The chain is acyclic, so the equations of Kemeny and Snell, Finite Markov Chains (1960), chapter 3, need
    no matrix: each state's ends follow from those of its successors.
    """
    ends: dict[State, Ends] = {}
    for state, step in policy.steps.items():
        ends[state] = _along(step, chances, ends, policy.network.goal)[0]
    start = ends.get(policy.start, AT_GOAL)
    return Chain(start, *_forward(policy, chances, ends))


def _after(state: State | None, ends: Mapping[State, Ends], goal: str) -> Ends:
    assert state is not None
    return AT_GOAL if state.situation == goal else ends[state]


def _along(step: Step, chances: Chances, ends: Mapping[State, Ends], goal: str) -> list[Ends]:
    """The ends before each action of a plan, and after the last."""
    found = [AT_GOAL if step.plan else NOTHING_LEFT]
    for action, failed in zip(reversed(step.plan), reversed(step.after_fail), strict=True):
        chance = chances[action.index]
        if action.binding is None or chance is None:
            found.append(found[-1].with_a_skip())
            continue
        succeeds = found[-1].after(certain(chance.success, action.cost_s))
        fails = _after(failed, ends, goal).after(certain(chance.fail, action.cost_s))
        gives_up = Ends(give_up=certain(chance.give_up, action.cost_s))
        found.append(succeeds.plus(fails).plus(gives_up))
    return found[::-1]


def _forward(
    policy: Policy, chances: Chances, ends: Mapping[State, Ends]
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """How often each action is started, and each one's slope."""
    goal = policy.network.goal
    starts, slopes = [0.0] * len(policy.network.actions), [0.0] * len(policy.network.actions)
    # Of each state: how likely a run comes to it at all, and with nothing left undone.
    comes: dict[State, list[float]] = {policy.start: [1.0, 1.0]}
    for state in reversed(policy.steps):
        step = policy.steps[state]
        here, whole = comes.get(state, (0.0, 0.0))
        ahead = _along(step, chances, ends, goal)[1:]
        for action, failed, then in zip(step.plan, step.after_fail, ahead, strict=True):
            chance = chances[action.index]
            if failed is None or chance is None:
                whole = 0.0
                continue
            starts[action.index] += here
            slopes[action.index] += whole * (then.goal.p - _after(failed, ends, goal).goal.p)
            there = comes.setdefault(failed, [0.0, 0.0])
            there[0] += here * chance.fail
            there[1] += whole * chance.fail
            here, whole = here * chance.success, whole * chance.success
    return tuple(starts), tuple(slopes)
