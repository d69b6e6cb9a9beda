"""OPEN: open a door or drawer as far as the arm can reach."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Annotated

from pydantic import Field
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
from .pulling import MAX_PULL_N, Pull, PullEnding


class OpenDoor(MoveDoor):
    """Take the handle of a door or drawer, and open the door or drawer.

    The handle is located by tags on the front. The handle's path is measured during the motion. The hand
    moves along the arc or line that fits the path measured so far, yields to forces across it, and stops at a
    resistance. The door must then be open as far as demanded, and a picture in the end must show that it
    stays where the hand let it go.
    """

    angle_deg: Annotated[float, Field(gt=0.0, le=120.0)] = 25.0
    """Angle by which a hinged door is opened."""
    travel_mm: Annotated[float, Field(gt=0.0, le=1000.0)] = 200.0
    """Way by which a drawer is opened."""

    @override
    @classmethod
    def label(cls) -> str:
        return "OPEN"

    @override
    def expected_opening(self, model: ModelView) -> float:
        state = model.of(Doors).state_of(self.door)
        return 0.0 if state is None else state.opened

    @override
    def span(self, model: ModelView, joint: DoorJoint, seen: Transform) -> tuple[float, float]:
        begin = self.expected_opening(model)
        return begin, begin + self.wanted(joint)

    def wanted(self, joint: DoorJoint) -> float:
        """Return by how much the door has to be opened, in [rad] if `joint` is a hinge, otherwise in [m]."""
        return self.travel_mm / 1e3 if joint.hinge is None else math.radians(self.angle_deg)

    @override
    def move_handle(
        self, robot: Robot, model: ModelView, joint: DoorJoint, span: tuple[float, float], grip: FloatArray
    ) -> Generator[None, None, tuple[Pull, DoorState]]:
        way = joint.travel(self.wanted(joint))

        def is_there(path: PathFit, bar: FloatArray) -> bool:
            if joint.hinge is not None and path.is_curved:
                return abs(path.turned(bar)) >= math.radians(self.angle_deg)
            return path.travel(bar) >= way

        pulled = yield from self.pull_along(robot, joint, span, grip, is_there)
        if pulled.ending is PullEnding.RESISTED:
            far = Measured(
                "Arm", "way of the handle", 1e3 * pulled.path.travel(pulled.point), 1e3 * way, "mm"
            )
            reason = f"{self.door} doesn't open further with {MAX_PULL_N:g} N"
            raise Discrepancy(reason, measured=far, cause=causes.ARM_BLOCKED)
        return pulled, state_after(robot, self.door, joint, pulled, span)
