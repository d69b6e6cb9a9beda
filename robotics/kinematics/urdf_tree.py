"""Changes to a URDF before it is given to a kinematics library."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

_MOVABLE = ("revolute", "continuous", "prismatic")


def urdf_of_arm(urdf_text: str, moving: Collection[str], standing: Mapping[str, float]) -> str:
    """The URDF with only the joints `moving` left movable.

    Every other joint becomes fixed where it stands: at `standing[name]` in [rad] or [m], else at zero.
    A moving continuous joint becomes a revolute one limited to -pi to pi: Pinocchio would describe it by a
    cosine and a sine, and we want one number a joint. Visual bodies are left out.

    Raises:
        ValueError: the text is not XML, or one of the names is no movable joint of it.
    """
    try:
        robot = ElementTree.fromstring(urdf_text)
    except ElementTree.ParseError as error:
        raise ValueError(f"the URDF is not well-formed: {error}") from error
    joints = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    movable = [name for name, joint in joints.items() if joint.get("type") in _MOVABLE]
    if missing := [name for name in (*moving, *standing) if name not in movable]:
        raise ValueError(f"the URDF has no movable joint {missing[0]!r}; it has {', '.join(movable)}")
    for name in movable:
        if name not in moving:
            _fix(joints[name], standing.get(name, 0.0))
        elif joints[name].get("type") == "continuous":
            _bound(joints[name])
    for link in robot.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    return ElementTree.tostring(robot, encoding="unicode")


def _fix(joint: ElementTree.Element, value: float) -> None:
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    turn = Rotation.from_euler("xyz", _numbers(origin.get("rpy"), "0 0 0"))
    shift = _numbers(origin.get("xyz"), "0 0 0")
    axis_tag = joint.find("axis")
    axis = _numbers(None if axis_tag is None else axis_tag.get("xyz"), "1 0 0")
    if joint.get("type") == "prismatic":
        shift = shift + turn.apply(value * axis)
    else:
        turn = turn * Rotation.from_rotvec(value * axis)
    joint.set("type", "fixed")
    origin.set("xyz", " ".join(repr(float(number)) for number in shift))
    origin.set("rpy", " ".join(repr(float(number)) for number in turn.as_euler("xyz")))


def _numbers(text: str | None, default: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([float(word) for word in (text or default).split()])


def _bound(joint: ElementTree.Element) -> None:
    joint.set("type", "revolute")
    limit = joint.find("limit")
    if limit is None:
        limit = ElementTree.SubElement(joint, "limit", {"effort": "0", "velocity": "0"})
    limit.set("lower", repr(-math.pi))
    limit.set("upper", repr(math.pi))
