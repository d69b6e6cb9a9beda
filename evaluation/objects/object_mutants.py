"""Faulty primitives for objects, which the conformance kit has to find."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.planted.mutant import (
    Mutant,
    task_violations,
)
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.grip import open_to
from handcart.primitives.objects.hand_over import HandOver
from handcart.primitives.objects.holding.pull_watch import PullWatch
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.looking.object_look import sighting
from handcart.primitives.objects.looking.tag_readings import Located
from handcart.primitives.objects.pick import Pick
from handcart.primitives.objects.place_object import PlaceObject
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Snapshot, settle
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform

SET_ASIDE_TASK = Path(__file__).parents[2] / "tasks" / "fetch_and_carry" / "set_aside.yaml"
HAND_OVER_TASK, HAND_OVER_NUMBER = SET_ASIDE_TASK.with_name("hand_over.yaml"), 5
LOOK_FOR_NUMBER, PICK_NUMBER, PLACE_NUMBER = 2, 3, 5
"""Numbers of the actions LOOK_FOR, PICK and PLACE in the task `SET_ASIDE_TASK`."""
WRONG_HEADING_RAD = 0.2


class DropsParcel(Pick):
    """Faulty PICK that, after a failure, opens the hand and so drops the object before the arm moves back."""

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        self._held = False
        yield from open_to(robot, None)
        yield from retrace(robot, start, trace)


class TurnsSighting(LookFor):
    """Mutant of the primitive LOOK_FOR that reports a wrong heading of each object that it has found."""

    @override
    @classmethod
    def label(cls) -> str:
        return LookFor.label()

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield from super().motion(robot, model)
        objects = model.of(Objects)
        objects.sightings = tuple(
            object_sighting._replace(
                pose=Pose2(
                    object_sighting.pose.x,
                    object_sighting.pose.y,
                    object_sighting.pose.theta + WRONG_HEADING_RAD,
                )
            )
            for object_sighting in objects.sightings
        )


class PlacesBlindly(PlaceObject):
    """Faulty PLACE that puts the object down beside its goal, and claims Success without measuring."""

    @override
    def _lower(self, robot: Robot, base_T_hand: Transform) -> Periods:
        beside = base_T_hand.copy()
        beside[:2, 3] += 0.04
        yield from super()._lower(robot, beside)

    @override
    def _verify(self, robot: Robot, model: ModelView, name: str, goal: Transform) -> Periods:
        objects = model.of(Objects)
        self._stands = Located(goal, 1e-6 * np.eye(3), 0.0)
        seen = sighting(robot, model, name, self.surface, self._stands)
        objects.sightings = (*objects.without(name), seen)
        yield from settle(robot)


class LetsGoUnasked(HandOver):
    """Mutant of the primitive HAND_OVER that opens the fingers although no person pulls at the object."""

    @override
    @classmethod
    def label(cls) -> str:
        return HandOver.label()

    @override
    def _await_pull(self, robot: Robot, watch: PullWatch) -> Periods:
        yield from robot.wait(0.5)


_violations = partial(task_violations, SET_ASIDE_TASK)
NEEDED_CAPABILITIES = (Arm, Gripper, Camera, RangeSensor)
OBJECT_MUTANTS: Sequence[Mutant] = (
    Mutant(
        "DropsParcel",
        "opens the hand with the parcel before it goes back",
        partial(_violations, "PICK", PICK_NUMBER, DropsParcel),
        NEEDED_CAPABILITIES,
    ),
    Mutant(
        "TurnsSighting",
        "notes a heading that it did not measure",
        partial(_violations, "LOOK_FOR", LOOK_FOR_NUMBER, TurnsSighting),
        NEEDED_CAPABILITIES,
        by_truth=True,
    ),
    Mutant(
        "LetsGoUnasked",
        "opens the fingers although nobody pulls",
        partial(task_violations, HAND_OVER_TASK, "HAND_OVER", HAND_OVER_NUMBER, LetsGoUnasked),
        NEEDED_CAPABILITIES,
    ),
    Mutant(
        "PlacesBlindly",
        "puts the parcel beside its goal and claims the goal without a look",
        partial(_violations, "PLACE", PLACE_NUMBER, PlacesBlindly),
        NEEDED_CAPABILITIES,
        by_truth=True,
    ),
)
