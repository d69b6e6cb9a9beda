"""Motions of the arm beside walls: as far from them as the base's pose is uncertain, if there is room."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.driving.driving import map_with_cells
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import collision_model, move_straight, move_to_joints
from handcart.primitives.objects.knowledge.objects import WALL_NAME, Objects
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Box, Solid
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

from .object_site import base_T_map, held_shape, surroundings

POSE_SIGMAS = 2.0  # of the base's pose, that is kept away from walls
WALL_DISTANCE_M = 0.8  # from the base to a wall at which its heading counts
MAX_ROOM_M = 0.03


def rooms(robot: Robot, model: ModelView) -> tuple[float, ...]:
    """Return the distances, in [m], that the arm should keep from walls in addition to its usual margin, the
    preferred one first.

    The walls of boxes and shelves are known on the map. Their poses in the base frame have the error of the
    estimated pose of the base, which the additional distance covers. The last distance is 0.
    """
    surfaces = model.of(Objects).objects.surfaces.values()
    if not any(surface.walls for surface in surfaces):
        return (0.0,)
    covariance = robot.localization.covariance
    place = math.sqrt(max(0.0, float(np.linalg.eigvalsh(covariance[:2, :2])[-1])))
    turn = WALL_DISTANCE_M * math.sqrt(max(0.0, float(covariance[2, 2])))
    return (min(MAX_ROOM_M, POSE_SIGMAS * math.hypot(place, turn)), 0.0)


def walls_to_try(
    robot: Robot, model: ModelView, open_areas: Sequence[FloatArray] = ()
) -> list[tuple[Solid, ...]]:
    """Return sets of walls around the robot to plan with, in the base frame, the preferred set first; empty
    if there are no walls.

    The last set represents the map's obstacles outside the surfaces, if there are any. If the lidar has
    sensed unmapped obstacles lately, a set with these obstacles as well precedes it. Walls are higher than
    the arm reaches, because neither map nor lidar shows how high obstacles are.

    Args:
        robot: robot at the surfaces.
        model: knows the map and the surfaces.
        open_areas: outlines (n, 2) on the map, in [m], of areas without walls.
    """
    objects, to_base = model.of(Objects), base_T_map(robot)
    seen_from = _lidar_height(robot)
    mapped = objects.walls_near(model.map, robot.pose, open_areas, seen_from=seen_from)
    found = [mapped] if mapped else []
    if len(model.sensed_cells):
        sensed = objects.walls_near(map_with_cells(model), robot.pose, open_areas, seen_from=seen_from)
        if _extents(sensed) != _extents(mapped):
            found.insert(0, sensed)
    return [tuple(box.seen_from(to_base) for box in boxes) for boxes in found]


def _lidar_height(robot: Robot) -> float:
    return 0.0 if robot.lidar is None else robot.range_sensor_height


def _extents(boxes: Sequence[Box]) -> list[tuple[bytes, tuple[float, ...]]]:
    return [(box.pose.tobytes(), tuple(box.size)) for box in boxes]


def surroundings_to_try(
    robot: Robot, model: ModelView, without: str = "", open_areas: Sequence[FloatArray] = ()
) -> list[tuple[Solid, ...]]:
    """Return sets of obstacles for planning a motion of the arm, in the base frame, to be tried in this
    order.

    The first sets keep the arm farthest from walls, and also contain the walls of `walls_to_try`. The last
    set is that of `surroundings` without any additional distance, with the walls of `certain_walls`. Where
    the map shows no wall, and for a door, which is in what it shows as a wall, there are sets without walls
    instead of it.

    Args:
        robot: robot at the surfaces.
        model: knows map, surfaces and objects.
        without: name of an object that is left out.
        open_areas: outlines (n, 2) on the map, in [m], of areas without walls: those of doors.
    """
    return _with_walls(robot, model, walls_to_try(robot, model, open_areas), without, bool(open_areas))


def _with_walls(
    robot: Robot, model: ModelView, walls: Sequence[tuple[Solid, ...]], without: str, opens: bool
) -> list[tuple[Solid, ...]]:
    """Return the sets of `surroundings_to_try` with the sets of walls of `walls_to_try`; `opens`: True for a
    door.
    """
    known = [surroundings(robot, model, without, room) for room in rooms(robot, model)]
    last = [(*known[-1], *certain_walls(robot, model))] if walls and not opens else known
    return [*[(*bodies, *around) for around in walls for bodies in known], *last]


def certain_walls(robot: Robot, model: ModelView) -> tuple[Solid, ...]:
    """Return the parts of the map's obstacles that are certainly there, in the base frame.

    They end in the middle of the outermost cells. Those in which the arm is already, or the held object, are
    left out: they are low, or not where the map shows them.
    """
    objects, to_base = model.of(Objects), base_T_map(robot)
    walls = objects.walls_near(model.map, robot.pose, certain=True, seen_from=_lidar_height(robot))
    around = tuple(wall.seen_from(to_base) for wall in walls)
    here, collision = robot.arm.command(), collision_model(robot, held_shape(model), around)
    if not any(WALL_NAME in pair for pair in collision.contacts(here)):
        return around
    return tuple(wall for wall in around if not collision.touches(here, wall))


def move_with_room(
    robot: Robot,
    model: ModelView,
    joints: FloatArray,
    held: Solid | None = None,
    also_around: tuple[Solid, ...] = (),
    without: str = "",
    open_areas: Sequence[FloatArray] = (),
) -> Periods:
    """Move to joints (n,), in [rad] or [m], and keep additional distance from walls and bodies if start, goal
    and a path allow it.

    Args:
        robot: robot whose arm holds the last commanded joints.
        model: world model, with the surfaces and objects to avoid.
        joints: (n,) goal, in [rad] or [m].
        held: held object, posed in the hand frame.
        also_around: further bodies to keep clear of, in the base frame.
        without: name of an object that is left out of the surroundings.
        open_areas: outlines (n, 2) on the map, in [m], of areas without walls.

    Raises:
        Discrepancy: no free path was found, not even one that is close to walls.
    """
    *others, last = _attempts(robot, model, without, open_areas)
    for bodies, eased in others:
        around = (*bodies, *also_around)
        if not _is_worth_planning(robot, collision_model(robot, held, around), joints, eased):
            continue
        try:
            yield from move_to_joints(robot, joints, held, around, eased)
            return
        except Discrepancy as no_way:
            if no_way.cause is not causes.NO_ARM_PATH:
                raise
    bodies, eased = last
    yield from move_to_joints(robot, joints, held, (*bodies, *also_around), eased)


def _attempts(
    robot: Robot, model: ModelView, without: str, open_areas: Sequence[FloatArray]
) -> list[tuple[tuple[Solid, ...], bool]]:
    """Return the sets of obstacles to plan with, in their order, each with whether an arm that is too close
    to one may stay as close; see `surroundings_to_try`.
    """
    walls = walls_to_try(robot, model, open_areas)
    tried = _with_walls(robot, model, walls, without, bool(open_areas))
    count = len(walls) * len(rooms(robot, model))
    walled, last = tried[:count], tried[count:]
    is_certain = bool(walls) and not open_areas
    return [
        *((bodies, eased) for eased in (False, True) for bodies in walled),
        *((bodies, eased) for eased in ((False, True) if is_certain else (False,)) for bodies in last),
    ]


def _is_worth_planning(robot: Robot, collision: CollisionModel, joints: FloatArray, eased: bool) -> bool:
    """Return whether neither the arm's posture nor its goal (n,) collides.

    Args:
        robot: robot with an arm.
        collision: arm among its surroundings.
        joints: (n,) the goal, in [rad] or [m].
        eased: True for an arm that is too close to something, as far as it does not touch it.
    """
    here = robot.arm.command()
    if not eased:
        return not (collision.in_collision(here) or collision.in_collision(joints))
    if not collision.in_collision(here):
        return False  # it was tried
    collision = collision.eased_at(here)
    return not (collision.in_collision(here) or collision.in_collision(joints))


def move_straight_with_room(robot: Robot, model: ModelView, base_T_hand: Transform) -> Periods:
    """Move the empty hand in a straight line, clear of surfaces, objects and those walls that the arm does
    not touch now.

    Walls that the arm touches already are left out, as the map may show low obstacles there. It comes no
    closer to others than it is.

    Args:
        robot: robot whose arm is at its last command.
        model: world model, with the surfaces and objects to avoid.
        base_T_hand: (4, 4) final pose of the hand.

    Raises:
        Discrepancy: the arm can't move the hand there in a straight line, or would touch something.
    """
    here, known = robot.arm.command(), surroundings(robot, model)
    for walls in (*walls_to_try(robot, model), ()):
        if not collision_model(robot, None, (*known, *walls)).eased_at(here).in_collision(here):
            break
    yield from move_straight(robot, base_T_hand, around=(*known, *walls), eased=True)
