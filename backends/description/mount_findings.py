"""Sensors that are mounted where a joint moves them without the program knowing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.robotics.kinematics.urdf_contents import joints_of, link_names
from handcart.robotics.kinematics.urdf_mounts import joints_above
from handcart.robotics.kinematics.urdf_tree import joint_leaders

if TYPE_CHECKING:
    from collections.abc import Iterator

    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document
    from handcart.files.yaml.yaml_node import KeyPath

    from .robot_file import RobotFile

FINGER_LINKS = ("left_finger", "right_finger")


def mount_findings(robot: RobotFile, urdf: str, document: Document) -> Iterator[Finding]:
    """Yield findings on sensors whose pose on the base is unknown, and on a tray that can move on the base.

    A sensor's pose is unknown if a joint between base and sensor moves without being measured.

    Args:
        robot: robot file.
        urdf: text of the robot's URDF.
        document: the robot's file, for the places of the findings.
    """
    links = link_names(urdf)
    moved, read = _moved_joints(robot, urdf), _read_joints(robot, urdf)
    for name, spec in robot.sensors.items():
        link = robot.link_of(spec)
        if link not in links:
            continue
        above = joints_above(urdf, link)
        if spec.CARRIER == "any":
            if unread := [joint for joint in above if joint not in read]:
                wrong = f"{_named(robot, unread)} between the links `base` and {link!r}, and nothing reads "
                wrong += "it" if len(unread) == 1 else "them"
                allowed = "a sensor behind joints of the section `arm` only"
                yield document.finding(_key(robot, name, link), f"{wrong}; allowed: {allowed}")
        elif found := [joint for joint in above if joint in moved]:
            yield _moves(robot, found, link, document, _key(robot, name, link))
    if "tray" in links and (found := [joint for joint in joints_above(urdf, "tray") if joint in moved]):
        key = ("links", "tray") if "tray" in robot.links else ("urdf",)
        yield _moves(robot, found, "tray", document, key)


def _moves(robot: RobotFile, joints: list[str], link: str, document: Document, key: KeyPath) -> Finding:
    wrong = f"{_named(robot, joints)} between the links `base` and {link!r}"
    return document.finding(key, f"{wrong}; allowed: one fixed on the base")


def _read_joints(robot: RobotFile, urdf: str) -> set[str]:
    """Return the joints whose positions are read: the arm's, and those that follow them."""
    own = set(robot.arm.joints if robot.arm else ())
    return own | {name for name, (leader, *_) in joint_leaders(urdf).items() if leader in own}


def _moved_joints(robot: RobotFile, urdf: str) -> set[str]:
    """Return the joints that a run moves: of arm, fingers and wheels, and those that follow them."""
    names = [item.name for item in joints_of(urdf)]
    own = {*(robot.arm.joints if robot.arm else ()), *FINGER_LINKS, *driven_wheels(names).all}
    return own | {name for name, (leader, *_) in joint_leaders(urdf).items() if leader in own}


def _key(robot: RobotFile, name: str, link: str) -> KeyPath:
    """Return the key path in the robot's file that mounts a sensor at a link."""
    if link in robot.links:
        return ("links", link)
    key = robot.key_of(name)
    return (*key, "frame") if getattr(robot.sensors[name], "frame", None) else key


def _named(robot: RobotFile, joints: list[str]) -> str:
    """Return the joints in words, each with its line in the URDF."""
    shown = []
    for name in joints:
        place = robot.whole.places.get(("joint", name))
        shown.append(f"{name!r}" + ("" if place is None else f" ({place.file}:{place.line})"))
    moves = "the joint" if len(shown) == 1 else "the joints"
    return f"{moves} {', '.join(shown)} {'is' if len(shown) == 1 else 'are'}"
