"""Detection of changes of the world between two actions."""

from __future__ import annotations

from collections.abc import Mapping

from handcart.backends.robot.robot import Robot
from handcart.networks.graph.network import LOCATE_NAME, ActionNetwork
from handcart.primitives.outcomes.residual import ResidualKind, Residuals
from handcart.primitives.restoring.snapshot import Snapshot, residuals

_BASE = frozenset({ResidualKind.BASE_POSITION, ResidualKind.BASE_HEADING})
"""Kinds of residuals of a base that was pushed, with nothing else changed."""


class WorldWatch:
    """Comparison of the robot's state before an action with that after the last one (row N9).

    An earlier situation of the run may hold again: one with the same facts except for `base`, whose base
    pose was measured as it is now. After any other change no sensor can show how much more was changed.
    """

    def __init__(self, robot: Robot, network: ActionNetwork, seen: Mapping[str, Snapshot]) -> None:
        """Create a watch over a run.

        Args:
            robot: the robot.
            network: the network of the run.
            seen: snapshots of the robot in earlier situations of the run, the present one last.
        """
        self._robot, self._network = robot, network
        self._seen = dict(seen)
        self._stood = next(reversed(self._seen.values()), None)

    def begins(self, situation: str, at: Snapshot | None) -> None:
        """Take the snapshot before an action as the last known state if there is none yet.

        Args:
            situation: situation in which the action begins.
            at: snapshot just before it; None if it could not be read.
        """
        if self._stood is None:
            self.stands(at)
            self.arrived(situation)

    def stands(self, at: Snapshot | None) -> None:
        """Keep the snapshot taken after an action; None if it could not be read, so that nothing can be
        compared.
        """
        self._stood = at

    def arrived(self, situation: str) -> None:
        """Record that a situation holds at the last snapshot."""
        self._seen.pop(situation, None)
        if self._stood is not None:
            self._seen[situation] = self._stood

    def changed(self, now: Snapshot) -> Snapshot | None:
        """Return the last snapshot if the robot has moved since; None if it has not, or without one."""
        if self._stood is None:
            return None
        return self._stood if self._moved(self._stood, now) else None

    def situation(self, here: str, stood: Snapshot, now: Snapshot) -> str | None:
        """Return the situation that holds now; None if that cannot be decided.

        It is the latest earlier situation with the facts of `here`, the fact `base` excepted, if only the
        base has moved between the
        snapshots `stood` and `now`, and has moved to its pose in that situation.
        """
        kinds = {residual.kind for residual in self._moved(stood, now).all}
        if not kinds <= _BASE or not self._sure(now):
            return None
        facts = self._facts(here)
        alike = (name for name in reversed(self._seen) if self._facts(name) == facts)
        return next((name for name in alike if not self._moved(self._seen[name], now)), None)

    def unlocated_situation(self, here: str) -> str | None:
        """Return a situation from which LOCATE starts, with the facts of `here` except the base; or None."""
        facts = self._facts(here)
        for action in self._network.actions:
            is_finder = action.binding is not None and action.binding.label == LOCATE_NAME
            if is_finder and self._facts(action.source) == facts:
                return action.source
        return None

    def _sure(self, now: Snapshot) -> bool:
        return not residuals(now, now, self._robot.spec).beyond

    def _moved(self, stood: Snapshot, now: Snapshot) -> Residuals:
        return residuals(stood, now, self._robot.spec).moved

    def _facts(self, name: str) -> Mapping[str, object]:
        facts = self._network.situations[name].facts
        return {key: value for key, value in facts.items() if key != "base"}
