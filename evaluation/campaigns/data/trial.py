"""Trial of a campaign: how the run and each of its actions ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any, NamedTuple


class ActionEnd(NamedTuple):
    """End of one action in a trial, with the action's name, situations, outcome and reason."""

    action: str
    """Name from the task file, the same for all elements of a repeat: `MOVE_TO (loaded to there)`."""
    source: str
    """Situation in which the action started; in a repeat with the number of the element, as in
    `loaded[2]`.
    """
    target: str
    outcome: str
    """Success, Fail or GiveUp."""
    time_s: float
    """Robot time at which it ended, in [s]."""
    reason: str = ""
    """Reason of a Fail or GiveUp."""
    check: str = ""
    """Check that found the cause, as in `Cause.check`."""
    for_good: bool = False
    """True if a Fail used up all attempts."""
    cause: str = ""
    """Kind of cause of a Fail or GiveUp; empty in campaigns that were recorded without causes."""
    result: str | None = None
    """Result of a Success, empty for the usual one; None in campaigns that were recorded without results."""

    @property
    def primitive(self) -> str:
        """Name of the action's primitive."""
        return self.action.partition(" ")[0]


@dataclass(frozen=True)
class Trial:
    """Result of one trial of a campaign, with its seed, summary and ended actions."""

    seed: int
    status: int
    summary: Mapping[str, Any]
    actions: Sequence[ActionEnd] = ()
    """Outcomes of the actions, in the order in which they ended."""
    signalled: bool = False
    """True if an interrupt arrived, even after the last action."""
    varied: Mapping[str, float] = field(default_factory=dict)
    """Values of the numbers that vary from trial to trial, by name."""
    faults: Sequence[Mapping[str, Any]] = ()
    """Injected faults in order, each with `fault`, `at_s` and `bitten`."""

    @property
    def success(self) -> bool:
        """True if the goal was reached."""
        return self.status == 0

    @property
    def broken(self) -> bool:
        """True if handcart itself failed in the trial, or its process died."""
        return bool(self.summary["outcome"] == "Error")

    @property
    def measured(self) -> bool:
        """True if the trial has times and metrics; False if its process died."""
        return not (self.broken and not self.run_name)

    @property
    def run_name(self) -> str:
        """Name of the run's folder; empty if the trial has no folder."""
        return PurePath(str(self.summary.get("run_dir") or "")).name

    @property
    def cancelled(self) -> bool:
        """True if a person stopped the trial; its outcome is then no evidence about the task."""
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
        """Messages about outcomes that the ground truth contradicts."""
        return list(self.summary["metrics"].get("untrue", []))


def died(seed: int, reason: str) -> Trial:
    """Return a trial with outcome Error for a seed whose process crashed in every attempt."""
    nothing = {"sim_time_s": 0.0, "wall_time_s": 0.0, "actions": 0, "fails": 0, "metrics": {}}
    return Trial(seed, 5, {"outcome": "Error", "reason": reason, "seed": seed, "run_dir": "", **nothing})
