"""A robot's URDF with a suspension between its wheels and its body."""

from __future__ import annotations

import copy
from collections.abc import Collection
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

CHASSIS_LINK = "chassis"
"""Link that wheels and casters are on."""
PITCH, ROLL = "suspension_pitch", "suspension_roll"
"""Joints by which the base leans on the chassis, pitch first."""
UNSPRUNG_MASS_RATIO = 0.2  # of the base's mass
_PITCHED, _LEANING = "suspension_pitched", "suspension_leaning"
_MASSES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz", "value")


def sprung(urdf: str, pivot: float, rolling: Collection[str]) -> str:
    """Return a robot's URDF with a suspension, which is a new link (the chassis) below the base, and joints
    for roll and pitch between both.

    Mass and dimensions do not change.

    Args:
        urdf: a robot whose root is the link `base`.
        pivot: height of the tilt axis, in [m].
        rolling: names of the links that hang on the chassis instead of on the base, such as wheels.
    """
    robot = ElementTree.fromstring(urdf)
    base = next(link for link in robot.findall("link") if link.get("name") == "base")
    chassis = SubElement(robot, "link", name=CHASSIS_LINK)
    inertial = base.find("inertial")
    if inertial is not None:
        chassis.append(_scaled(inertial, UNSPRUNG_MASS_RATIO))
        base.remove(inertial)
        base.append(_scaled(inertial, 1.0 - UNSPRUNG_MASS_RATIO))
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None or parent.get("link") != "base":
            continue
        if child.get("link") in rolling:
            parent.set("link", CHASSIS_LINK)
    for name in (_PITCHED, _LEANING):
        SubElement(robot, "link", name=name)
    _join(robot, PITCH, (CHASSIS_LINK, _PITCHED), pivot, "0 1 0")
    _join(robot, ROLL, (_PITCHED, _LEANING), 0.0, "1 0 0")
    _join(robot, "suspension_mount", (_LEANING, "base"), -pivot, None)
    return ElementTree.tostring(robot, encoding="unicode")


def _scaled(inertial: Element, share: float) -> Element:
    result = copy.deepcopy(inertial)
    for part in result:
        for name in _MASSES:
            if part.get(name) is not None:
                part.set(name, repr(share * float(part.get(name, "0"))))
    return result


def _join(robot: Element, name: str, links: tuple[str, str], up: float, axis: str | None) -> None:
    """Join two links by a continuous joint about `axis`, or by a fixed joint if that is None.

    Args:
        robot: the URDF's root element.
        name: name of the joint.
        links: parent and child.
        up: height of the child's origin above the parent's, in [m].
        axis: axis of the joint as in a URDF, such as "1 0 0".
    """
    joint = SubElement(robot, "joint", name=name, type="fixed" if axis is None else "continuous")
    SubElement(joint, "parent", link=links[0])
    SubElement(joint, "child", link=links[1])
    SubElement(joint, "origin", xyz=f"0 0 {up!r}")
    if axis is not None:
        SubElement(joint, "axis", xyz=axis)
