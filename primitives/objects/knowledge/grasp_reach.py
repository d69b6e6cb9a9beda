"""Headings of an object in which the arm can grip it from a place of the base."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.primitives.knowledge.place import Place
from handcart.primitives.objects.files.object_kind import KnownObject, ObjectKind
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse, raised
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import ARM_MARGIN_M, CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

LIFT_M = 0.08  # over a grasp that must be reached too
IK_RESTARTS = 4
HEADING_COUNT = 6  # headings over half a turn: turned by half a turn, a grasp is the same
BELIEVED_SIGMAS = 2.0  # of a heading, within which it is expected
HALF_TURN_RAD = math.pi


class GraspWork(NamedTuple):
    """An object that is to be gripped on a surface."""

    name: str
    kind: ObjectKind
    x_m: float
    """Believed x on the map."""
    y_m: float
    headings: tuple[float, ...]
    """Headings on the map that the object may have, in [rad]."""


def grasp_work(file: ObjectsFile, surface: str) -> list[GraspWork]:
    """Return the objects that are believed to be at places on a surface."""
    return [
        GraspWork(name, kind, known.x_m, known.y_m, tuple(_headings(known, kind)))
        for name, known in file.objects.items()
        if known.on == surface and known.x_m is not None and known.y_m is not None
        for kind in (file.kind_of(name),)
    ]


def _headings(known: KnownObject, kind: ObjectKind) -> Iterator[float]:
    """Yield the headings on the map, in [rad], that an object may have; one of a round object."""
    believed, spread = math.radians(known.heading_deg), BELIEVED_SIGMAS * math.radians(known.sigma_deg)
    if kind.is_round:
        spread = 0.0
    step = HALF_TURN_RAD / HEADING_COUNT
    count = min(HEADING_COUNT // 2, math.ceil(spread / step))
    yield from (believed + number * step for number in range(-count, count + (2 * count < HEADING_COUNT)))


class GraspReach:
    """The arm of a robot at a place of the base, before a surface."""

    def __init__(self, robot: RobotFile, arm: ArmModel, surface: ObjectSurface, base: Pose2) -> None:
        """Pose the surface in the base frame.

        Args:
            robot: robot with an arm and a gripper.
            arm: kinematics of its arm.
            surface: the surface.
            base: map_T_base of the base.
        """
        self._robot, self._arm, self._height = robot, arm, surface.height_m
        self._base_T_map = inverse(base.lift())
        boxes = tuple(box.seen_from(self._base_T_map) for box in surface.boxes("surface"))
        self._collision = CollisionModel(arm, boxes, margin=ARM_MARGIN_M)
        self._home = np.array(robot.posture("home"))

    def missed(self, work: GraspWork) -> list[float]:
        """Return the headings on the map, in [rad], in which no grasp of an object is free and within reach.

        The result is empty for a kind that the fingers can't grip at all.
        """
        return [heading for heading in work.headings if self._grips(work, heading) is False]

    def _grips(self, work: GraspWork, heading: float) -> bool | None:
        """Return whether a grasp is free; None if there are no grasps."""
        foot = Pose2(work.x_m, work.y_m, heading).lift(self._height)
        grips = None
        for hand in self._hands(work.kind, np.asarray(self._base_T_map @ foot)):
            grips = self._is_free(hand) and self._is_free(raised(hand, LIFT_M))
            if grips:
                return True
        return grips

    def _hands(self, kind: ObjectKind, base_T_object: Transform) -> Iterator[Transform]:
        """Yield base_T_hand (4, 4) of the grasps of an object with a pose base_T_object (4, 4)."""
        gripper = self._robot.gripper
        opening = gripper.opening_mm / 1e3 if gripper is not None else 0.0
        for grasp in kind.grasps_within(opening, self._robot.finger_shape.tip, base_T_object):
            yield np.asarray(base_T_object @ grasp.box_T_hand)

    def _is_free(self, base_T_hand: Transform) -> bool:
        joints: FloatArray | None = self._arm.inverse(base_T_hand, self._home, restarts=IK_RESTARTS)
        return joints is not None and not self._collision.in_collision(joints)


def missed_headings(
    robot: RobotFile, arm: ArmModel, surface: ObjectSurface, base: Pose2, work: Sequence[GraspWork]
) -> int | None:
    """Return the number of headings in which objects can't be gripped from a place of the base.

    The result is None if an object can be gripped in none of the headings that it may have.

    Args:
        robot: robot with an arm and a gripper.
        arm: kinematics of its arm.
        surface: surface with the objects.
        base: map_T_base of the place.
        work: the objects.
    """
    reach, count = GraspReach(robot, arm, surface, base), 0
    for item in work:
        missed = len(reach.missed(item))
        if missed == len(item.headings):
            return None
        count += missed
    return count


def missed_words(
    robot: RobotFile, file: ObjectsFile, places: Mapping[str, Place]
) -> Iterator[tuple[str, str]]:
    """Yield the name of each object that can't be gripped in some headings that it may have, with a warning.

    Args:
        robot: robot with an arm and a gripper.
        file: objects and surfaces.
        places: places of the base, by surface.
    """
    arm = robot.described_arm
    for name, place in places.items():
        reach = GraspReach(robot, arm, file.surfaces[name], place.pose)
        for work in grasp_work(file, name):
            if missed := reach.missed(work):
                yield (
                    work.name,
                    (
                        f"at the place before {name!r} no grasp of {work.name} is free and within reach in"
                        f" {len(missed)} of {len(work.headings)} headings that it may have"
                        f" ({_degrees(missed)}): PICK would fail; possible: another place, a lower or nearer"
                        " object, a smaller `sigma_deg`"
                    ),
                )


def _degrees(headings: Sequence[float]) -> str:
    """Return headings on the map, in [rad], as words in whole degrees."""
    degrees = sorted(round(math.degrees(math.remainder(item, math.tau))) for item in headings)
    return ", ".join(f"{item} deg" for item in degrees)
