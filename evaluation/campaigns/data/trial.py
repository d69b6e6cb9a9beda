"""One run of a campaign: how it ended, and each action on the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any, NamedTuple


class ActionEnd(NamedTuple):
    """Outcome of a started action."""

    action: str
    """Name from the task file, the same for all elements of a repeat: `MOVE_TO (loaded to there)`."""
    source: str
    """The situation, in a repeat with its copy's number: `loaded[2]`."""
    target: str
    outcome: str
    """Success, Fail or GiveUp."""
    time_s: float
    """When it ended, of the robot's time."""
    reason: str = ""
    """Why it didn't succeed."""
    check: str = ""
    """Check that found the cause, as in `Cause.check`."""
    for_good: bool = False
    """True if a Fail used up all attempts."""
    cause: str = ""
    """Kind of cause of a Fail or GiveUp; campaigns from before there were any have none."""

    @property
    def primitive(self) -> str:
        """Its name."""
        return self.action.partition(" ")[0]


@dataclass(frozen=True)
class Trial:
    """One run of a campaign."""

    seed: int
    status: int
    summary: Mapping[str, Any]
    actions: Sequence[ActionEnd] = ()
    """Outcomes of the actions, in the order in which they ended."""
    signalled: bool = False
    """True if an interrupt arrived, even after the last action."""
    varied: Mapping[str, float] = field(default_factory=dict)
    """The numbers that vary from trial to trial, by name."""
    faults: Sequence[Mapping[str, Any]] = ()
    """Injected faults in order, each with `fault`, `at_s` and `bitten`."""

    @property
    def success(self) -> bool:
        """True if the goal was reached."""
        return self.status == 0

    @property
    def run_name(self) -> str:
        """Name of the run's folder; empty without one."""
        return PurePath(str(self.summary.get("run_dir") or "")).name

    @property
    def cancelled(self) -> bool:
        """True if a person stopped the trial; then it says nothing about the task."""
        return bool(self.summary["outcome"] == "Cancelled")

    @property
    def interrupted(self) -> bool:
        """True if a signal stopped the trial or arrived at its end; the whole campaign then stops."""
        if self.signalled or not self.cancelled:
            return self.signalled
        from handcart.networks.coordination.supervision import INTERRUPTED_REASON

        return bool(self.summary["reason"] == INTERRUPTED_REASON)

    @property
    def untrue(self) -> Sequence[str]:
        """What the ground truth contradicts."""
        return list(self.summary["metrics"].get("untrue", []))


def died(seed: int, reason: str) -> Trial:
    """A trial whose process doesn't survive it: a fault in here, or in a library."""
    nothing = {"sim_time_s": 0.0, "wall_time_s": 0.0, "actions": 0, "fails": 0, "metrics": {}}
    return Trial(seed, 5, {"outcome": "Error", "reason": reason, "seed": seed, "run_dir": "", **nothing})
