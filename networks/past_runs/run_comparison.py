"""Two past runs side by side: aligned by action, with the first difference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Any

from .past_run import PastAction, PastRun, Record

HEADER_KEYS = ("task_sha256", "network", "settings", "robot", "robot_sha256", "backend", "seed", "handcart")
UNCHAINED_KEYS = {"wall", "h", "p"}
"""Keys of a record that differ between two equal runs, or follow from the records before."""


@dataclass(frozen=True)
class ComparedAction:
    """Action that two compared runs have in common, or that only one of them has."""

    one: PastAction | None
    other: PastAction | None

    @property
    def action(self) -> PastAction:
        """Action of the first run, or of the second if the first lacks it."""
        found = self.one or self.other
        assert found is not None
        return found

    @property
    def differs(self) -> str:
        """First property that differs: action, parameters, outcome, cause, residuals or time; empty if none
        does.
        """
        one, other = self.one, self.other
        if one is None or other is None:
            return "action"
        pairs = {
            "parameters": (one.parameters, other.parameters),
            "outcome": (one.outcome, other.outcome),
            "cause": ((one.cause, one.reason), (other.cause, other.reason)),
            "residuals": (_residuals(one), _residuals(other)),
            "time": self.seconds,
        }
        return next((name for name, (mine, theirs) in pairs.items() if mine != theirs), "")

    @property
    def seconds(self) -> tuple[float | None, float | None]:
        """Duration of the action in each of the two runs, in [s]; None for a run without the action."""
        return _seconds(self.one), _seconds(self.other)

    def residuals(self) -> Iterator[tuple[str, float | None, float | None]]:
        """Yield each residual (deviation after restoring) that differs between the runs.

        Each is a name with the unit, and the residual's size in each run; None if a run lacks it.
        """
        mine, theirs = _residuals(self.one), _residuals(self.other)
        for name in dict.fromkeys([*mine, *theirs]):
            if mine.get(name) != theirs.get(name):
                yield name, mine.get(name), theirs.get(name)


@dataclass(frozen=True)
class RunComparison:
    """Comparison of two past runs, with their actions in pairs."""

    one: PastRun
    other: PastRun
    actions: tuple[ComparedAction, ...]

    @property
    def headers(self) -> dict[str, tuple[Any, Any]]:
        """Settings that differ between the runs: key, and its value in each run."""
        found = {key: (self.one.header.get(key), self.other.header.get(key)) for key in HEADER_KEYS}
        return {key: pair for key, pair in found.items() if pair[0] != pair[1]}

    @property
    def first(self) -> ComparedAction | None:
        """First action that differs in more than time; None without a difference."""
        return next((action for action in self.actions if action.differs not in ("", "time")), None)

    @property
    def first_record(self) -> tuple[Record | None, Record | None] | None:
        """The first pair of records that differ, one of each run; None if all are equal.

        The headers and times of the wall clock are not compared. A run that ended earlier has None.
        """
        mine, theirs = self.one.records[1:], self.other.records[1:]
        for at in range(max(len(mine), len(theirs))):
            pair = (mine[at] if at < len(mine) else None), (theirs[at] if at < len(theirs) else None)
            if pair[0] is None or pair[1] is None or _chained(pair[0]) != _chained(pair[1]):
                return pair
        return None

    @property
    def equal(self) -> bool:
        """True if the journals have equal records, except for their headers and times of the wall clock."""
        return self.first_record is None


def compare_runs(one: PastRun, other: PastRun) -> RunComparison:
    """Return the comparison of two runs; actions of the same primitive and situations are paired in order."""
    mine, theirs = (
        [_identity(action) for action in one.actions],
        [_identity(action) for action in other.actions],
    )
    rows: list[ComparedAction] = []
    for kind, low, high, start, end in SequenceMatcher(None, mine, theirs, False).get_opcodes():
        if kind == "equal":
            pairs = zip(one.actions[low:high], other.actions[start:end], strict=True)
            rows += [ComparedAction(*pair) for pair in pairs]
            continue
        rows += [ComparedAction(action, None) for action in one.actions[low:high]]
        rows += [ComparedAction(None, action) for action in other.actions[start:end]]
    return RunComparison(one, other, tuple(rows))


def _identity(action: PastAction) -> tuple[str, str, str]:
    return action.do, action.source, action.target


def _seconds(action: PastAction | None) -> float | None:
    return None if action is None else round(action.end - action.start, 6)


def _residuals(action: PastAction | None) -> Mapping[str, float | None]:
    found: Mapping[str, float | None] = {} if action is None else action.result.get("residuals", {})
    return found


def _chained(record: Record) -> dict[str, Any]:
    """Return a record's fields without those that depend on the wall clock or the header."""
    return {key: value for key, value in record.items() if key not in UNCHAINED_KEYS}


def record_words(pair: Sequence[Record | None]) -> str:
    """Describe two records that should be equal: their kinds and times, and the keys that differ."""
    one, other = pair
    if one is None or other is None:
        last = one or other
        assert last is not None
        return f"{'the first' if other is None else 'the second'} run alone goes on, with {_at(last)}"
    keys = [key for key in {**one, **other} if key not in UNCHAINED_KEYS and one.get(key) != other.get(key)]
    return f"{_at(one)} against {_at(other)} differ in {', '.join(keys)}"


def _at(record: Record) -> str:
    return f"{record['kind']} at {record['t']:.3f} s (record {record['q']})"
