"""Where a handle is, by the tags on its door."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import NamedTuple

import numpy as np

from handcart.backends.description.things.printed_tag import UNIT_TAG_CORNERS
from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.looking.object_look import look_from
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.drawing.overlay import draw_overlay
from handcart.robotics.perception.landmarks.tag_reader import Tag, read_tags, tag_poses
from handcart.robotics.perception.objects.upright_fit import TagView, fit_upright

from .doors import Doors
from .doors_file import KnownDoor

VIEW_DISTANCES_M = (0.34, 0.40, 0.28, 0.46)
"""Distances from the camera to a tag, in [m]."""
VIEW_TURNS_RAD = (0.35, -0.35, 0.0, 0.7, -0.7)
"""Angles about the vertical from the normal of a door to the direction of the camera, in [rad]."""
VIEW_RISES_RAD = (0.15, 0.4, 0.0)
WANTED_VIEWS = 2
MIN_TURN_RAD = 0.3  # between two views
PICTURES_PER_VIEW = 2
HEIGHT_SIGMA_M = 0.004  # of a handle's height, as the robot knows it
MAX_RMS_PX = 2.0


class LocatedHandle(NamedTuple):
    """Pose of a door's handle in the base frame, measured by the tags next to it, with its covariance."""

    base_T_handle: Transform
    """Pose (4, 4) of the handle in the base frame."""
    covariance: FloatArray
    """(4, 4) of x, y, z in [m] and the heading in [rad], in the base frame."""


def find_handle(
    robot: Robot,
    model: ModelView,
    name: str,
    door: KnownDoor,
    expected: Transform,
    front: Solid,
    evidence: Evidence,
) -> Generator[None, None, LocatedHandle]:
    """Look at the tags of a door from two sides, and return where its handle is.

    Args:
        robot: robot with a camera.
        model: world model with surfaces and objects.
        name: name of the door.
        door: the door as the file describes it.
        expected: expected pose base_T_handle (4, 4).
        front: the front of the door, in the base frame.
        evidence: evidence of the attempt, to which the last picture is added.

    Raises:
        Discrepancy: no view is free, or no tag is read.
    """
    views: list[TagView] = []
    guess: Transform | None = None
    seen_from: list[float] = []
    looked = 0
    for turn in VIEW_TURNS_RAD:
        if len(seen_from) == WANTED_VIEWS:
            break
        if any(abs(turn - other) < MIN_TURN_RAD for other in seen_from):
            continue
        point = (expected @ door.tags[0].on_door(door.handle.standoff))[:3, 3]
        towards, swept = _towards(expected, turn), model.of(Doors).swept_areas()
        if not (
            yield from look_from(robot, model, point, towards, VIEW_DISTANCES_M, (front,), open_areas=swept)
        ):
            continue
        looked += 1
        found = yield from _take(robot, door, evidence)
        if found:
            seen_from.append(turn)
            views += [view for view, _ in found]
            guess = found[0][1] if guess is None else guess
    if guess is None:
        if not looked:
            raise Discrepancy(f"no view of {name} is free", cause=causes.NO_ARM_PATH)
        unread = Measured("Camera", f"of {looked} views those that show a tag of {name}", 0, 1)
        raise Discrepancy(f"no tag of {name} is seen", measured=unread, cause=causes.NOT_SEEN)
    fit = fit_upright(views, guess, door.handle.height_m, HEIGHT_SIGMA_M)
    if fit.rms_px > MAX_RMS_PX:
        off = Measured("Camera", "corners of the tags off their places", fit.rms_px, MAX_RMS_PX, "px")
        raise Discrepancy(f"the tags of {name} don't fit together", measured=off, cause=causes.MISPLACED)
    return LocatedHandle(fit.base_T_box, fit.covariance)


def _towards(expected: Transform, turn: float) -> list[FloatArray]:
    """Return unit vectors (3,) from a tag to the camera, in the base frame.

    Args:
        expected: (4, 4) base_T_handle by the present knowledge.
        turn: angle about the vertical from the door's normal, in [rad], positive to the left.
    """
    heading = math.atan2(expected[1, 0], expected[0, 0]) + turn
    return [
        np.array([math.cos(rise) * math.cos(heading), math.cos(rise) * math.sin(heading), math.sin(rise)])
        for rise in VIEW_RISES_RAD
    ]


def _take(
    robot: Robot, door: KnownDoor, evidence: Evidence
) -> Generator[None, None, list[tuple[TagView, Transform]]]:
    """Take pictures from here until a tag of the door is read; return its views and base_T_handle (4, 4)."""
    yield from settle(robot)
    for _ in range(PICTURES_PER_VIEW):
        yield
        photo = robot.photo()
        found: list[tuple[TagView, Transform]] = []
        shown: list[Tag] = []
        for family in dict.fromkeys(tag.family for tag in door.tags):
            for read in read_tags(photo.pixels, family=family):
                for tag in door.tags:
                    if (tag.family, tag.id) == (family, read.id):
                        side, handle_T_tag = tag.side_mm / 1e3, tag.on_door(door.handle.standoff)
                        corners = apply(handle_T_tag, UNIT_TAG_CORNERS * side)
                        pose = tag_poses(read, photo.camera, side)[0].camera_T_tag
                        view = TagView(photo.camera, photo.base_T_camera, read.corners, corners)
                        found.append((view, np.asarray(photo.base_T_camera @ pose @ inverse(handle_T_tag))))
                        shown.append(read)
        evidence.pictures["door"] = draw_overlay(photo.pixels, shown)
        if found:
            return found
    return []
