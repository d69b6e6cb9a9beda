"""Sensors that are not rigidly mounted where the rest of the program takes them to be."""

from __future__ import annotations

from typing import TYPE_CHECKING

from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.robotics.kinematics.urdf_contents import joints_of, link_names
from handcart.robotics.kinematics.urdf_mounts import joints_above, joints_between
from handcart.robotics.kinematics.urdf_tree import joint_leaders

if TYPE_CHECKING:
    from collections.abc import Iterator

    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document

    from .robot_file import RobotFile

FINGER_LINKS = ("left_finger", "right_finger")
ON_THE_BASE = ("range_sensor", "imu", "gps", "tray")
"""Frames whose pose in the base is computed once, with all joints at zero."""


def mount_findings(robot: RobotFile, urdf: str, document: Document) -> Iterator[Finding]:
    """Find a camera that moves against the hand, and sensors and a tray that move against the base.

    Args:
        robot: by its file.
        urdf: the URDF of the complete robot.
        document: the robot's file.
    """
    links = link_names(urdf)
    if robot.camera is not None and robot.arm is not None and {"camera", "hand"} <= set(links):
        between = joints_between(urdf, "camera", "hand")
        if between:
            allowed = "a camera fixed on the hand; without the section `camera` the robot can be used"
            wrong = f"{_named(robot, between)} between the links `camera` and `hand`"
            yield document.finding(_key(robot, "camera"), f"{wrong}; allowed: {allowed}")
    moved = _moved_joints(robot, urdf)
    for role in ON_THE_BASE:
        if role not in links or (role != "tray" and getattr(robot, role) is None):
            continue
        found = [name for name in joints_above(urdf, role) if name in moved]
        if found:
            wrong = f"{_named(robot, found)} between the links `base` and {role!r}"
            yield document.finding(_key(robot, role), f"{wrong}; allowed: one fixed on the base")


def _moved_joints(robot: RobotFile, urdf: str) -> set[str]:
    """The joints that a run moves: of arm, fingers and wheels, and those that follow them."""
    names = [each.name for each in joints_of(urdf)]
    own = {*(robot.arm.joints if robot.arm else ()), *FINGER_LINKS, *driven_wheels(names).all}
    return own | {name for name, (leader, *_) in joint_leaders(urdf).items() if leader in own}


def _key(robot: RobotFile, role: str) -> tuple[str | int, ...]:
    if role in robot.links:
        return ("links", role)
    return ("urdf",) if role == "tray" else (role,)


def _named(robot: RobotFile, joints: list[str]) -> str:
    """The joints in words, each with its line in the URDF."""
    shown = []
    for name in joints:
        place = robot.whole.places.get(("joint", name))
        shown.append(f"{name!r}" + ("" if place is None else f" ({place.file}:{place.line})"))
    moves = "the joint" if len(shown) == 1 else "the joints"
    return f"{moves} {', '.join(shown)} {'is' if len(shown) == 1 else 'are'}"
