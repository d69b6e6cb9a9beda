"""Joints of a URDF that move a link, or one link against another."""

from __future__ import annotations

from handcart.robotics.kinematics.urdf_reading import known_urdf
from handcart.robotics.kinematics.urdf_tree import MOVABLE_KINDS


def joints_above(urdf_text: str, link: str) -> list[str]:
    """Return the names of the joints that move a link, in the order from the root to the link.

    Args:
        urdf_text: URDF without faults.
        link: name of a link; an unknown one gives an empty list.

    Raises:
        ValueError: the text is not a URDF.
    """
    above = {}
    for joint in known_urdf(urdf_text).findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            above[child.get("link", "")] = joint, parent.get("link", "")
    found = []
    while link in above:
        joint, link = above[link]
        if joint.get("type") in MOVABLE_KINDS:
            found.append(joint.get("name", ""))
    return found[::-1]


def joints_between(urdf_text: str, link: str, other: str) -> list[str]:
    """Return the names of all joints between two links, which change the pose of one link relative to the
    other.

    These are the joints from each link up to the last link that carries both.

    Args:
        urdf_text: URDF without faults.
        link: name of a link; its joints come first.
        other: name of another link.

    Raises:
        ValueError: the text is not a URDF.
    """
    own, others = joints_above(urdf_text, link), joints_above(urdf_text, other)
    return [name for name in own if name not in others] + [name for name in others if name not in own]
