"""Driven wheels whose collision body is a mesh: they roll as discs."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Hull, Shape, bottom
from handcart.robotics.kinematics.urdf_contents import bodies_of
from handcart.robotics.kinematics.urdf_frames import link_poses, triple
from handcart.robotics.kinematics.urdf_reading import read_urdf
from handcart.robotics.numerics.arrays import FloatArray

WIDTH_RATIO = 0.4
"""Width of a disc as a share of its radius; a mesh's own width is unreliable, because some include motors."""
MIN_AXLE_COSINE = 0.9
"""Least absolute y of a wheel's axle as a unit vector in the base frame; below it, the wheel gets no disc."""


def with_round_wheels(urdf: str, wheels: Collection[str], tread: float) -> str:
    """Replace the collision meshes of driven wheels by discs.

    Engines use the convex hull of a mesh, which does not roll smoothly: it has facets, and some meshes
    include the motor. The disc turns about the joint's axis and reaches as far down as the mesh does with all
    joints at zero. The discs of both sides are `tread` apart, unless the meshes do not reach that far along
    the axle.

    Args:
        urdf: text of the robot's URDF; meshes named by absolute paths.
        wheels: joints that drive the robot.
        tread: distance between the wheels of the two sides, in [m].

    Raises:
        ValueError: a mesh can't be read, or encloses nothing.
    """
    robot, poses, bodies = read_urdf(urdf), link_poses(urdf), bodies_of(urdf)
    links = {match.get("name", ""): match for match in robot.findall("link")}
    base_T_root = np.linalg.inv(poses.get("base", np.eye(4)))
    for joint in robot.findall("joint"):
        child = joint.find("child")
        name = "" if child is None else child.get("link", "")
        hulls = [body for body in bodies if body.name == name and isinstance(body, Hull)]
        if joint.get("name") in wheels and hulls and len(hulls) == sum(body.name == name for body in bodies):
            disc = _disc(hulls, base_T_root @ poses[name], _axis(joint), tread)
            if disc is not None:
                _put_disc(links[name], *disc)
    return ElementTree.tostring(robot, encoding="unicode")


def _axis(joint: Element) -> FloatArray:
    axis = joint.find("axis")
    way = np.array([1.0, 0.0, 0.0] if axis is None else triple(axis, "xyz"))
    return np.asarray(way / np.linalg.norm(way))


def _disc(
    hulls: list[Hull], base_T_wheel: Transform, axis: FloatArray, tread: float
) -> tuple[FloatArray, FloatArray, float] | None:
    """Return a wheel's disc: middle (3,) in [m] and axis (3,) in the wheel's frame, and radius in [m].

    Args:
        hulls: convex hulls of the wheel's meshes.
        base_T_wheel: (4, 4) pose of the wheel's frame.
        axis: (3,) unit vector of the joint's axis in the wheel's frame.
        tread: distance between the wheels of the two sides, in [m].

    Returns:
        The disc; None for a wheel that is not upright.
    """
    across = float(base_T_wheel[1, :3] @ axis)
    if abs(across) < MIN_AXLE_COSINE:
        return None
    low = min(bottom(_posed(hull, base_T_wheel)) for hull in hulls)
    radius = float(base_T_wheel[2, 3]) - low
    along = np.concatenate(list(_corners(hulls))) @ axis
    y = float(base_T_wheel[1, 3])
    shift = (np.sign(y) * tread / 2 - y) / across
    return np.clip(shift, along.min(), along.max()) * axis, axis, radius


def _posed(hull: Hull, base_T_wheel: Transform) -> Shape:
    return Hull(base_T_wheel @ hull.pose, hull.points, hull.name)


def _corners(hulls: list[Hull]) -> Iterator[FloatArray]:
    """Yield the corners (n, 3) of each hull in the wheel's frame, in [m]."""
    return (hull.points @ hull.pose[:3, :3].T + hull.pose[:3, 3] for hull in hulls)


def _put_disc(link: Element, middle: FloatArray, axis: FloatArray, radius: float) -> None:
    for old in link.findall("collision"):
        link.remove(old)
    collision = SubElement(link, "collision")
    turn, _ = Rotation.align_vectors([axis], [[0.0, 0.0, 1.0]])
    rpy = turn.as_euler("xyz")
    words = {"xyz": " ".join(map(repr, middle.tolist())), "rpy": " ".join(map(repr, rpy.tolist()))}
    SubElement(collision, "origin", words)
    solid = SubElement(SubElement(collision, "geometry"), "cylinder")
    solid.set("radius", repr(radius))
    solid.set("length", repr(WIDTH_RATIO * radius))
