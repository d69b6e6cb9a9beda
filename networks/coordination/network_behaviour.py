"""A complete action network as one behaviour of a py_trees tree."""

from __future__ import annotations

from collections.abc import Callable, Generator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from handcart.backends.robot.robot import Robot
from handcart.networks.events.run_end import RunEnd

from .coordinator import Coordinator
from .supervision import Request


class NetworkBehaviour(Behaviour):
    """Behaviour that runs a network, one period for each tick.

    The tree's owner steps the robot after each tick. The status is SUCCESS when the goal is reached, and
    FAILURE when no route is left (the robot then is restored). If the tree interrupts the behaviour, the
    robot only stops. If an action was running, the next tick first restores what that action changed; then
    the run continues, and none of the action's attempts is used up. A GiveUp is FAILURE too, and every later
    tick returns FAILURE until `acknowledge` is called; `end` distinguishes it from a missing route.
    """

    def __init__(self, name: str, robot: Robot, make: Callable[[], Coordinator]) -> None:
        """Create a behaviour that has not started.

        Args:
            name: in the tree.
            robot: the robot that the coordinators drive.
            make: returns a coordinator for each new run.
        """
        super().__init__(name)
        self.end: RunEnd | None = None
        """End of the last run."""
        self._robot = robot
        self._make = make
        self._coordinator: Coordinator | None = None
        self._run: Generator[None, None, RunEnd] | None = None

    @property
    def latched(self) -> bool:
        """True if the last run ended in GiveUp: a person has to help, and to call `acknowledge`, before
        anything moves.
        """
        return self.end is not None and self.end.outcome == "GiveUp"

    def acknowledge(self) -> None:
        """Acknowledge the last run's GiveUp: the next tick starts a new run."""
        self.end = None

    def initialise(self) -> None:
        """Start or continue the run when the behaviour tree begins to tick this behaviour."""
        if self.latched:
            return
        if self._coordinator is not None:  # interrupted before
            if (number := self._coordinator.acting) is not None:
                self._coordinator.request(Request.PREEMPT, number)
            return
        self._coordinator = self._make()
        self._run = self._coordinator.run()

    def update(self) -> Status:
        """Run one control period of the network's task, and return the status of this behaviour."""
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
        """Stop the robot if the behaviour tree interrupts this behaviour (`new_status` is INVALID)."""
        if new_status is Status.INVALID and self._run is not None:
            self._robot.stop()

    def shutdown(self) -> None:
        """Stop the run and the robot when the behaviour tree that contains this behaviour is shut down."""
        if self._run is not None:
            self._run.close()
            self._run = self._coordinator = None
            self._robot.stop()

    def _ended(self, end: RunEnd) -> Status:
        self.feedback_message = end.reason or end.outcome
        return Status.SUCCESS if end.outcome == "Success" else Status.FAILURE
