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
    """Detection of changes to the robot between two actions, for example by a person who moved it.

    The robot's state before an action is compared with its state after the previous action. If only the base
    was moved, and is at its pose of an earlier situation, that situation holds again, provided that its facts
    other than `base` are those of the present one. After any other change it is unknown what else was changed
    (row N9 of faults.md).
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
        """Take the snapshot before an action as the robot's last known state, if no state is known yet.

        Args:
            situation: situation in which the action starts.
            at: the snapshot; None if it could not be read.
        """
        if self._stood is None:
            self.stands(at)
            self.arrived(situation)

    def stands(self, at: Snapshot | None) -> None:
        """Keep the snapshot of the robot after an action, for comparison before the next action.

        Args:
            at: the snapshot; None if it could not be read, so that the next action starts uncompared.
        """
        self._stood = at

    def arrived(self, situation: str) -> None:
        """Record that a situation holds now, with the state of the robot that was measured last."""
        self._seen.pop(situation, None)
        if self._stood is not None:
            self._seen[situation] = self._stood

    def changed(self, now: Snapshot) -> Snapshot | None:
        """Return the snapshot taken after the last action if the robot has moved since then.

        The result is None if the robot has not moved, or if no action has ended yet.
        """
        if self._stood is None:
            return None
        return self._stood if self._moved(self._stood, now) else None

    def situation(self, here: str, stood: Snapshot, now: Snapshot) -> str | None:
        """Return the earlier situation that holds again after the robot was moved; None if it is uncertain.

        Only the base may have moved, and has to be at its pose of the returned situation. That situation must
        have the same facts as `here`, except for the fact `base`. If several situations fit, the latest is
        returned.

        Args:
            here: situation before the robot was moved.
            stood: snapshot of the robot in `here`.
            now: snapshot of the robot now.
        """
        kinds = {residual.kind for residual in self._moved(stood, now).all}
        if not kinds <= _BASE or not self._sure(now):
            return None
        facts = self._facts(here)
        alike = (name for name in reversed(self._seen) if self._facts(name) == facts)
        return next((name for name in alike if not self._moved(self._seen[name], now)), None)

    def unlocated_situation(self, here: str) -> str | None:
        """Return a situation in which LOCATE can find the robot's pose, after the base was moved.

        Except for the fact `base`, its facts are those of the situation `here`. The result is None if the
        network has no such situation.
        """
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
