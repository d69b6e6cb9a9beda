"""URDFs without some of their joints, and everything that these carry."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree

from handcart.robotics.kinematics.urdf_reading import read_urdf


class UnknownJoint(ValueError):
    """Error of a joint that should be removed but is not in the URDF."""

    def __init__(self, joint: str, known: Sequence[str]) -> None:
        self.joint, self.known = joint, tuple(known)
        super().__init__(f"the URDF has no joint {joint!r}; allowed: {', '.join(known)}")


def without_joints(urdf_text: str, names: Sequence[str]) -> str:
    """Return a URDF without the joints called `names` and everything that these joints carry.

    Raises:
        ValueError: the text is not a URDF.
        UnknownJoint: the URDF has no such joint.
    """
    if not names:
        return urdf_text
    robot = read_urdf(urdf_text)
    prune(robot, names)
    return ElementTree.tostring(robot, encoding="unicode")


def prune(robot: ElementTree.Element, names: Sequence[str]) -> None:
    """Remove some joints, and all links and joints behind them, from a URDF.

    Args:
        robot: root element of the URDF.
        names: names of the joints.

    Raises:
        UnknownJoint: the URDF has no such joint.
    """
    joints = {match.get("name", ""): match for match in robot.findall("joint")}
    for name in names:
        if name not in joints:
            raise UnknownJoint(name, list(joints))
    gone = {_end(joints[name], "child") for name in names}
    while more := {_end(joint, "child") for joint in joints.values() if _end(joint, "parent") in gone} - gone:
        gone |= more
    for element in list(robot):
        link = element.get("name") if element.tag == "link" else _end(element, "child")
        if element.tag in ("link", "joint") and link in gone:
            robot.remove(element)


def _end(joint: ElementTree.Element, end: str) -> str:
    """Return the link at the `parent` or the `child` end of a joint."""
    found = joint.find(end)
    return "" if found is None else found.get("link", "")
