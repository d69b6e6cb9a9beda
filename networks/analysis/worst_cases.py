"""What can happen at the worst: the longest run, where nothing is left to try, what no run ever starts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby

from networks.network import Action, ActionNetwork

from .longest_run import Longest, longest_run
from .policy import Policy, State, policy
from .stages import stages

FAILS, FOR_GOOD = "fails", "fails for good"

Path = tuple[tuple[int, str], ...]
"""Actions by their numbers, each with how it failed; the word is empty where it didn't."""


@dataclass(frozen=True)
class NoWayLeft:
    """A run that comes to where nothing is left to try, with as few Fails as any that ends there."""

    situation: str
    """Where it ends."""
    path: tuple[tuple[Action, str], ...]
    """Its actions, each with how it failed, from the last situation through which every run comes."""

    def words(self, named: Callable[[str], str] = str) -> str:
        """The path for people, `PICK_UP from book_known fails 3 times`; with situations `named` so."""
        told = []
        for (action, failed), group in groupby(self.path):
            count = len(list(group))
            times = f" {count} times" if count > 1 else ""
            told.append(f"{action.do} from {named(action.source)} {failed}".rstrip() + times)
        return ", ".join(told)


@dataclass(frozen=True)
class WorstCases:
    """What can happen at the worst, Fails for good and GiveUps included."""

    longest: int
    """The most actions that a run can start."""
    short: tuple[NoWayLeft, ...]
    """One for each situation in which nothing may be left to try."""
    unused: tuple[Action, ...]
    """Actions that no run plans, whatever fails; skips are none of them."""


def worst_cases(network: ActionNetwork) -> WorstCases:
    """The worst cases, exactly.

    Raises:
        TooLarge: a part of the network has too many states.
    """
    known: dict[object, tuple[Longest, list[Path], set[int]]] = {}
    longest, short, used = Longest(0.0, -math.inf), [], set()
    for stage in stages(network):
        if stage.shape not in known:
            all_fails = policy(stage.network, for_good=True)
            planned = {each.index for step in all_fails.steps.values() for each in step.plan}
            known[stage.shape] = longest_run(all_fails), _ended(all_fails), planned
        piece, paths, planned = known[stage.shape]
        longest = longest.then(piece)
        used |= {stage.numbers[index] for index in planned}
        for path in paths:
            named = tuple((network.actions[stage.numbers[index]], failed) for index, failed in path)
            short.append(NoWayLeft(_end(named, stage.network.start), named))
        if longest.through == -math.inf:
            break  # no run comes to the next one
    unused = tuple(a for a in network.actions if a.binding is not None and a.index not in used)
    return WorstCases(int(max(longest)), tuple(short), unused)


def _ended(policy: Policy) -> list[Path]:
    """For each situation in which nothing may be left, a run with the fewest Fails."""
    paths: dict[State, Path] = {policy.start: ()}
    found: dict[str, Path] = {}
    for state in reversed(policy.steps):
        step, path = policy.steps[state], paths[state]
        if not step.plan and (state.situation not in found or _fails(path) < _fails(found[state.situation])):
            found[state.situation] = path
        for action, *after in zip(step.plan, step.after_fail, step.for_good, strict=True):
            for word, failed in zip((FAILS, FOR_GOOD), after, strict=True):
                there = (*path, (action.index, word))
                if failed is not None and (failed not in paths or _fails(there) < _fails(paths[failed])):
                    paths[failed] = there
            path = (*path, (action.index, ""))
    return list(found.values())


def _fails(path: Path) -> int:
    """How unlikely it is: a Fail for good only counts where it takes one."""
    return sum({"": 0, FAILS: 1, FOR_GOOD: 1000}[failed] for _, failed in path)


def _end(path: tuple[tuple[Action, str], ...], start: str) -> str:
    if not path:
        return start
    action, failed = path[-1]
    return (action.on_fail or action.source) if failed else action.target
