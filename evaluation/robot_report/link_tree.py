"""Links and joints of a URDF as a tree, with poses for all joints at zero."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from handcart.robotics.kinematics.urdf_contents import joints_of
from handcart.robotics.kinematics.urdf_frames import link_poses
from handcart.robotics.kinematics.urdf_reading import known_urdf
from handcart.robotics.kinematics.urdf_tree import joint_leaders
from handcart.robotics.numerics.arrays import FloatArray


class LinkTree:
    """Links and joints of a valid URDF as a tree, with poses for all joints at zero.

    Attributes:
        child, parent: name of the child or parent link, by name of the joint.
        above: name of the joint that carries a link, by name of the link.
        links: names of the links in the file's order.
        root: name of the link that carries all others.
        moving: facts of the movable joints, by name.
        led: leader, factor and offset of the joints that mimic another one, by name.
        pose: root_T_link (4, 4), by name of the link.
        axis: unit vector (3,) of the axis in the child link, by name of the joint.
    """

    def __init__(self, urdf_text: str) -> None:
        robot = known_urdf(urdf_text)
        joints = robot.findall("joint")
        self.child = {joint.get("name", ""): _end(joint, "child") for joint in joints}
        self.parent = {joint.get("name", ""): _end(joint, "parent") for joint in joints}
        self.above = {self.child[name]: name for name in self.child}
        self.links = [match.get("name", "") for match in robot.findall("link")]
        self.root = next(name for name in self.links if name not in self.above)
        self.moving = {item.name: item for item in joints_of(urdf_text)}
        self.led = joint_leaders(urdf_text)
        self.pose = link_poses(urdf_text)
        self.axis = {joint.get("name", ""): _axis(joint.find("axis")) for joint in joints}

    def moved_by(self, link: str) -> list[str]:
        """Return all joints that move a link, in order from the root."""
        found = []
        while link in self.above:
            joint = self.above[link]
            if joint in self.moving:
                found.append(joint)
            link = self.parent[joint]
        return found[::-1]

    def chain(self, link: str) -> list[str]:
        """Return the joints that move a link, in order from the root, without joints that mimic others."""
        return [joint for joint in self.moved_by(link) if joint not in self.led]

    def carried(self, link: str) -> list[str]:
        """Return a link and all links that are fixed to it, directly or through other links."""
        found = [link]
        for item in found:
            found += [self.child[j] for j in self.child if self.parent[j] == item and j not in self.moving]
        return found

    def moved_from(self, link: str) -> list[str]:
        """Return the movable joints whose parent is a link or another link that is fixed to this link."""
        body = set(self.carried(link))
        return [joint for joint in self.moving if self.parent[joint] in body]


def _end(joint: ElementTree.Element, tag: str) -> str:
    found = joint.find(tag)
    return "" if found is None else found.get("link", "")


def _axis(element: ElementTree.Element | None) -> FloatArray:
    words = "1 0 0" if element is None else element.get("xyz", "1 0 0")
    axis = np.array([float(word) for word in words.split()])
    return axis / max(1e-9, float(np.linalg.norm(axis)))
