"""Surroundings of the robot at its place before a surface."""

from __future__ import annotations

from collections.abc import Iterator

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.objects.knowledge.object_names import name_in_world
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box, Cylinder, Solid
from handcart.robotics.manipulation.motions.collision_model import HELD_NAME

OWN_TRAY_NAME = "own tray"
BELIEF_SIGMAS = 2.0  # of a believed place, that an object unseen so far is kept clear of
MAX_BELIEF_M = 0.12  # maximum kept clear: a less certain object may be anywhere on its surface
CLOSE_VIEW_M = 0.05  # around an object that was looked at closely: no other is there unseen


def base_T_map(robot: Robot) -> Transform:
    """Return the pose (4, 4) of the map in the base frame, computed from the estimated pose of the base."""
    return robot.pose.inverse().lift()


def surroundings(
    robot: Robot, model: ModelView, without: str = "", room: float = 0.0, believed: bool = True
) -> tuple[Solid, ...]:
    """Return bodies of surfaces, of all known objects but one, and of the robot's tray, in the base frame.

    Around an object that was not seen yet, the uncertainty of its believed place is included.

    Args:
        robot: robot at the surfaces.
        model: knows surfaces and objects.
        without: name of the object that is left out.
        room: distance by which the inner and outer faces of the surfaces' walls are moved outwards, in [m].
        believed: True to include objects that were not seen yet.
    """
    objects, to_base = model.of(Objects), base_T_map(robot)
    boxes: list[Solid] = [
        box for name in objects.objects.surfaces for box in objects.surface(name).boxes(name, room)
    ]
    for seen in objects.sightings:
        if seen.object != without:
            kind, surface = objects.objects.kind_of(seen.object), objects.surface(seen.surface)
            body = kind.body(name_in_world(seen.object))
            boxes.append(body.seen_from(seen.pose.lift(surface.height_m)))
    boxes += _believed(objects, without) if believed else ()
    around = tuple(box.seen_from(to_base) for box in boxes)
    return (*around, _own_tray(robot)) if robot.spec.has_tray else around


def _believed(objects: Objects, without: str) -> Iterator[Cylinder]:
    """Yield cylinders around the believed places of objects that were not seen, on the map.

    A cylinder ends before what a close look at the object `without` has shown: no other object is there. One
    that would begin there is left out.
    """
    target = objects.seen(without)
    for name, known in objects.objects.objects.items():
        believed = objects.believed(name)
        if believed is None or name == without or objects.seen(name) is not None:
            continue
        if objects.is_taken_away(name):
            continue
        x, y, kind, surface = believed.x, believed.y, objects.objects.kind_of(name), objects.surface(known.on)
        reach = kind.foot_radius + min(BELIEF_SIGMAS * known.sigma_mm / 1e3, MAX_BELIEF_M)
        if target is not None:
            gap = objects.objects.kind_of(without).foot_distance(Pose2(x, y, 0.0).relative_to(target.pose))
            reach = min(reach, gap - CLOSE_VIEW_M)
            if reach <= 0.0:
                continue
        foot = transform((x, y, surface.height_m + kind.size[2] / 2))
        yield Cylinder(foot, reach, kind.size[2], name_in_world(name))


def _own_tray(robot: Robot) -> Box:
    """Return the tray as something that a held object must not touch."""
    tray = robot.spec.tray_shape
    return Box(transform((*tray.middle, tray.top - tray.size[2] / 2)), tray.size, OWN_TRAY_NAME)


def kind_of(model: ModelView, name: str) -> ObjectKind:
    """Return the kind of an object; raises `Discrepancy` if the file has no such object."""
    file = model.of(Objects).objects
    if name not in file.objects:
        raise Discrepancy(f"unknown object {name!r}", permanent=True, cause=causes.NOT_KNOWN)
    return file.kind_of(name)


def surface_of(model: ModelView, name: str) -> ObjectSurface:
    """Return a surface by its name, at its measured pose if it was measured; raise `Discrepancy` if the file
    of objects has no such surface.
    """
    objects = model.of(Objects)
    if name not in objects.objects.surfaces:
        raise Discrepancy(f"unknown surface {name!r}", permanent=True, cause=causes.NOT_KNOWN)
    return objects.surface(name)


def held_shape(model: ModelView) -> Solid | None:
    """Return the solid in the hand, posed in the hand frame; None if nothing is known to be held."""
    objects = model.of(Objects)
    held = objects.held_object
    return None if held is None else held_box(objects.objects.kind_of(held.object), held.hand_T_object)


def held_box(kind: ObjectKind, hand_T_object: Transform) -> Solid:
    """Return the solid of a held object, posed in the hand frame.

    Args:
        kind: kind of the object.
        hand_T_object: (4, 4) pose of the object.
    """
    return kind.body(HELD_NAME).seen_from(hand_T_object)
