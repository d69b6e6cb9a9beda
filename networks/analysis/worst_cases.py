"""Worst cases of a network: the longest run, situations with nothing left to try, actions never started."""

from __future__ import annotations

import heapq
import itertools
import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import Policy, State, TooLarge, budget_of, explored
from handcart.networks.chains.stage import Stage
from handcart.networks.chains.stages import stages
from handcart.networks.graph.network import Action, ActionNetwork

from .longest_run import Longest, longest_run

FAILS, FOR_GOOD = "fails", "fails for good"

_UNLIKELY = {FAILS: 1, FOR_GOOD: 1000}
Path = tuple[tuple[int, str], ...]
"""Numbers of the actions of a run, each with a word for how the action failed; empty if it didn't."""


@dataclass(frozen=True)
class NoWayLeft:
    """Run that ends in a certain situation because no action is left to try; of such runs, one with the
    fewest Fails.
    """

    situation: str
    """Situation in which the run ends."""
    path: tuple[tuple[Action, str], ...]
    """Actions of the run, each with a word for how it failed.

    The path begins at the last situation that every run passes.
    """

    def words(self, named: Callable[[str], str] = str) -> str:
        """Return the actions of the run (`path`) as text, such as `PICK_UP from book_known fails 3 times`.

        An action that is repeated is listed once, at its first occurrence.

        Args:
            named: function that returns the displayed name of a situation.
        """
        counts = Counter((action.index, failed) for action, failed in self.path)
        actions = {action.index: action for action, _ in self.path}
        alike: dict[tuple[str, str], set[str]] = {}
        for action in actions.values():
            alike.setdefault((action.name, action.source), set()).add(action.target)
        parts = []
        for (index, failed), count in counts.items():
            action, times = actions[index], f" {count} times" if count > 1 else ""
            ends = alike[action.name, action.source]
            is_clear = len({named(end) for end in ends}) == len(ends)
            to = f" to {named(action.target) if is_clear else action.target}" if len(ends) > 1 else ""
            parts.append(f"{action.name} from {named(action.source)}{to} {failed}".rstrip() + times)
        return ", ".join(parts)


@dataclass(frozen=True)
class WorstCases:
    """Longest run of a network, its possible ends short of the goal, and the actions that no run ever plans.

    GiveUps and Fails that use up all attempts at once are taken into account.
    """

    longest: int
    """The most actions that a run can start, or a bound on it if parts are too large."""
    short: tuple[NoWayLeft, ...]
    """One run for each situation in which nothing may be left to try."""
    unused: tuple[Action, ...]
    """Actions that no run plans, whatever fails; skips are not counted."""
    too_large: tuple[TooLarge, ...] = ()
    """Parts whose states were not all looked at."""
    longest_low: int = 0
    """Number of actions of the longest run that was found."""


def worst_cases(network: ActionNetwork, effort: Effort | None = None) -> WorstCases:
    """Return the longest run of a network, its possible ends short of the goal, and the actions that no run
    plans.

    The result is exact, except in parts of the network whose states are too many to examine.

    Args:
        network: the network.
        effort: budget of the computation, in steps of search; None: the network's default (`budget_of`).
    """
    effort = effort or Effort(budget_of(network))
    known: dict[object, _Piece] = {}
    most, least, used = Longest(0.0, -math.inf), Longest(0.0, -math.inf), set[int]()
    short: list[NoWayLeft] = []
    too_large: list[TooLarge] = []
    for stage in stages(network):
        if stage.shape not in known:
            known[stage.shape] = _piece(stage, effort)
        piece = known[stage.shape]
        too_large += [piece.too_large] if piece.too_large else []
        most, least = most.then(piece.most), least.then(piece.least)
        used |= {stage.numbers[index] for index in piece.planned}
        for path in piece.ended:
            named = tuple((network.actions[stage.numbers[index]], failed) for index, failed in path)
            short.append(NoWayLeft(_end(named, stage.network.start), named))
        if most.through == -math.inf:
            break  # no run comes to the next one
    unused = tuple(a for a in network.actions if a.binding is not None and a.index not in used)
    bound = network.bound()
    low = max(0.0, *least)
    return WorstCases(
        min(int(max(most)), bound), tuple(short), unused, tuple(too_large), min(int(low), bound)
    )


class _Piece(NamedTuple):
    """Worst cases of one stage."""

    most: Longest
    least: Longest
    ended: Sequence[Path]
    planned: Collection[int]
    too_large: TooLarge | None


def _piece(stage: Stage, effort: Effort) -> _Piece:
    found = explored(stage.network, for_good=True, effort=effort.half())
    known, ended = longest_run(found), _ended(found)
    if found.is_complete:
        planned = {step.action.index for step in found.steps.values() if step.action is not None}
        return _Piece(known, known, ended, planned, None)
    bound = float(stage.network.bound())
    large = TooLarge(stage.network, len(found.steps))
    return _Piece(Longest(bound, bound), known, ended, range(len(stage.numbers)), large)


class _Come(NamedTuple):
    """Last step of a run that reaches a state with the fewest Fails, with the state before it."""

    before: State
    action: int
    word: str


def _ended(policy: Policy) -> list[Path]:
    """Return, for each situation in which nothing may be left, a run with the fewest Fails.

    Fails for good are included only where no run without them gets there.
    """
    came: dict[State, _Come] = {}
    known = {policy.start: (0, 0)}
    order = itertools.count()
    heap = [((0, 0), next(order), policy.start)]
    found: dict[str, State] = {}
    while heap:
        here, _, state = heapq.heappop(heap)
        step = policy.steps.get(state)
        if step is None or here > known[state]:
            continue
        if step.action is None:
            found.setdefault(state.situation, state)
            continue
        after = [(item, "") for item in step.succeeded]
        causes = [f"{FAILS} ({ending.cause})" for ending in step.action.fail_endings]
        failed = zip(step.all_failed, (FAILS, *causes), strict=True)
        for item, word in (*after, *failed, (step.for_good, FOR_GOOD)):
            there = here[0] + _UNLIKELY.get(word, bool(word)), here[1] + 1
            if item is not None and there < known.get(item, (math.inf, 0)):
                known[item], came[item] = there, _Come(state, step.action.index, word)
                heapq.heappush(heap, (there, next(order), item))
    return [_path(came, policy.start, state) for state in found.values()]


def _path(came: Mapping[State, _Come], start: State, end: State) -> Path:
    """Return the path from the policy's start to a state."""
    path, here = list[tuple[int, str]](), end
    while here != start:
        path.append((came[here].action, came[here].word))
        here = came[here].before
    return tuple(reversed(path))


def _end(path: tuple[tuple[Action, str], ...], start: str) -> str:
    if not path:
        return start
    action, failed = path[-1]
    return action.after_fail(failed.partition("(")[2].rstrip(")")) if failed else action.target
