"""Pictures of an object from planned views, and what they say together."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field

import numpy as np

from handcart.backends.capabilities.depth_camera import DepthImage
from handcart.backends.robot.localization.determination import PoseNeed, undetermined
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.detectors.detector import BrokenDetector
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import collision_model
from handcart.primitives.objects.knowledge.object_names import name_in_world
from handcart.primitives.objects.knowledge.objects import LEVEL_M, Objects, ObjectSighting
from handcart.primitives.objects.site.object_site import (
    base_T_map,
    held_shape,
    kind_of,
    surface_of,
)
from handcart.primitives.objects.site.roomy_motion import move_with_room, surroundings_to_try
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.drawing.overlay import draw_overlay
from handcart.robotics.perception.objects.depth_view import DepthView, depth_view

from .depth_readings import ObjectBelief, Standing, contradiction, identify, standing, take_depth
from .detected_objects import DetectedObject, detect_all, explained
from .tag_readings import Located, NotUpright, ReadTag, SeenTwice, locate, read_objects
from .view_plan import Direction, directions, view_joints

CLOSE_DISTANCES_M = (0.28, 0.34, 0.24)
"""Distances from the camera to the top of an object whose place is known."""
DEPTH_DISTANCES_M = (0.42, 0.48, 0.54)
"""Distances of a depth camera, which has a minimum range, to the top of such an object."""
SEEN_SIGMA_M = 0.02  # of where something was seen or put
PICTURES_PER_VIEW = 2  # at most, until something is read
MAX_OFF_SURFACE_M = 0.02  # that the middle of a foot may be beyond an edge


@dataclass
class ObjectLook:
    """Tags, depth pictures and detections from which objects are located, all from one place of the base."""

    reads: list[ReadTag] = field(default_factory=list)
    depths: list[DepthView] = field(default_factory=list)
    found: list[Standing] = field(default_factory=list)
    detected: list[DetectedObject] = field(default_factory=list)
    views: int = 0

    def of(self, name: str) -> list[ReadTag]:
        """Return those tags read in this look that belong to the object named `name`."""
        return [read for read in self.reads if read.object == name]

    def others(self, name: str) -> str:
        """Return a text that lists the tags read in the pictures, except those of the object `name`: known
        tags as their object's name, unknown ones as a label; "nothing" if no other tag was read.
        """
        found = dict.fromkeys(read.object or read.label for read in self.reads if read.object != name)
        return ", ".join(found) or "nothing"

    def picture(
        self, robot: Robot, model: ModelView, evidence: Evidence, name: str
    ) -> Generator[None, None, None]:
        """Wait for rest, take pictures from the current view, and add the tags and depths read in them to
        this look.

        Args:
            robot: robot whose camera has the view.
            model: knows objects and detectors.
            evidence: receives the picture.
            name: object that is looked for; no more pictures are taken once one of its tags is read.
        """
        yield from settle(robot)
        self.views += 1
        has_tags = bool(model.of(Objects).objects.tags_of(name))
        for _ in range(PICTURES_PER_VIEW if has_tags else 1):
            yield
            photo = robot.photo()
            found = read_objects(photo.pixels, photo.camera, photo.base_T_camera, model.of(Objects).objects)
            if found or not self.reads:
                evidence.pictures["objects"] = draw_overlay(photo.pixels, [tag.tag for tag in found])
            self.reads += found
            if any(tag.object == name for tag in found):
                break
        taken = take_depth(robot)
        if taken is not None:
            image, camera = taken
            self.depths.append(depth_view(image.depth, camera, image.base_T_camera))
            yield from self._detect(robot, model, image, camera)

    def _detect(self, robot: Robot, model: ModelView, image: DepthImage, camera: CameraModel) -> Periods:
        """Note what the detectors of other packages find in a picture."""
        detectors = model.of(Objects).detectors
        if not detectors:
            return
        try:
            self.detected += yield from robot.compute(detect_all, detectors, image, camera)
        except BrokenDetector as broken:
            raise Discrepancy(str(broken), permanent=True, cause=causes.NOT_SEEN) from None

    def understand(self, robot: Robot, model: ModelView, surface: str) -> Periods:
        """Find the things on a surface in all depth pictures that this look has taken, and store them in
        `found`.

        Things that an earlier call stored are replaced. Without depth pictures, nothing is done.
        """
        if self.depths:
            file, top = model.of(Objects).objects, base_T_top(robot, model, surface)
            known = surface_of(model, surface)
            found = yield from robot.compute(standing, tuple(self.depths), top, known, file.kinds)
            self.found = explained(found, self.detected, top)


def look_closely(
    robot: Robot,
    model: ModelView,
    name: str,
    base_T_object: Transform,
    look: ObjectLook,
    evidence: Evidence,
    wanted: Direction = "any",
) -> Periods:
    """Move the camera near an object of roughly known place, without touching it, and read the object's tags.

    Args:
        robot: robot with a camera.
        model: knows surfaces, seen objects and what is held.
        name: name of the object.
        base_T_object: (4, 4) expected pose of the object.
        look: collects the readings of the tags.
        evidence: receives the picture.
        wanted: directions from which the camera may look.

    Raises:
        Discrepancy: no view of the object can be reached without a collision.
    """
    file = model.of(Objects).objects
    kind = file.kind_of(name)
    top = base_T_object[:3, 3] + (0.0, 0.0, kind.size[2])
    body = kind.body(name_in_world(name)).seen_from(base_T_object)
    heading = math.atan2(base_T_object[1, 0], base_T_object[0, 0])
    towards = list(directions(file.tags_of(name), heading, wanted))
    distances = CLOSE_DISTANCES_M if file.tags_of(name) else DEPTH_DISTANCES_M
    if not (yield from look_from(robot, model, top, towards, distances, (body,), without=name)):
        raise Discrepancy(f"no view of {name} is free", cause=causes.NO_ARM_PATH)
    yield from look.picture(robot, model, evidence, name)


def look_from(
    robot: Robot,
    model: ModelView,
    point: FloatArray,
    towards: Sequence[FloatArray],
    distances: Sequence[float],
    also_around: Sequence[Solid] = (),
    shown: FloatArray | None = None,
    without: str = "",
    open_areas: Sequence[FloatArray] = (),
) -> Generator[None, None, bool]:
    """Move the camera to a view of a point in the base frame; return False if all views would collide.

    Args:
        robot: robot with a camera.
        model: knows surfaces, seen objects and what is held.
        point: (3,) in the base frame, in [m].
        towards: unit vectors (3,) in the base frame from the point to the camera, the best ones first.
        distances: from the camera to the point, in [m], the best ones first.
        also_around: further bodies that the arm must not touch, in the base frame.
        shown: (m, 3) points in the base frame, in [m], that hand and held object should not hide.
        without: name of an object that is left out of the surroundings: its body is among `also_around`.
        open_areas: outlines (n, 2) on the map, in [m], of areas without walls.
    """
    held = held_shape(model)
    for bodies in surroundings_to_try(robot, model, without, open_areas):
        around = (*bodies, *also_around)
        collision = collision_model(robot, held, around)
        found = yield from robot.compute(view_joints, robot, collision, point, towards, distances, shown)
        if found is not None:
            also = tuple(also_around)
            yield from move_with_room(robot, model, found[0], held, also, without, open_areas)
            return True
    return False


def conclude(
    robot: Robot,
    model: ModelView,
    name: str,
    surface: str,
    look: ObjectLook,
    expected: Transform | None = None,
) -> Located:
    """Return the pose of an object, computed from all pictures that were taken from one place of the base.

    An object with tags is found by its tags, any other by its size. `ObjectLook.understand` must have
    evaluated the depth pictures before.

    Args:
        robot: the robot.
        model: knows objects and surfaces.
        name: name of the object.
        surface: name of the surface that it should be on.
        look: the pictures.
        expected: base_T_object (4, 4) where it was seen or put; None: as the file of objects states.

    Raises:
        Discrepancy: it was not seen, seen at two places, has fallen over or is not on the surface.
    """
    file = model.of(Objects).objects
    if not file.tags_of(name):
        return identify(
            name,
            file.objects[name].kind,
            kind_of(model, name),
            look.found,
            _beliefs(robot, model, name, surface, expected),
            base_T_top(robot, model, surface),
            look.views,
        )
    reads = look.of(name)
    if not reads:
        unread = Measured("Camera", f"of {look.views} views those that show {name}", 0, 1)
        raise Discrepancy(
            f"{name} isn't seen on {surface}; seen: {look.others(name)}",
            measured=unread,
            cause=causes.NOT_SEEN,
        )
    found = locate(reads, kind_of(model, name), surface_of(model, surface))
    if isinstance(found, SeenTwice):
        apart = Measured("Camera", "tags of one object apart", 1e3 * found.apart, 0.0, "mm")
        raise Discrepancy(
            f"{name} is seen at two places: two objects have its tag, or it was moved",
            measured=apart,
            cause=causes.AMBIGUOUS,
        )
    if isinstance(found, NotUpright):
        raise Discrepancy(
            f"{name} doesn't stand upright on {surface}: {found.reason}", cause=causes.MISPLACED
        )
    kind, top = file.objects[name].kind, base_T_top(robot, model, surface)
    other = contradiction(look.found, top, found.base_T_object, kind, file.kinds[kind])
    if other:
        words = f"what has the tag of {name} is no {kind}: seen is {other}"
        raise Discrepancy(words, cause=causes.AMBIGUOUS)
    return found


def base_T_top(robot: Robot, model: ModelView, surface: str) -> Transform:
    """Return the pose (4, 4) of the middle of a surface's top in the base frame."""
    found = surface_of(model, surface)
    return np.asarray(base_T_map(robot) @ found.floor.lift(found.height_m))


def _beliefs(
    robot: Robot, model: ModelView, name: str, surface: str, expected: Transform | None
) -> list[ObjectBelief]:
    """Return the believed poses of all objects of an object's kind on a surface, the object itself first.

    Args:
        robot: the robot.
        model: knows objects and surfaces.
        name: name of the object.
        surface: name of the surface.
        expected: (4, 4) base_T_object where it was seen or put; None: as the file of objects believes.
    """
    objects = model.of(Objects)
    file, held = objects.objects, objects.held_object
    found = []
    for other, known in file.objects.items():
        seen = objects.seen(other)
        if other != name and (
            known.kind != file.objects[name].kind
            or (held is not None and held.object == other)
            or (seen.surface if seen is not None else known.on) != surface
        ):
            continue
        if other == name and expected is not None:
            x, y = expected[:2, 3].tolist()
            heading = math.atan2(expected[1, 0], expected[0, 0])
            found.append(ObjectBelief(other, (x, y), SEEN_SIGMA_M, heading))
        elif seen is not None and seen.surface == surface:
            here = robot.pose.inverse().compose(seen.pose)
            found.append(ObjectBelief(other, (here.x, here.y), SEEN_SIGMA_M, here.theta))
        else:
            found.append(_of_file(robot, objects, other, surface))
    return sorted(found, key=lambda item: item.object != name)


def _of_file(robot: Robot, objects: Objects, name: str, surface: str) -> ObjectBelief:
    known, believed = objects.objects.objects[name], objects.believed(name)
    if believed is None or known.on != surface:
        return ObjectBelief(name, None, 1.0, math.radians(known.heading_deg) - robot.pose.theta)
    here = robot.pose.inverse().compose(believed)
    sigma = max(known.sigma_mm / 1e3, SEEN_SIGMA_M)
    return ObjectBelief(name, (here.x, here.y), sigma, believed.theta - robot.pose.theta)


def sighting(robot: Robot, model: ModelView, name: str, surface: str, found: Located) -> ObjectSighting:
    """Convert the pose of an object that was located in the base frame (`found`) to a sighting on the map.
    Its covariance includes the error of the base's pose. An object on another surface of the same height,
    such as the other half of a wide bin, is said to be there.

    Raises:
        Discrepancy: the object is not on the surface, but next to it.
    """
    x, y = found.base_T_object[:2, 3].tolist()
    heading = math.atan2(found.base_T_object[1, 0], found.base_T_object[0, 0])
    pose = robot.pose.compose(Pose2(x, y, heading))
    outside = -surface_of(model, surface).margin(pose.x, pose.y)
    if outside > MAX_OFF_SURFACE_M and (level := _level_with(model, surface, pose)) is not None:
        surface = level
    elif outside > MAX_OFF_SURFACE_M:
        off = Measured("Camera", f"{name} beside the surface", 1e3 * outside, 1e3 * MAX_OFF_SURFACE_M, "mm")
        raise Discrepancy(f"{name} isn't on {surface}", measured=off, cause=causes.MISPLACED)
    covariance = on_map(robot.pose, robot.localization.covariance, Pose2(x, y, heading), found.covariance)
    return ObjectSighting(name, surface, pose, tuple(tuple(row) for row in covariance.tolist()))


def _level_with(model: ModelView, surface: str, pose: Pose2) -> str | None:
    """Return the name of another surface, as high as `surface`, with a point of the map on it; None if there
    is none.
    """
    height = surface_of(model, surface).height_m
    for name in model.of(Objects).objects.surfaces:
        other = surface_of(model, name)
        if name != surface and abs(other.height_m - height) <= LEVEL_M and other.margin(*pose[:2]) >= 0.0:
            return name
    return None


def require_determined(model: ModelView, name: str, seen: ObjectSighting, need: PoseNeed) -> None:
    """Raise `Discrepancy` if the measured pose of an object is less accurate than required.

    Args:
        model: knows the objects.
        name: name of the object.
        seen: where the object was seen, with the covariance of its pose.
        need: required accuracy of the pose; the heading of a round object does not count.
    """
    if model.of(Objects).objects.kind_of(name).is_round:
        need = need._replace(heading=math.inf)
    found = undetermined(np.array(seen.covariance), need)
    if found is not None:
        size, limit = found.shown
        measured = Measured("Camera", f"3 sigma of the pose of {name}", size, limit, found.unit)
        raise Discrepancy(f"{name}: {found.words}", measured=measured, cause=causes.UNDETERMINED)


def on_map(base: Pose2, base_covariance: FloatArray, seen: Pose2, covariance: FloatArray) -> FloatArray:
    """Return the covariance (3, 3) on the map of a pose that was measured in the base frame.

    Its rows and columns are x, y in [m] and heading in [rad].

    Args:
        base: map_T_base.
        base_covariance: (3, 3) covariance of `base`, of x, y in [m] and heading in [rad], on the map.
        seen: base_T_object.
        covariance: (3, 3) covariance of `seen`, in the same units, in the base frame.
    """
    cos, sin = math.cos(base.theta), math.sin(base.theta)
    by_base = np.eye(3)
    by_base[0, 2], by_base[1, 2] = -sin * seen.x - cos * seen.y, cos * seen.x - sin * seen.y
    by_look = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(by_base @ base_covariance @ by_base.T + by_look @ covariance @ by_look.T)
