"""Places of the base for work on a surface: within reach, in sight, clear of what the map shows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.robot.mounted_camera import known_camera, mount_of
from handcart.primitives.knowledge.place import Place
from handcart.primitives.objects.files.object_kind import KnownObject, ObjectKind
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.files.surface import WALL_M, ObjectSurface
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, apply, inverse, raised, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.grasping.box_grasps import BITE_M, MAX_BITE_SHARE
from handcart.robotics.manipulation.grasping.camera_poses import camera_poses, from_direction
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.manipulation.placement.standing_places import OpenFloor
from handcart.robotics.navigation.maps.clearances import Clearances
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.ways import ROOM_AT_GOAL
from handcart.robotics.numerics.arrays import FloatArray

from .aimed_view import aimed_views
from .grasp_reach import grasp_work, missed_headings

EDGE_GAPS_M = (0.04, 0.10)  # between the base's outline and the edge of the surface
BEFORE_WALL_M = WALL_M + 0.02  # further away from a side with a wall
ALONG_STEP_M = 0.1  # between candidates along an edge
INWARD_M = 0.15  # from the edge to where work is expected, if nothing is said
LIFT_M = 0.10  # over a grasp that must be reached too
HIGHEST_TIP_M = 0.04  # of the finger tips over the surface in a grasp
VIEW_DISTANCE_M = 0.35
MIN_MOVED_M, MIN_TURNED_RAD = 0.02, math.radians(1.0)  # as a base may be off its place
MOVED_BACK_M = (0.0, 0.02, 0.04, 0.06)  # from a place that moved with its surface: cells are coarse
MAX_CANDIDATES = 40
MAX_COMPARED = 5  # places from which everything is reached, that are compared by headings
IK_RESTARTS = 4
PITCHES_RAD = tuple(math.radians(value) for value in (90.0, 55.0, 30.0))
"""Pitch angles of a hand over a surface, pointing down or slanting ahead."""
TURNS_RAD = tuple(math.radians(value) for value in (0.0, 90.0, 180.0, -90.0))
SIDES = ("-x", "-y", "+x", "+y")
"""Sides of a surface that the base may face, one for each angle of `TURNS_RAD` relative to the surface."""
HEADINGS_RAD = tuple(math.radians(value) for value in (0.0, 45.0, 90.0, 135.0))
"""Headings of a hand that comes from above; a heading turned by half a turn grips in the same way."""


class NoStandingPlace(Exception):
    """Error, because the base has no place to work on a surface; the message gives the reason."""


def standing_place(
    robot: RobotFile, grid: GridMap, file: ObjectsFile, name: str, places: Sequence[Place]
) -> Place:
    """Return the place of the base from which the arm reaches, and the camera sees, all work on a surface.

    At the place the base faces one side of the surface. Places near the work are tried first. From the place,
    each object can be gripped in some heading that it may have. Some such places are compared: the best one
    lets the objects be gripped in the most headings, and then lets the hand reach down in the most headings.

    Args:
        robot: robot with an arm.
        grid: the map.
        file: surfaces, and the objects on them.
        name: name of the surface.
        places: known places of the base; a route must lead from one of them.

    Raises:
        NoStandingPlace: no floor next to the surface is free, or the arm reaches all work from no place.
    """
    surface, arm = file.surfaces[name], robot.described_arm
    work = _work(file, name)
    free = _free(robot, grid, list(_around(robot, surface, work)), places)
    if not free:
        radius = robot.footprint_radius_m + ROOM_AT_GOAL
        raise NoStandingPlace(
            f"the base has no room beside the surface {name!r}: needed: {radius:.2f} m of free floor around"
            " its middle, reached from a place"
        )
    missing, tall, gripped = len(work) + 1, _tip_heights(file, name), grasp_work(file, name)
    for tips in (np.full(len(tall), HIGHEST_TIP_M), tall):
        fit: list[tuple[tuple[int, int], Pose2]] = []
        for base in free[:MAX_CANDIDATES]:
            points = work if len(work) else _ahead(base, robot, surface)
            spots = np.column_stack([points, surface.height_m + tips[: len(points)]])
            unreached = sum(not _reaches(robot, arm, surface, base, spot) for spot in spots)
            missed = missed_headings(robot, arm, surface, base, gripped) if unreached == 0 else 0
            missing = min(missing, unreached + (missed is None))
            if unreached == 0 and missed is not None:
                straight = sum(_headings_missed(robot, arm, surface, base, spot) for spot in spots)
                fit.append(((missed, straight), base))
                if fit[-1][0] == (0, 0) or len(fit) >= MAX_COMPARED:
                    break
        if fit:
            best = min(fit, key=lambda pair: pair[0])[1]
            return _place_at(best)
        if (tall <= HIGHEST_TIP_M).all():
            break
    count = max(1, len(work))
    raise NoStandingPlace(
        f"the arm doesn't reach all work on the surface {name!r} from one place: {missing} of {count} points"
        " (objects and spots) are out of reach; allowed: points within reach, or a `place` by hand"
    )


def has_moved(before: ObjectSurface, now: ObjectSurface) -> bool:
    """Return whether a surface has moved so far that the place of the base in front of it has to move too.

    Args:
        before: the surface at its earlier pose; if it is marked as fixed, the answer is False.
        now: the surface at its present pose.
    """
    if before.fixed:
        return False
    off, turned = before.floor.distance(now.floor), before.floor.turn(now.floor)
    return off > MIN_MOVED_M or turned > MIN_TURNED_RAD


def followed_place(
    robot: RobotFile,
    grid: GridMap,
    before: ObjectSurface,
    now: ObjectSurface,
    stand: Place,
    places: Sequence[Place],
) -> Place:
    """Return the place of the base for a surface that was measured elsewhere than its file says.

    It is the place `stand` moved with the surface, or one of the distances `MOVED_BACK_M` further from the
    surface. If the base has no room there, `stand` is returned.

    Args:
        robot: robot with an arm.
        grid: the map with the surface where it is now, and with what was sensed.
        before: the surface where its file says.
        now: the surface where it is.
        stand: place of the base in front of the surface `before`, as computed from the file.
        places: other known places; a route must lead from one of them.
    """
    if not has_moved(before, now):
        return stand
    moved = now.floor.compose(stand.pose.relative_to(before.floor))
    backs = [moved.compose(Pose2(-away, 0.0, 0.0)) for away in MOVED_BACK_M]
    free = _free(robot, grid, backs, places)
    return _place_at(free[0]) if free else stand


def _place_at(base: Pose2) -> Place:
    return Place(x_m=base.x, y_m=base.y, heading_deg=math.degrees(base.theta))


def _work(file: ObjectsFile, name: str) -> FloatArray:
    """Return the points (n, 2) on the map, in [m], where objects of a surface are believed to be or are put
    down.
    """
    spots = [(spot.x_m, spot.y_m) for spot in file.surfaces[name].spots.values()]
    believed = [
        (object_.x_m, object_.y_m)
        for object_ in file.objects.values()
        if object_.on == name and object_.x_m is not None and object_.y_m is not None
    ]
    return np.array([*believed, *spots]).reshape(-1, 2)


def _tip_heights(file: ObjectsFile, name: str) -> FloatArray:
    """Return the heights (n,) of the finger tips over the surface at the points of `_work`, in [m].

    They are those of a grasp from above; at a spot, of the lowest kind that may be there. With only
    low objects they are `HIGHEST_TIP_M`; there is one height if nothing is said.
    """
    surface = file.surfaces[name]
    heights = {label: _tips_on(kind) for label, kind in file.kinds.items() if surface.allows(label)}
    least = min(heights.values(), default=HIGHEST_TIP_M)
    own = [
        _tips_on(file.kind_of(label))
        for label, object_ in file.objects.items()
        if _is_believed(object_, name)
    ]
    return np.array([*own, *[least] * len(surface.spots)] or [least])


def _tips_on(kind: ObjectKind) -> float:
    height = kind.size[2]
    return max(HIGHEST_TIP_M, height - min(BITE_M, MAX_BITE_SHARE * height))


def _is_believed(known: KnownObject, name: str) -> bool:
    """Return whether the file gives an object a believed place on this surface."""
    return known.on == name and known.x_m is not None and known.y_m is not None


def _around(robot: RobotFile, surface: ObjectSurface, work: FloatArray) -> Iterator[Pose2]:
    """Yield map_T_base of bases that face a side of the surface, those nearest to the work first.

    Args:
        robot: the robot's file.
        surface: the surface.
        work: (n, 2) points of the work on the map, in [m].
    """
    poses = []
    for turn, side_name in zip(TURNS_RAD, SIDES, strict=True):
        side = Pose2(0.0, 0.0, turn)
        lengthwise = abs(math.cos(turn)) > 0.5
        depth, width = surface.size_m if lengthwise else surface.size_m[::-1]
        before_wall = BEFORE_WALL_M if side_name in surface.walls else 0.0
        count = max(1, round(width / ALONG_STEP_M))
        for gap in EDGE_GAPS_M:
            for along in np.linspace(-width / 2, width / 2, 2 * (count // 2) + 1).tolist():
                away = depth / 2 + robot.footprint_radius_m + gap + before_wall
                poses.append(surface.floor.compose(side).compose(Pose2(-away, along, 0.0)))
    middle = work if len(work) else np.array([[surface.x_m, surface.y_m]])
    poses.sort(key=lambda pose: float(np.hypot(middle[:, 0] - pose.x, middle[:, 1] - pose.y).max()))
    yield from poses


def _free(robot: RobotFile, grid: GridMap, poses: Sequence[Pose2], places: Sequence[Place]) -> list[Pose2]:
    """Return the poses with room on the map and, if places are known, with a route from one of them."""
    radius = robot.footprint_radius_m + ROOM_AT_GOAL
    bases = np.array([tuple(pose2) for pose2 in poses])
    clear = Clearances(grid, grid.blocked, walled=True).at(bases[:, :2]) >= radius
    if places:
        floor = OpenFloor(grid, radius)
        reached = np.any([floor.reached_from((place.x_m, place.y_m)) for place in places], axis=0)
        if reached.any():
            clear &= floor.leads_to(bases, reached)
    return [pose for pose, fits in zip(poses, clear, strict=True) if fits]


def _ahead(base: Pose2, robot: RobotFile, surface: ObjectSurface) -> FloatArray:
    """Return the point (1, 2) of the surface straight ahead of the base, on the map in [m]."""
    for away in np.arange(robot.footprint_radius_m, robot.footprint_radius_m + 1.0, 0.01).tolist():
        point = base.apply(np.array([[away + INWARD_M, 0.0]]))
        if surface.margin(*point[0].tolist()) >= min(INWARD_M, min(surface.size_m) / 2) - 0.01:
            return point
    return np.array([[surface.x_m, surface.y_m]])


def _reaches(robot: RobotFile, arm: ArmModel, surface: ObjectSurface, base: Pose2, point: FloatArray) -> bool:
    """Return whether the finger tips grip and lift at a point (3,) on the map, in [m], and the camera looks
    there.
    """
    base_T_map = inverse(base.lift())
    tips = apply(base_T_map, point[None])[0]
    spot = tips - (0.0, 0.0, float(point[2]) - surface.height_m)
    boxes = tuple(box.seen_from(base_T_map) for box in surface.boxes("surface"))
    collision = CollisionModel(arm, boxes)
    home = np.array(robot.posture("home"))
    grips = any(
        _is_free(arm, collision, hand, home) and _is_free(arm, collision, raised(hand, LIFT_M), home)
        for hand in _hands(robot, tips)
    )
    if not grips:
        return False
    if robot.hand_camera is None:
        return _sees(robot, arm, collision, spot, home)
    return any(_is_free(arm, collision, hand, home) for hand in _looks(robot, arm, spot))


def _headings_missed(
    robot: RobotFile, arm: ArmModel, surface: ObjectSurface, base: Pose2, point: FloatArray
) -> int:
    """Return how many of `HEADINGS_RAD` do not let the hand grip and lift at a point (3,) on the map from
    above.
    """
    base_T_map = inverse(base.lift())
    tips = apply(base_T_map, point[None])[0]
    collision = CollisionModel(arm, tuple(box.seen_from(base_T_map) for box in surface.boxes("surface")))
    home = np.array(robot.posture("home"))
    hands = [_hand(robot, tips, PITCHES_RAD[0], roll) for roll in HEADINGS_RAD]
    return sum(
        not (_is_free(arm, collision, hand, home) and _is_free(arm, collision, raised(hand, LIFT_M), home))
        for hand in hands
    )


def _sees(
    robot: RobotFile, arm: ArmModel, collision: CollisionModel, spot: FloatArray, home: FloatArray
) -> bool:
    """Return whether the first camera off the hand can be turned to a point; True for a robot without a
    camera.

    Args:
        robot: the robot's file.
        arm: its arm.
        collision: the arm among its surroundings.
        spot: (3,) the point in the base frame, in [m].
        home: (n,) posture from which the camera is turned, in [rad] or [m].
    """
    spec = next(iter(robot.all_of(CameraSpec).values()), None)
    if spec is None:
        return True
    camera = known_camera(spec, mount_of(robot, spec, arm))
    views = aimed_views(arm, camera.carrier, camera.carrier_T_camera, spot, home)
    return any(not collision.in_collision(joints) for joints, _ in views)


def _hands(robot: RobotFile, tips: FloatArray) -> Iterator[Transform]:
    """Yield base_T_hand (4, 4) with the finger tips at a point (3,) in the base frame, in [m], from above or
    ahead.
    """
    for pitch in PITCHES_RAD:
        for roll in TURNS_RAD[:2]:
            yield _hand(robot, tips, pitch, roll)


def _hand(robot: RobotFile, tips: FloatArray, pitch: float, roll: float) -> Transform:
    """Return base_T_hand (4, 4) with the finger tips at a point (3,) in the base frame, in [m], at angles in
    [rad].
    """
    at_tips = transform((tips[0], tips[1], tips[2]), (0.0, pitch, 0.0))
    back = transform((-robot.finger_shape.tip, 0.0, 0.0), (roll, 0.0, 0.0))
    return np.asarray(at_tips @ back)


def _looks(robot: RobotFile, arm: ArmModel, spot: FloatArray) -> Iterator[Transform]:
    """Yield base_T_hand (4, 4) from which the camera on the hand looks at a point (3,) in the base frame, in
    [m].
    """
    spec = robot.hand_camera
    assert spec is not None
    hand_T_camera = known_camera(spec, mount_of(robot, spec, arm)).hand_T_camera
    for tilt in (0.0, math.radians(30.0)):
        for pose in camera_poses(spot, from_direction(tilt, math.pi), VIEW_DISTANCE_M):
            yield np.asarray(pose @ inverse(hand_T_camera))


def _is_free(arm: ArmModel, collision: CollisionModel, hand: Transform, near: FloatArray) -> bool:
    joints = arm.inverse(hand, near, restarts=IK_RESTARTS)
    return joints is not None and not collision.in_collision(joints)
