"""CLOSE: close a door or drawer until it is at its stop."""

from __future__ import annotations

from collections.abc import Generator

from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.manipulation.doors.door_joint import DoorJoint
from handcart.robotics.manipulation.doors.path_fit import PathFit
from handcart.robotics.numerics.arrays import FloatArray

from .door_states import state_after
from .doors import Doors, DoorState
from .move_door import MoveDoor
from .pulling import Pull, PullEnding

OVERTRAVEL_M = 0.04  # beyond the believed closed place, in which the stop must be felt
CLOSED_TOLERANCE_M = 0.02  # of the handle from its closed place when the stop is felt
MIN_TRAVEL_M = 0.02


class CloseDoor(MoveDoor):
    """Take the handle of an open door or drawer, and close the door or drawer until it resists.

    The opening is known if the robot has moved this door before; otherwise it is measured by the tags. The
    resistance must begin where the door is closed. A picture in the end must show that the door stays closed.
    """

    @override
    @classmethod
    def label(cls) -> str:
        return "CLOSE"

    @override
    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the door is unknown, or known to be closed; empty otherwise."""
        state = model.of(Doors).state_of(self.door)
        if state is not None and state.opened == 0.0:
            return f"{self.door} is closed"
        return super().unmet_precondition(robot, model)

    @override
    def expected_opening(self, model: ModelView) -> float:
        state = model.of(Doors).state_of(self.door)
        return self.known(model).opened if state is None else state.opened

    @override
    def span(self, model: ModelView, joint: DoorJoint, seen: Transform) -> tuple[float, float]:
        state = model.of(Doors).state_of(self.door)
        opened = joint.opening_of(seen) if state is None else state.opened
        if joint.travel(opened) < MIN_TRAVEL_M:
            far = Measured(
                "Camera", "way of the handle", 1e3 * joint.travel(opened), 1e3 * MIN_TRAVEL_M, "mm"
            )
            raise Discrepancy(f"{self.door} isn't open", measured=far, cause=causes.MISPLACED)
        return opened, 0.0

    @override
    def move_handle(
        self, robot: Robot, model: ModelView, joint: DoorJoint, span: tuple[float, float], grip: FloatArray
    ) -> Generator[None, None, tuple[Pull, DoorState]]:
        way = joint.travel(span[0])

        def is_too_far(path: PathFit, bar: FloatArray) -> bool:
            return path.travel(bar) >= way + OVERTRAVEL_M

        pulled = yield from self.pull_along(robot, joint, span, grip, is_too_far)
        left = way - pulled.path.travel(pulled.point)
        self.found(left_mm=round(1e3 * left, 1))
        off = Measured("Arm", "handle off its closed place", 1e3 * abs(left), 1e3 * CLOSED_TOLERANCE_M, "mm")
        if pulled.ending is not PullEnding.RESISTED:
            raise Discrepancy(f"the stop of {self.door} isn't felt", measured=off, cause=causes.MISPLACED)
        if abs(left) > CLOSED_TOLERANCE_M:
            raise Discrepancy(f"something blocks {self.door}", measured=off, cause=causes.ARM_BLOCKED)
        return pulled, state_after(robot, self.door, joint, pulled, span)._replace(opened=0.0)
