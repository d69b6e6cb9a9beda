"""Worst cases of a network: the longest run, situations with nothing left to try, actions never started."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import DEFAULT_MAX_STEPS, Policy, State, TooLarge, policy
from handcart.networks.chains.stage import Stage
from handcart.networks.chains.stages import stages
from handcart.networks.graph.network import Action, ActionNetwork

from .longest_run import Longest, longest_run

FAILS, FOR_GOOD = "fails", "fails for good"

_UNLIKELY = {FAILS: 1, FOR_GOOD: 1000}
Path = tuple[tuple[int, str], ...]
"""Actions by their numbers, each with how it failed; the word is empty where it didn't."""


@dataclass(frozen=True)
class NoWayLeft:
    """A run that ends with nothing left to try, with the fewest Fails among those that end in its
    situation.
    """

    situation: str
    """Situation in which the run ends."""
    path: tuple[tuple[Action, str], ...]
    """Its actions, each with how it failed, from the last situation through which every run comes."""

    def words(self, named: Callable[[str], str] = str) -> str:
        """Return the path for people, `PICK_UP from book_known fails 3 times`.

        Args:
            named: function that returns the displayed name of a situation.
        """
        parts = []
        for (action, failed), group in groupby(self.path):
            count = len(list(group))
            times = f" {count} times" if count > 1 else ""
            parts.append(f"{action.do} from {named(action.source)} {failed}".rstrip() + times)
        return ", ".join(parts)


@dataclass(frozen=True)
class WorstCases:
    """Worst cases of a network, Fails for good and GiveUps included."""

    longest: int
    """The most actions that a run can start."""
    short: tuple[NoWayLeft, ...]
    """One such run for each situation in which nothing may be left to try."""
    unused: tuple[Action, ...]
    """Actions that no run plans, whatever fails; skips are not counted."""
    too_large: tuple[TooLarge, ...] = ()
    """Parts that are too large; only the bound on their actions is known."""


def worst_cases(network: ActionNetwork, effort: Effort | None = None) -> WorstCases:
    """Return the worst cases of a network, exact except in parts that are too large.

    Args:
        network: the network.
        effort: budget of the computation; None: `WORK`.
    """
    effort = effort or Effort(DEFAULT_MAX_STEPS)
    known: dict[object, _Piece | TooLarge] = {}
    longest, used = Longest(0.0, -math.inf), set[int]()
    short: list[NoWayLeft] = []
    too_large: list[TooLarge] = []
    for stage in stages(network):
        if stage.shape not in known:
            known[stage.shape] = _piece(stage, effort)
        piece = known[stage.shape]
        if isinstance(piece, TooLarge):
            too_large.append(piece)
            bound = float(stage.network.bound())
            piece = _Piece(Longest(bound, bound), (), range(len(stage.numbers)))
        longest = longest.then(piece.longest)
        used |= {stage.numbers[index] for index in piece.planned}
        for path in piece.ended:
            named = tuple((network.actions[stage.numbers[index]], failed) for index, failed in path)
            short.append(NoWayLeft(_end(named, stage.network.start), named))
        if longest.through == -math.inf:
            break  # no run comes to the next one
    unused = tuple(a for a in network.actions if a.binding is not None and a.index not in used)
    most = min(int(max(longest)), network.bound())
    return WorstCases(most, tuple(short), unused, tuple(too_large))


class _Piece(NamedTuple):
    """Worst cases of one stage."""

    longest: Longest
    ended: Sequence[Path]
    planned: Collection[int]


def _piece(stage: Stage, effort: Effort) -> _Piece | TooLarge:
    try:
        all_fails = policy(stage.network, for_good=True, effort=effort.half())
    except TooLarge as large:
        return large
    planned = {each.index for step in all_fails.steps.values() for each in step.plan}
    return _Piece(longest_run(all_fails), _ended(all_fails), planned)


class _Come(NamedTuple):
    """A run that reaches a state with the fewest Fails, as a link to the state before."""

    unlikely: int
    """Its Fails; one for good only counts where it takes one."""
    before: State | None
    """State whose plan contained the last Fail."""
    failed: int
    """Position of the failed action in that plan."""
    word: str


def _ended(policy: Policy) -> list[Path]:
    """Return, for each situation in which nothing may be left, a run with the fewest Fails."""
    came = {policy.start: _Come(0, None, 0, "")}
    found: dict[str, State] = {}
    for state in reversed(policy.steps):
        step, here = policy.steps[state], came[state].unlikely
        if not step.plan and (state.situation not in found or here < came[found[state.situation]].unlikely):
            found[state.situation] = state
        for number, after in enumerate(zip(step.after_fail, step.for_good, strict=True)):
            for word, failed in zip((FAILS, FOR_GOOD), after, strict=True):
                there = here + _UNLIKELY[word]
                if failed is not None and (failed not in came or there < came[failed].unlikely):
                    came[failed] = _Come(there, state, number, word)
    return [_path(policy, came, state) for state in found.values()]


def _path(policy: Policy, came: Mapping[State, _Come], end: State) -> Path:
    """Return the path from the policy's start to a state."""
    path: list[tuple[int, str]] = []
    last = came[end]
    while last.before is not None:
        done = [(action.index, "") for action in policy.steps[last.before].plan[: last.failed + 1]]
        done[-1] = (done[-1][0], last.word)
        path = done + path
        last = came[last.before]
    return tuple(path)


def _end(path: tuple[tuple[Action, str], ...], start: str) -> str:
    if not path:
        return start
    action, failed = path[-1]
    return (action.on_fail or action.source) if failed else action.target
