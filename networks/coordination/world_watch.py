"""Noticing that somebody changed the world between two actions."""

from __future__ import annotations

from collections.abc import Mapping

from handcart.backends.robot.robot import Robot
from handcart.networks.graph.network import ActionNetwork
from handcart.primitives.restoring.snapshot import Snapshot, limits, moved, residuals

_BASE = frozenset({"base_mm", "base_deg"})
"""Residuals of a base that was pushed, and of nothing else."""


class WorldWatch:
    """Compares how the robot stands before an action with how it stood after the last one (row N9).

    A situation that the run was in before may hold again: one with the same facts but for `base`, where the
    base stands as it was measured then. Whatever else is found changed, no sensor tells what else was.
    """

    def __init__(self, robot: Robot, network: ActionNetwork, seen: Mapping[str, Snapshot]) -> None:
        """`seen`: how the robot stood in situations that the run was in; the last one is where it is."""
        self._robot, self._network = robot, network
        self._seen = dict(seen)
        self._stood = next(reversed(self._seen.values()), None)

    def begins(self, situation: str, at: Snapshot | None) -> None:
        """An action begins there: of the first one, nothing was measured before."""
        if self._stood is None:
            self.stands(at)
            self.arrived(situation)

    def stands(self, at: Snapshot | None) -> None:
        """The robot stands like this now; None: it can't be read, so nothing can be compared."""
        self._stood = at

    def arrived(self, situation: str) -> None:
        """That situation holds where the robot stands."""
        self._seen.pop(situation, None)
        if self._stood is not None:
            self._seen[situation] = self._stood

    def changed(self, now: Snapshot) -> Snapshot | None:
        """How the robot stood, where it stands otherwise now; None where nothing has changed."""
        if self._stood is None:
            return None
        return self._stood if moved(self._robot, self._stood, now) else None

    def situation(self, here: str, stood: Snapshot, now: Snapshot) -> str | None:
        """The situation that holds now, where that can be told; `here` is the one that did."""
        if not moved(self._robot, stood, now).keys() <= _BASE or not self._sure(now):
            return None
        facts = self._facts(here)
        alike = (name for name in reversed(self._seen) if self._facts(name) == facts)
        return next((name for name in alike if not moved(self._robot, self._seen[name], now)), None)

    def _sure(self, now: Snapshot) -> bool:
        found = residuals(now, now)
        allowed = limits(self._robot, found)
        return all(size <= allowed[name] for name, size in found.items())

    def _facts(self, name: str) -> Mapping[str, object]:
        facts = self._network.situations[name].facts
        return {key: value for key, value in facts.items() if key != "base"}
