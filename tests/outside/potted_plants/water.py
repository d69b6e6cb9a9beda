"""WATER: give a plant what it needs."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from handcart import ActionPrimitive, Arm, Discrepancy, Gripper, NeedsPerson
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.place_name import Names
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import move_straight, move_to_pose
from handcart.primitives.motions.from_above import gripped, gripping, pointing_down
from handcart.primitives.motions.grip import close, holds, open_to, width_off
from handcart.primitives.outcomes.discrepancy import Measured
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box

from .knowledge import Plant, Plants, PlantsFile

LIFT, OVER = transform((0.0, 0.0, 0.1)), 0.08  # above its place; of the rim above the pot in [m]
TILTS = (0.0, 25.0, 40.0, 70.0)  # [deg], about the axis of the fingers
SCALE, STEADY, GRAVITY, TRIES = 30, 25.0, 9.81, 12  # readings for half a weighing; [g]; [m/s²]; pourings
CAREFUL, ENOUGH, EMPTY = 150.0, 10.0, 30.0  # [ml/s] assumed flow; [ml] missing; [g] left
ACROSS = pointing_down(Pose2(0.0, 0.0, math.pi / 2), 0.0)


class Water(ActionPrimitive):
    """Take the can from the robot's own table, pour until the hand weighs enough less, and put it back."""

    plant: Annotated[str, Field(min_length=1), Names("plants")]
    """Which."""

    needs: ClassVar = (Arm, Gripper)
    reads: ClassVar = ("garden",)
    writes: ClassVar = ("watered",)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        garden = self._garden(model)
        grip, held = _grip(robot, garden)
        yield from move_to_pose(robot, LIFT @ grip)
        yield from open_to(robot)
        yield from move_straight(robot, grip)
        yield from self.intend("the fingers close on the can")
        yield from close(robot)
        wide = garden.can.size_m[0], 0.005
        if not holds(robot, *wide):
            raise Discrepancy("no can in the hand", measured=width_off(robot, *wide, "the can's width"))
        yield from move_straight(robot, LIFT @ grip, held)
        yield from self._pour(robot, model, garden.plants[self.plant], held)
        yield from _put_back(robot, garden)

    def _pour(self, robot: Robot, model: ModelView, plant: Plant, held: Box) -> Periods:
        poses = _over(robot, plant, held)
        yield from move_to_pose(robot, poses[0], held, _pots(robot, self._garden(model)))
        full, given, known = (yield from _weigh(robot)), 0.0, model.of(Plants)
        if full < EMPTY:
            raise Discrepancy("the can is empty", measured=Measured("Arm", "water", full, EMPTY, "g"))
        yield from self.intend("the can is tilted over the pot")
        self.point_of_no_return("water is poured")
        for _ in range(TRIES):
            for pose in poses[1:]:
                yield from move_straight(robot, pose, held)
            yield from robot.wait((plant.needs_ml - given) / CAREFUL)
            for pose in poses[-2::-1]:
                yield from move_straight(robot, pose, held)
            given = full - (yield from _weigh(robot))
            known.watered = {**known.watered, self.plant: round(given, 1)}
            self.found(given_ml=round(given, 1))
            if full - given < EMPTY:
                break  # it may have gone elsewhere
            if plant.needs_ml - given < ENOUGH:
                return
        raise NeedsPerson(f"the can lost {given:.0f} ml; {self.plant} needs {plant.needs_ml:.0f}")

    def finish(self, robot: Robot, model: ModelView) -> Periods:
        """After water was poured: the can goes back to its place."""
        yield from _put_back(robot, self._garden(model))

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        return MeantContact("hand", "vessel *"), MeantContact("held", "tray")

    def _garden(self, model: ModelView) -> PlantsFile:
        if garden := model.of(Plants).garden:
            return garden
        raise Discrepancy("the task names no plants", permanent=True)


def _grip(robot: Robot, garden: PlantsFile) -> tuple[Transform, Box]:
    """base_T_hand (4, 4) about the can in its place, and the can in the hand's frame."""
    size = garden.can.size_m
    return gripping(robot, size, garden.can.pose), gripped(robot, size)


def _over(robot: Robot, plant: Plant, can: Box) -> list[Transform]:
    """base_T_hand (4, 4) for each of `TILTS`: the can turns about its rim, which stays over the pot."""
    rim = np.array([can.pose[0, 3] - can.size[0] / 2, 0.0, can.size[2] / 2, 1.0])
    x, y = robot.pose.inverse().apply(np.array([[plant.x_m, plant.y_m]]))[0]
    place = np.array([x, y, plant.height_m + plant.size_m[2] + OVER])
    turned = [ACROSS @ transform(rpy=(0.0, math.radians(tilt), 0.0)) for tilt in TILTS]
    return [transform(tuple(place - (item @ rim)[:3])) @ item for item in turned]


def _pots(robot: Robot, garden: PlantsFile) -> tuple[Box, ...]:
    """Return the obstacles of the arm, in the base frame."""
    base_T_map, pots = robot.pose.inverse().lift(), garden.plants.values()
    return tuple(pot.body(pot.size_m, "a pot").seen_from(base_T_map) for pot in pots)


def _put_back(robot: Robot, garden: PlantsFile) -> Periods:
    grip, held = _grip(robot, garden)
    yield from move_to_pose(robot, LIFT @ grip, held, _pots(robot, garden))
    yield from move_straight(robot, grip, held)
    yield from open_to(robot)
    yield from move_straight(robot, LIFT @ grip)


def _weigh(robot: Robot) -> Generator[None, None, float]:
    """The water in the can, in [g], once that is steady: the can alone weighs 50."""
    down, felt = robot.base_T("hand")[:3, :3].T @ (0.0, 0.0, -1.0), np.full(2, np.inf)
    while not abs(felt[0] - felt[1]) < STEADY:
        yield from robot.wait(0.5)
        for half in range(2):
            felt[half] = 0.0
            for _ in range(SCALE):
                yield
                felt[half] += 1e3 / GRAVITY * float(robot.arm.hand_force() @ down) / SCALE
    return float(felt.mean()) - 50.0
