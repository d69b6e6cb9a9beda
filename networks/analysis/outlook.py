"""Effect of a permission, or of its refusal, on the probability of the goal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.policy import State, policy, success_shares
from handcart.networks.chains.policy_chain import policy_chain
from handcart.networks.graph.planner import Planner
from handcart.networks.task.task_file import Task

from .figures import missing_chances, network_chances


class NoOutlook(Exception):
    """Error, because an action of the task has no probability, so that the expected end of a run cannot be
    computed.
    """


class Outlook(NamedTuple):
    """Probabilities that a run reaches its goal, for each answer of a person who is asked whether an action
    may start.

    Runs that leave an element of a `repeat` undone are not counted as reaching the goal.
    """

    permitted: float
    """Probability if the action is permitted now, as well as all later ones."""
    succeeded: float
    """Probability once the action has succeeded; the mean over its results if it has several."""
    refused: float
    """Probability if the action is refused, which uses up one of its attempts."""


def outlook(task: Task, situation: str, counts: Mapping[int, int], action: int) -> Outlook:
    """Return the probabilities of reaching the goal if a waiting action is permitted, succeeds, or is
    refused.

    They are exact for the outcome probabilities in the task's file, if the coordinator decides by the rule
    (it starts the first action of the cheapest plan to the goal).

    Args:
        task: the task of the run.
        situation: the run's present situation.
        counts: counts of Fails by counter (`Action.counter`), as in `Attempts`; those at 0 may be missing.
        action: number of the action that waits for permission.

    Raises:
        NoOutlook: an action has no probability.
        TooLarge: there are too many states.
    """
    if missing := missing_chances(task):
        count = len(missing)
        raise NoOutlook(
            f"{count} action{'s have' if count > 1 else ' has'} no probability `p` in the task's file"
        )
    one = task.network.actions[action]
    done, failed = Planner(task.network), Planner(task.network)
    for planner in (done, failed):
        planner.counts.update(counts)
    done.succeeded(one)
    failed.refused(one, "")
    ends = one.target, *(other.target for other in one.others)
    shares = success_shares(one, network_chances(task)[action] or Chance(1.0))
    return Outlook(
        _goal(task, situation, counts),
        sum(p * _goal(task, end, done.counts) for p, end in zip(shares, ends, strict=True) if p > 0.0),
        _goal(task, situation, failed.counts),
    )


def _goal(task: Task, situation: str, counts: Mapping[int, int]) -> float:
    if situation == task.network.goal:
        return 1.0
    chances = network_chances(task)
    start = State(situation, tuple(sorted(counts.items())))
    return policy_chain(policy(task.network, start=start, chances=chances), chances).ends.goal.p
