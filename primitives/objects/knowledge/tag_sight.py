"""Width of tags in the pictures of a camera that is not on the hand, before anything moves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.description.things.printed_tag import UNIT_TAG_CORNERS
from handcart.backends.robot.mounted_camera import MountedCamera, known_camera, mount_of
from handcart.primitives.knowledge.place import Place
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .aimed_view import aimed_views
from .grasp_reach import GraspWork, grasp_work

READ_PX = 16.0
"""Length of a tag's shortest side in a picture, at which it is surely read."""


def unread_words(
    robot: RobotFile, file: ObjectsFile, places: Mapping[str, Place]
) -> Iterator[tuple[str, str]]:
    """Yield the name of each object whose tags the camera sees too small from its surface's place, with a
    warning; nothing for a robot with a camera on the hand, which looks from nearer.

    Args:
        robot: robot with an arm.
        file: objects and surfaces.
        places: places of the base, by surface.
    """
    spec = next(iter(robot.all_of(CameraSpec).values()), None)
    if spec is None or robot.hand_camera is not None:
        return
    arm = robot.described_arm
    camera, home = known_camera(spec, mount_of(robot, spec, arm)), np.array(robot.posture("home"))
    for name, place in places.items():
        for work in grasp_work(file, name):
            foot = Pose2(work.x_m, work.y_m, math.radians(file.objects[work.name].heading_deg))
            base_T_object = inverse(place.pose.lift()) @ foot.lift(file.surfaces[name].height_m)
            widest = _shortest_side_px(arm, camera, home, np.asarray(base_T_object), file, work)
            if 0.0 < widest < READ_PX:
                yield (
                    work.name,
                    f"from the place before {name!r} the camera sees the tag of {work.name} {widest:.0f} px"
                    f" wide: it may not be read; allowed: at least {READ_PX:.0f} px, by a larger tag, a"
                    " nearer object, or a camera with more pixels",
                )


def _shortest_side_px(
    arm: ArmModel,
    camera: MountedCamera,
    home: FloatArray,
    base_T_object: Transform,
    file: ObjectsFile,
    work: GraspWork,
) -> float:
    """Return the length of the shortest side of the object's tag that is widest in a picture, in [px].

    The result is 0 if no tag faces the camera.

    Args:
        arm: kinematics of arm and head.
        camera: camera on a head or mast.
        home: (n,) posture of all joints, from which the head turns, in [rad] or [m].
        base_T_object: (4, 4) believed pose of the object.
        file: knows the object's tags.
        work: the object.
    """
    size, widest = work.kind.size, 0.0
    for tag in file.tags_of(work.name):
        corners = apply(base_T_object @ tag.on_box(size), UNIT_TAG_CORNERS * tag.side)
        middle = corners.mean(axis=0)
        for _, base_T_camera in aimed_views(arm, camera.carrier, camera.carrier_T_camera, middle, home):
            outline = camera.model.project(apply(inverse(base_T_camera), corners))
            if _is_front(outline):
                sides = np.hypot(*(np.roll(outline, -1, axis=0) - outline).T)
                widest = max(widest, float(sides.min()))
    return widest


def _is_front(outline: FloatArray) -> bool:
    """Return whether a tag is seen from its front: its corners (4, 2) in [px] are clockwise; not for NaN."""
    x, y = outline.T
    return bool(x @ np.roll(y, -1) - y @ np.roll(x, -1) > 0.0)
