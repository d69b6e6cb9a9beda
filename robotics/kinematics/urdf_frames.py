"""Poses of the links of a URDF with all its joints at zero, computed from origins without any library."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.urdf_reading import known_urdf

Triple = tuple[float, float, float]


def origin_of(element: ElementTree.Element) -> Transform:
    """Return the pose (4, 4) that the `origin` of a URDF element states, such as a joint's in its parent
    link.
    """
    origin = element.find("origin")
    return np.eye(4) if origin is None else transform(triple(origin, "xyz"), triple(origin, "rpy"))


def link_poses(urdf_text: str) -> dict[str, Transform]:
    """Return the pose (4, 4) of each link in the root link, with all joints at zero.

    Raises:
        ValueError: the text is not a URDF.
    """
    robot = known_urdf(urdf_text)
    above = {_end(joint, "child"): joint for joint in robot.findall("joint")}
    found: dict[str, Transform] = {}
    for link in robot.findall("link"):
        name, way = link.get("name", ""), []
        while name not in found and name in above:
            way.append(name)
            name = _end(above[name], "parent")
        pose = found.setdefault(name, np.eye(4))
        for name in reversed(way):
            pose = found[name] = pose @ origin_of(above[name])
    return found


def base_T_frame(urdf_text: str, frame: str, base: str = "base") -> Transform:
    """Return the pose (4, 4) of the link `frame` in the link `base` of a URDF, with all joints at zero.

    Raises:
        ValueError: the text is not a URDF, or has no such link.
    """
    poses = link_poses(urdf_text)
    if missing := [name for name in (frame, base) if name not in poses]:
        raise ValueError(f"the URDF has no link {missing[0]!r}")
    return inverse(poses[base]) @ poses[frame]


def triple(element: ElementTree.Element | None, key: str) -> Triple:
    """Return the three numbers of an attribute such as `xyz`; zeros if the element or the attribute is
    missing.
    """
    x, y, z = map(float, ("0 0 0" if element is None else element.get(key, "0 0 0")).split())
    return x, y, z


def _end(joint: ElementTree.Element, tag: str) -> str:
    found = joint.find(tag)
    return "" if found is None else found.get("link", "")
