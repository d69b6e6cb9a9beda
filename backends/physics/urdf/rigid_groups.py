"""Links of a robot that cannot collide with each other, and links that must not collide with the floor."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.shapes import Shape, bottom
from handcart.robotics.kinematics.urdf_contents import bodies_of, joints_of, link_joints, links_with_bodies
from handcart.robotics.kinematics.urdf_frames import link_poses

Pair = tuple[str, str]
_BASE = "base"


def passing_pairs(urdf: str, still: Collection[str]) -> Iterator[Pair]:
    """Yield the pairs of links between which collisions are not simulated; `CollisionModel` excludes the same
    pairs.

    These are links that cannot move relative to each other, because all joints between them are fixed or held
    still, and links that are connected by one moving joint.

    Args:
        urdf: text of the robot's URDF.
        still: joints that can move by the URDF, but are held at their positions.
    """
    carrier = _carriers(urdf)
    group = {link: _carried_by(link, carrier, _moving(urdf, still)) for link in links_with_bodies(urdf)}
    moved = {link for link in group.values() if link in carrier}
    above = {link: _carried_by(carrier[link][1], carrier, _moving(urdf, still)) for link in moved}
    for one, other in combinations(sorted(group), 2):
        a, b = group[one], group[other]
        if a == b or above.get(a) == b or above.get(b) == a:
            yield one, other


def floor_T_body_links(urdf: str, rolling: Collection[str]) -> dict[str, Transform]:
    """Return the poses floor_T_link (4, 4), by name, of all links that are rigidly connected to the base.

    Links in `rolling` are left out.

    Args:
        urdf: text of the robot's URDF.
        rolling: links that roll or slide on the floor; the lowest point of all of them is at z = 0, the
            floor.
    """
    poses, carrier = link_poses(urdf), _carriers(urdf)
    moving = _moving(urdf, ())
    floor_T_root = inverse(poses[_BASE]) if _BASE in poses else np.eye(4)
    wheels = [item for item in bodies_of(urdf) if item.name in rolling]
    heights = [_bottom_at(floor_T_root @ poses[wheel.name], wheel) for wheel in wheels]
    floor_T_root[2, 3] -= min(heights, default=0.0)
    base = _carried_by(_BASE, carrier, moving)
    return {
        link: floor_T_root @ poses[link]
        for link in links_with_bodies(urdf)
        if link not in rolling and _carried_by(link, carrier, moving) == base
    }


def _bottom_at(floor_T_link: Transform, body: Shape) -> float:
    return bottom(replace(body, pose=floor_T_link @ body.pose))


def _carriers(urdf: str) -> dict[str, tuple[str, str]]:
    """Return, for each link by name, the joint that moves it and the link to which that joint is attached."""
    return {child: (joint, parent) for joint, parent, child in link_joints(urdf)}


def _moving(urdf: str, still: Collection[str]) -> set[str]:
    return {item.name for item in joints_of(urdf)} - set(still)


def _carried_by(link: str, carrier: Mapping[str, tuple[str, str]], moving: Collection[str]) -> str:
    """Return the first link of the rigid group of a link; it carries all other links of the group."""
    while link in carrier and carrier[link][0] not in moving:
        link = carrier[link][1]
    return link
