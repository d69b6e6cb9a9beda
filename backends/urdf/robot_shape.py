"""Shapes of a robot's tray and fingers, from its URDF."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from handcart.files.errors import InputError
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box, Shape, top
from handcart.robotics.kinematics.urdf_contents import bodies_of, joints_of, link_joints
from handcart.robotics.kinematics.urdf_frames import base_T_frame

FINGER_LINK = "left_finger"
TRAY_LINK = "tray"
MAX_TILT_SINE = 1e-3
"""Sine of the tilt up to which sides count as parallel to the axes: `1.5708` is a right angle."""


class MissingShape(InputError):
    """Error for a robot's URDF that has no box for the tray or the fingers, or whose box is tilted."""


class TrayShape(NamedTuple):
    """Shape of the robot's tray, a level box with sides along the axes of the base frame, in [m]."""

    middle: tuple[float, float]
    """x and y of the tray's middle in the base frame, in [m]."""
    size: tuple[float, float, float]
    """Size of the tray along x, y and z, in [m]."""
    top: float
    """Height of the tray's upper side, which carries things, in the base frame, in [m]."""

    @property
    def rear(self) -> float:
        """x of the tray's rear side in the base frame, in [m]."""
        return self.middle[0] - self.size[0] / 2


class FingerShape(NamedTuple):
    """Shape of each finger of the gripper, a box along the x axis of the frame `hand`, in [m]."""

    tip: float
    """x of the finger's tip in the hand frame, in [m]."""
    length: float
    """Length of the finger along the hand's x axis, in [m]."""
    thickness: float
    """Thickness of the finger along the hand's y axis, in [m]."""
    height: float
    """Height of the finger along the hand's z axis, in [m], half of it above the x axis."""


def tray_shape(arm: ArmModel) -> TrayShape:
    """Return the largest box of the link `tray`; its upper side carries things.

    Raises:
        MissingShape: the link has no box, or the box is not level and straight.
    """
    box = _box(arm.link_shapes(0.5 * (arm.lower + arm.upper)), TRAY_LINK)
    size = _size_along(box.pose, box.size)
    if size is None:
        raise MissingShape(
            f"the link {TRAY_LINK!r} isn't level and straight; allowed: a box along the frame `base`"
        )
    x, y, z = (float(number) for number in box.pose[:3, 3])
    return TrayShape((x, y), size, z + size[2] / 2)


def body_height(urdf_text: str) -> float:
    """Return the height of the base's top above the floor, in [m], without parts mounted on it.

    The top is that of the bodies of the link `base`. If that link has no body, as in many makers' URDFs, it
    is the top of the bodies on the links fixed to `base`.
    """
    bodies, joints, links = bodies_of(urdf_text), link_joints(urdf_text), {"base"}
    moving = {item.name for item in joints_of(urdf_text)}
    while links:
        if found := [body for body in bodies if body.name in links]:
            return max(_top_on(base_T_frame(urdf_text, item.name), item) for item in found)
        links = {child for name, parent, child in joints if parent in links and name not in moving}
    return 0.0


def _top_on(base_T_link: Transform, body: Shape) -> float:
    """Return the height of the top of a body in the base frame, in [m].

    Args:
        base_T_link: (4, 4) pose of the body's link in the base frame.
        body: shape of the body, posed in the link's frame.
    """
    return top(replace(body, pose=np.asarray(base_T_link @ body.pose)))


def finger_shape(arm: ArmModel) -> FingerShape:
    """Return the largest box of the link `left_finger`.

    Raises:
        MissingShape: the link has no box, or the box is not along the frame `hand`.
    """
    joints = 0.5 * (arm.lower + arm.upper)
    box = _box(arm.link_shapes(joints), FINGER_LINK)
    hand_T_box = inverse(arm.forward(joints)) @ box.pose
    size = _size_along(hand_T_box, box.size)
    if size is None:
        raise MissingShape(
            f"the box of a finger (link {FINGER_LINK!r}) isn't straight; allowed: sides along the axes of the"
            " frame `hand`, whose x axis is the direction of approach"
        )
    return FingerShape(float(hand_T_box[0, 3]) + size[0] / 2, *size)


def _box(shapes: Sequence[Shape], link: str) -> Box:
    boxes = [shape for shape in shapes if isinstance(shape, Box) and shape.name == link]
    if not boxes:
        raise MissingShape(f"the link {link!r} has no collision box; needed: one that defines its size")
    return max(boxes, key=lambda box: float(np.prod(box.size)))


def _size_along(pose: Transform, size: tuple[float, float, float]) -> tuple[float, float, float] | None:
    """Return the size of a box along the axes of a frame, in [m]; None if its sides are not parallel to them.

    Args:
        pose: pose of the box in the frame.
        size: size along the axes of the box, in [m].
    """
    turned = np.abs(pose[:3, :3])
    axes = np.round(turned)
    if np.abs(turned - axes).max() > MAX_TILT_SINE:
        return None
    along_x, along_y, along_z = (float(item) for item in axes @ np.asarray(size))
    return along_x, along_y, along_z
