"""A whole action network as one behaviour in somebody's py_trees tree."""

from __future__ import annotations

from collections.abc import Callable, Generator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from handcart.backends.robot.robot import Robot

from .coordinator import Coordinator
from .run_end import RunEnd
from .supervision import Request


class NetworkBehaviour(Behaviour):
    """Runs a network, one period a tick; who owns the tree steps the robot after each tick.

    SUCCESS when the goal is reached, FAILURE when no way is left (the robot then is restored). Interrupted
    by the tree it only stops; its next tick first brings back what the interrupted action did, then goes on.
    Interrupted between two actions, or while one waits for permission, there is nothing to bring back.
    GiveUp is FAILURE too, and stays so whatever the tree tries: `end` tells it apart.
    """

    def __init__(self, name: str, robot: Robot, make: Callable[[], Coordinator]) -> None:
        """A behaviour that hasn't started.

        Args:
            name: in the tree.
            robot: the one that the coordinators drive.
            make: gives a coordinator for each new run.
        """
        super().__init__(name)
        self.end: RunEnd | None = None
        """How the last run ended."""
        self._robot = robot
        self._make = make
        self._coordinator: Coordinator | None = None
        self._run: Generator[None, None, RunEnd] | None = None

    @property
    def latched(self) -> bool:
        """Whether a person has to help before anything moves again."""
        return self.end is not None and self.end.outcome == "GiveUp"

    def acknowledge(self) -> None:
        """A person has seen to what made the last run give up: the next tick starts a new one."""
        self.end = None

    def initialise(self) -> None:
        """Called by the tree when it turns to this behaviour."""
        if self.latched:
            return
        if self._coordinator is not None:  # interrupted before
            if (number := self._coordinator.acting) is not None:
                self._coordinator.request(Request.RESTORE, number)
            return
        self._coordinator = self._make()
        self._run = self._coordinator.run()

    def update(self) -> Status:
        """One period."""
        if self._run is None or self._coordinator is None:
            return Status.FAILURE
        try:
            next(self._run)
        except StopIteration as end:
            self.end = end.value
            self._run = self._coordinator = None
            return self._ended(end.value)
        self.feedback_message = f"{self._coordinator.situation}, {self._coordinator.life.state.value}"
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Called by the tree when this behaviour ends or is interrupted."""
        if new_status is Status.INVALID and self._run is not None:
            self._robot.stop()

    def shutdown(self) -> None:
        """Called when the tree is taken down."""
        if self._run is not None:
            self._run.close()
            self._robot.stop()

    def _ended(self, end: RunEnd) -> Status:
        self.feedback_message = end.reason or end.outcome
        return Status.SUCCESS if end.outcome == "Success" else Status.FAILURE
