"""Motions of the arm beside walls: as far from them as the base's pose is uncertain, if there is room."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import collision_model, move_to_joints
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.numerics.arrays import FloatArray

from .object_site import base_T_map, surroundings

POSE_SIGMAS = 2.0  # of the base's pose, that is kept away from walls
WALL_DISTANCE_M = 0.8  # from the base to a wall at which its heading counts
MAX_ROOM_M = 0.03


def rooms(robot: Robot, model: ModelView) -> tuple[float, ...]:
    """Return distances to keep from walls in addition to the arm's margin, in [m], the preferred one first.

    The places of walls of boxes and shelves are known on the map only. Their places in the base frame are off
    by as much as the estimated pose of the base is.
    """
    surfaces = model.of(Objects).objects.surfaces.values()
    if not any(surface.walls for surface in surfaces):
        return (0.0,)
    covariance = robot.localization.covariance
    place = math.sqrt(max(0.0, float(np.linalg.eigvalsh(covariance[:2, :2])[-1])))
    turn = WALL_DISTANCE_M * math.sqrt(max(0.0, float(covariance[2, 2])))
    return (min(MAX_ROOM_M, POSE_SIGMAS * math.hypot(place, turn)), 0.0)


def surroundings_to_try(robot: Robot, model: ModelView, without: str = "") -> list[tuple[Solid, ...]]:
    """Return models of the surroundings to plan in, those first that keep the arm farthest from walls.

    The first models also contain walls for the map's obstacles outside the surfaces, higher than the arm
    reaches, because the map doesn't show how high obstacles are. The last one is `surroundings` without any
    additional room.

    Args:
        robot: robot at the surfaces.
        model: knows surfaces and objects.
        without: name of an object that is left out.
    """
    to_base = base_T_map(robot)
    walls = tuple(box.seen_from(to_base) for box in model.of(Objects).walls_near(robot.pose))
    known = [surroundings(robot, model, without, room) for room in rooms(robot, model)]
    return [*[(*bodies, *walls) for bodies in known if walls], *known]


def move_with_room(
    robot: Robot,
    model: ModelView,
    joints: FloatArray,
    held: Solid | None = None,
    also_around: tuple[Solid, ...] = (),
    without: str = "",
) -> Periods:
    """Move to joints (n,), in [rad] or [m], at a distance from walls if both ends and a path allow it.

    Args:
        robot: robot whose arm holds the last commanded joints.
        model: knows surfaces and objects.
        joints: goal.
        held: held object, posed in the hand frame.
        also_around: further bodies to keep clear of, in the base frame.
        without: name of an object that is left out of the surroundings.

    Raises:
        Discrepancy: no free path was found, not even without the additional distance.
    """
    here = robot.arm.command()
    *roomy, last = surroundings_to_try(robot, model, without)
    for bodies in roomy:
        around = (*bodies, *also_around)
        collision = collision_model(robot, held, around)
        if collision.in_collision(here) or collision.in_collision(joints):
            continue
        try:
            yield from move_to_joints(robot, joints, held, around)
            return
        except Discrepancy as no_way:
            if no_way.cause is not causes.NO_ARM_PATH:
                raise
    yield from move_to_joints(robot, joints, held, (*last, *also_around))
