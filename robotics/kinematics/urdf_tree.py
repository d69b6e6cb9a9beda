"""Changes to a URDF before it is given to a kinematics library."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from functools import lru_cache
from xml.etree import ElementTree

import numpy as np

from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.kinematics.urdf_reading import known_urdf, read_urdf
from handcart.robotics.numerics.arrays import FloatArray

MOVABLE_KINDS = ("revolute", "continuous", "prismatic")
_FREE = ("floating", "planar")
_OF_JOINT = ("origin", "parent", "child", "axis", "limit", "mimic")
_WORDS = ("name", "type", "link", "joint", "filename")
_SPECK = 1e-300  # the parser behind Pinocchio rejects smaller numbers

Element = ElementTree.Element


class FollowingJoint(ValueError):
    """Error for a position that is given to a joint that mimics another one and so has no free position."""

    def __init__(self, joint: str, leader: str) -> None:
        self.joint = joint
        super().__init__(f"{joint!r} follows {leader!r} (mimic); allowed: joints that move by themselves")


def urdf_of_arm(urdf_text: str, moving: Collection[str], standing: Mapping[str, float]) -> str:
    """Return the URDF with only the joints `moving`, and the joints that follow one of them, movable.

    Args:
        urdf_text: the URDF.
        moving: names of movable joints that follow no other one.
        standing: positions at which other joints are fixed, in [rad] or [m], by name; 0 if missing.

    Raises:
        ValueError: the text is not a URDF, or has no such movable joint; or one of `moving` follows another.
    """
    return _urdf_of_arm(urdf_text, tuple(moving), tuple(standing.items()))


@lru_cache(maxsize=64)  # a program asks for the same few arms again and again: fingers open, fingers closed
def _urdf_of_arm(urdf_text: str, moving: tuple[str, ...], standing_at: tuple[tuple[str, float], ...]) -> str:
    robot, standing = _kinematic(known_urdf(urdf_text)), dict(standing_at)
    joints = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    movable = [name for name, joint in joints.items() if joint.get("type") in MOVABLE_KINDS]
    if missing := [name for name in (*moving, *standing) if name not in movable]:
        raise ValueError(f"the URDF has no movable joint {missing[0]!r}; it has {', '.join(movable)}")
    leaders = _leaders(joints)
    if led := [name for name in moving if name in leaders]:
        raise ValueError(f"the joint {led[0]!r} follows {leaders[led[0]][0]!r} and can't be moved by itself")
    for name in movable:
        leader, factor, offset = leaders.get(name, (name, 1.0, 0.0))
        if leader in moving:
            if joints[name].get("type") == "continuous":
                _bound(joints[name])
            _free(joints[name])
        else:
            _fix(joints[name], standing.get(name, factor * standing.get(leader, 0.0) + offset))
    return _text(robot)


def with_still_joints(urdf_text: str, positions: Mapping[str, float]) -> str:
    """Return the URDF with some joints fixed, and with them all joints that mimic one of them.

    Args:
        urdf_text: the URDF.
        positions: positions of the joints to fix, in [rad] or [m], by name.

    Raises:
        FollowingJoint: `positions` names a joint that mimics another one.
    """
    robot = read_urdf(urdf_text)
    joints = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    leaders = _leaders(joints)
    for name, value in positions.items():
        if name in leaders:
            raise FollowingJoint(name, leaders[name][0])
        _fix(joints[name], value)
    for name, (leader, factor, offset) in leaders.items():
        if leader in positions:
            _fix(joints[name], factor * positions[leader] + offset)
    return _text(robot)


def followers_of(urdf_text: str, moving: Collection[str]) -> dict[str, tuple[str, float, float]]:
    """Return leader, factor and offset, by name, of each joint that follows one of `moving`.

    The joint's position is factor times the leader's position plus offset, in [rad] or [m].

    Raises:
        ValueError: the text is not a URDF.
    """
    leaders = joint_leaders(urdf_text)
    return {name: led for name, led in leaders.items() if led[0] in moving and name not in moving}


def joint_leaders(urdf_text: str) -> dict[str, tuple[str, float, float]]:
    """Return for the name of each joint that mimics another: its leader, a factor and an offset.

    The joint's position is factor times the leader's position plus offset, in [rad] or [m]. If a leader
    mimics another joint, that joint is the leader, and so on. A joint that mimics a missing joint is not
    included.

    Raises:
        ValueError: the text is not a URDF.
    """
    return _leaders({joint.get("name", ""): joint for joint in known_urdf(urdf_text).findall("joint")})


def _leaders(joints: Mapping[str, Element]) -> dict[str, tuple[str, float, float]]:
    found = {}
    for name, joint in joints.items():
        leader, factor, offset = name, 1.0, 0.0
        seen = {name}
        while (mimic := joints[leader].find("mimic")) is not None and mimic.get("joint") in joints:
            offset += factor * float(mimic.get("offset", "0"))
            factor *= float(mimic.get("multiplier", "1"))
            leader = mimic.get("joint", "")
            if leader in seen:
                break
            seen.add(leader)
        if leader != name and {joint.get("type"), joints[leader].get("type")} <= set(MOVABLE_KINDS):
            found[name] = (leader, factor, offset)
    return found


def _kinematic(robot: Element) -> Element:
    result = Element("robot", {"name": robot.get("name") or "robot"})
    for link in robot.findall("link"):
        kept = ElementTree.SubElement(result, "link", {"name": link.get("name", "")})
        kept.extend(_copied(item) for item in link if item.tag in ("inertial", "collision"))
    for joint in robot.findall("joint"):
        kind = joint.get("type", "")
        names = {"name": joint.get("name", ""), "type": "fixed" if kind in _FREE else kind}
        kept = ElementTree.SubElement(result, "joint", names)
        kept.extend(_copied(item) for item in joint if item.tag in _OF_JOINT)
        for limit in kept.findall("limit"):  # urdfdom asks for both, of joints without end too
            limit.attrib = {"effort": "0", "velocity": "0", **limit.attrib}
    return result


def _copied(element: Element) -> Element:
    """Return a copy whose numbers read the same for every parser."""
    copy = Element(element.tag)
    for key, value in element.attrib.items():
        copy.set(key, value if key in _WORDS else " ".join(_plain(word) for word in value.split()))
    copy.extend(_copied(item) for item in element)
    return copy


def _plain(word: str) -> str:
    try:
        number = float(word)
    except ValueError:
        return word
    return repr(number if abs(number) > _SPECK else 0.0)


def _text(robot: Element) -> str:
    return ElementTree.tostring(robot, encoding="unicode")


def _fix(joint: Element, value: float) -> None:
    kind = joint.get("type")
    joint.set("type", "fixed")
    _free(joint)
    if value == 0.0:
        return
    origin, tag = joint.find("origin"), joint.find("axis")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    axis = _numbers(None if tag is None else tag.get("xyz"), "1 0 0")
    turn = pin.rpy.rpyToMatrix(_numbers(origin.get("rpy"), "0 0 0"))
    motion = value * axis / np.linalg.norm(axis)
    if kind == "prismatic":
        shift = _numbers(origin.get("xyz"), "0 0 0") + turn @ motion
        origin.set("xyz", _words(shift))
    else:
        origin.set("rpy", _words(pin.rpy.matrixToRpy(turn @ pin.exp3(motion))))


def _free(joint: Element) -> None:
    """Remove the `mimic` elements of a joint."""
    for mimic in joint.findall("mimic"):
        joint.remove(mimic)


def _numbers(text: str | None, default: str) -> FloatArray:
    return np.array([float(word) for word in (text or default).split()])


def _words(numbers: FloatArray) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def _bound(joint: Element) -> None:
    joint.set("type", "revolute")
    limit = joint.find("limit")
    if limit is None:
        limit = ElementTree.SubElement(joint, "limit")
    limit.set("effort", limit.get("effort", "0"))
    limit.set("velocity", limit.get("velocity", "0"))
    limit.set("lower", repr(-math.pi))
    limit.set("upper", repr(math.pi))
