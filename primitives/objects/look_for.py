"""LOOK_FOR: find an object on a surface."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import AnyCamera
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.depth_camera import DepthCamera
from handcart.backends.description.things.printed_tag import PrintedTag
from handcart.backends.robot.localization.determination import PoseNeed
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.knowledge.object_names import ObjectName, SurfaceName
from handcart.primitives.objects.knowledge.objects import Objects, ObjectSighting
from handcart.primitives.objects.knowledge.tag_sight import READ_PX
from handcart.primitives.objects.looking.object_look import (
    ObjectLook,
    conclude,
    look_closely,
    look_from,
    require_determined,
    sighting,
)
from handcart.primitives.objects.looking.tag_readings import Located, locate
from handcart.primitives.objects.looking.view_plan import Direction, directions, places_and_weights
from handcart.primitives.objects.site.object_site import base_T_map, kind_of, surface_of
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.transform import apply
from handcart.robotics.manipulation.grasping.camera_poses import points_in_view
from handcart.robotics.numerics.arrays import FloatArray

VIEW_DISTANCES_M = (0.42, 0.36, 0.48)
"""Distances from the camera to the tops of the objects that are looked for, in [m]."""
SLANT_SHARE = 0.6  # of a tag's width that is left in the most slanting view
NEAREST_VIEW_M = 0.2
COVERED_SHARE = 0.97  # of the belief that views have shown when the search ends
SEEN_COVERED_SHARE = 0.85  # likewise, once the object was seen
VIEW_RADIUS_M = 0.11  # on the surface that a view surely shows
EDGE_PX = 50.0  # of the picture in which a tag may be cut off
MAX_HEADING_SIGMA_DEG = 50.0  # beyond, a tag on a side may be anywhere around


class LookFor(ActionPrimitive):
    """Look where an object is believed to be, then over the rest of the surface, until it is found.

    The views that show most of the probable places come first. A close view follows. The pose is computed
    from the corners of the object's tags in all pictures, given the height of the surface. Other known
    objects that were seen are noted too. An object without tags is found by its size, in the depths of all
    views.
    """

    object: ObjectName
    """Name of the object."""
    surface: SurfaceName | None = None
    """Surface to look at (default: the one that the object is believed to be on)."""
    direction: Direction = "any"
    """Directions to look from."""
    max_views: Annotated[int, Field(ge=1, le=30)] = 10
    """Maximum number of views."""
    tolerance_mm: Annotated[float, Field(gt=0.0, le=500.0)] = 25.0
    """Required accuracy of the position: 3 sigma."""
    tolerance_deg: Annotated[float, Field(gt=0.0, le=180.0)] = 3.0
    """Required accuracy of the heading: 3 sigma; a round object has none."""

    needs: ClassVar = (Arm, AnyCamera)
    reads: ClassVar = ("map", "sensed_cells", "objects", "detectors", "held_object")
    writes: ClassVar = ("sightings", "surface_poses", "places")

    _look: ObjectLook = PrivateAttr(default_factory=ObjectLook)
    _seen: Located | None = PrivateAttr(default=None)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the object is in the hand, or if no camera could show it; empty otherwise."""
        objects = model.of(Objects)
        held, file = objects.held_object, objects.objects
        if held is not None and held.object == self.object:
            return f"{self.object} is in the hand"
        has_depth = robot.backend.get(DepthCamera) is not None  # type: ignore[type-abstract]
        return self._invisible(file, has_depth)

    @override
    def lacking(self, kinds: Sequence[type[Capability]], model: ModelView) -> str:
        has_depth = any(issubclass(kind, DepthCamera) for kind in kinds)
        return self._invisible(model.of(Objects).objects, has_depth)

    def _invisible(self, file: ObjectsFile, has_depth: bool) -> str:
        """Return why no camera could show the object; "" if one could."""
        if has_depth or self.object not in file.objects or file.tags_of(self.object):
            return ""
        return f"{self.object} has no tags, and the robot has no depth camera; needed: one of them"

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        kind_of(model, self.object)
        objects, name = model.of(Objects), self._surface(model)
        yield from model.of(Objects).measure(robot, model, name, self.found)
        yield from self._search(robot, model, name)
        yield from self._look.understand(robot, model, name)
        first = conclude(robot, model, self.object, name, self._look)
        yield from look_closely(
            robot, model, self.object, first.base_T_object, self._look, self.evidence, self.direction
        )
        yield from self._look.understand(robot, model, name)
        self._seen = conclude(robot, model, self.object, name, self._look)
        seen = sighting(robot, model, self.object, name, self._seen)
        need = PoseNeed(self.tolerance_mm / 1e3, math.radians(self.tolerance_deg))
        require_determined(model, self.object, seen, need)
        others = self._others(robot, model, name)
        kept = [item for item in objects.without(self.object) if item.object not in others]
        objects.sightings = (*kept, seen, *others.values())
        believed = objects.believed(self.object)
        if believed is not None:
            off = seen.pose.distance(believed)
            self.found(off_belief_mm=round(1e3 * off, 1))
        self.found(
            x_m=round(seen.pose.x, 4),
            y_m=round(seen.pose.y, 4),
            heading_deg=round(math.degrees(seen.pose.theta), 2),
            sigma_mm=round(1e3 * math.sqrt(max(seen.covariance[0][0], seen.covariance[1][1])), 2),
            views=self._look.views,
        )

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the searched object was found, and its pose measured."""
        return self._seen is not None
        yield

    def _surface(self, model: ModelView) -> str:
        name = self.surface or model.of(Objects).objects.objects[self.object].on
        surface_of(model, name)
        return name

    def _search(self, robot: Robot, model: ModelView, name: str) -> Periods:
        """Look from view to view until the object's tag is read and most of the belief was in view."""
        file, surface = model.of(Objects).objects, surface_of(model, name)
        known = file.objects[self.object]
        at = model.of(Objects).believed(self.object) if known.on == name else None
        believed = None if at is None else (at.x, at.y)
        places, weights = places_and_weights(surface, believed, known.sigma_mm / 1e3)
        height = surface.height_m + kind_of(model, self.object).size[2]
        points = apply(base_T_map(robot), np.column_stack([places, np.full(len(places), height)]))
        unsure = at is None or known.sigma_deg > MAX_HEADING_SIGMA_DEG
        heading = None if at is None or unsure else at.theta - robot.pose.theta
        towards = list(directions(file.tags_of(self.object), heading, self.direction))
        distances = _reading_distances(robot, file.tags_of(self.object))
        tried = np.zeros(len(points), dtype=np.bool_)
        total = float(weights.sum())
        while self._look.views < self.max_views and weights.sum() > self._may_be_missed() * total:
            aim = _best_aim(points, np.where(tried, 0.0, weights), weights)
            if aim is None:
                break
            tried[aim] = True
            if not (yield from look_from(robot, model, points[aim], towards, distances)):
                continue
            yield from self._look.picture(robot, model, self.evidence, self.object)
            camera = robot.view_camera
            shown = points_in_view(camera.model, robot.base_T_camera(camera), points, EDGE_PX)
            weights = np.where(shown, 0.0, weights)
        if self._look.views == 0:
            raise Discrepancy(f"no view of {name} is free", cause=causes.NO_ARM_PATH)

    def _may_be_missed(self) -> float:
        """Return the share of the belief that need not be in view: more once the object was seen.

        Where most of the belief is in view, a second object with the same tag would have been seen.
        """
        return 1.0 - (SEEN_COVERED_SHARE if self._look.of(self.object) else COVERED_SHARE)

    def _others(self, robot: Robot, model: ModelView, name: str) -> dict[str, ObjectSighting]:
        """Return the sightings of other objects that are upright on the same surface."""
        found: dict[str, ObjectSighting] = {}
        surface = surface_of(model, name)
        for other in model.of(Objects).objects.objects:
            reads = self._look.of(other)
            if other == self.object or not reads:
                continue
            place = locate(reads, kind_of(model, other), surface)
            if isinstance(place, Located):
                try:
                    found[other] = sighting(robot, model, other, name, place)
                except Discrepancy:
                    continue
        return found


def _reading_distances(robot: Robot, tags: Sequence[PrintedTag]) -> Sequence[float]:
    """Return the distances from a camera on the hand to the tops, in [m], from which one of the tags is read;
    small tags are looked at from nearer.
    """
    if not tags:
        return VIEW_DISTANCES_M
    focal_px = float(robot.view_camera.model.K[0, 0])
    farthest = max(NEAREST_VIEW_M, focal_px * max(tag.side for tag in tags) * SLANT_SHARE / READ_PX)
    return list(dict.fromkeys(min(distance, farthest) for distance in VIEW_DISTANCES_M))


def _best_aim(points: FloatArray, aims: FloatArray, weights: FloatArray) -> int | None:
    """Return the index of the point around which a view shows most of the belief; None if none is left.

    Args:
        points: (n, 3) in the base frame, in [m].
        aims: (n,) weights of points that may be aimed at; 0 for those that may not.
        weights: (n,) weights of what is still to be shown.
    """
    candidates = np.flatnonzero(aims > 0.0)
    if not len(candidates):
        return None
    away = np.hypot(*(points[candidates, None, :2] - points[None, :, :2]).transpose(2, 0, 1))
    shown = (away < VIEW_RADIUS_M) @ weights
    near = np.hypot(points[candidates, 0], points[candidates, 1])
    return int(candidates[np.lexsort((near, -np.round(shown, 6)))[0]])
