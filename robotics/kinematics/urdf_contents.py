"""Contents of a URDF: joints with limits, links with masses, bodies, meshes."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.coal_bodies import hull_of_mesh, read_mesh, shape_of
from handcart.robotics.kinematics.shapes import Box, Cylinder, Shape, Sphere
from handcart.robotics.kinematics.urdf_frames import origin_of, triple
from handcart.robotics.kinematics.urdf_reading import known_urdf
from handcart.robotics.kinematics.urdf_tree import MOVABLE_KINDS
from handcart.robotics.numerics.arrays import FloatArray

INERTIA_ROUNDED = 1e-9
"""Share of the largest moment by which an inertia may violate a body's conditions, because of rounding."""


class JointFacts(NamedTuple):
    """Properties of a movable joint of a URDF, such as its kind, the link that it moves, and its limits."""

    name: str
    kind: str
    """revolute, continuous or prismatic."""
    child: str
    """Link that the joint moves."""
    lower: float | None
    """Lower limit, in [rad] or [m]; None without a limit."""
    upper: float | None
    """Upper limit, in [rad] or [m]; None without a limit."""
    velocity: float
    """Speed limit, in [rad/s] or [m/s]."""
    effort: float
    """Effort limit, in [Nm] or [N]."""


class LinkFacts(NamedTuple):
    """Name and mass properties of a link of a URDF."""

    name: str
    mass: float | None
    """Mass in [kg]; None if the URDF states none."""
    middle: FloatArray
    """Centre of mass (3,) in the link's frame, in [m]."""
    inertia: FloatArray
    """Inertia (3, 3) about the centre of mass, in [kg m²]."""


class MeshUse(NamedTuple):
    """Use of a mesh file by a link of a URDF, for the collision body or the visual appearance of the link."""

    link: str
    kind: str
    """collision or visual."""
    file: str
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Factor along each axis, without unit."""


def link_names(urdf_text: str) -> list[str]:
    """Return the names of all links of a URDF, in the order of its text.

    Raises:
        ValueError: the text is not a URDF.
    """
    return [match.get("name", "") for match in known_urdf(urdf_text).findall("link")]


def joints_of(urdf_text: str) -> list[JointFacts]:
    """Return the movable joints of a URDF, in the order of its text.

    Raises:
        ValueError: the text is not a URDF.
    """
    moving = [match for match in known_urdf(urdf_text).findall("joint") if match.get("type") in MOVABLE_KINDS]
    return [_joint(item) for item in moving]


def links_of(urdf_text: str) -> list[LinkFacts]:
    """Return name and mass properties of all links of a URDF, in the order of the text.

    Raises:
        ValueError: the text is not a URDF.
    """
    return [_link(match) for match in known_urdf(urdf_text).findall("link")]


def link_joints(urdf_text: str) -> list[tuple[str, str, str]]:
    """Return name, parent link and child link of all joints of a URDF, fixed ones too.

    Raises:
        ValueError: the text is not a URDF.
    """
    return [
        (match.get("name", ""), _end(match, "parent"), _end(match, "child"))
        for match in known_urdf(urdf_text).findall("joint")
    ]


def links_with_bodies(urdf_text: str) -> list[str]:
    """Return the names of those links of a URDF that have collision bodies.

    Raises:
        ValueError: the text is not a URDF.
    """
    links = known_urdf(urdf_text).findall("link")
    return [link.get("name", "") for link in links if link.find("collision") is not None]


def meshes_of(urdf_text: str) -> list[MeshUse]:
    """Return each use of a mesh file by a link of a URDF, in the order of the text.

    Raises:
        ValueError: the text is not a URDF.
    """
    return [
        MeshUse(link.get("name", ""), kind, mesh.get("filename", ""), _scale(mesh))
        for link in known_urdf(urdf_text).findall("link")
        for kind in ("collision", "visual")
        for mesh in link.iterfind(f"{kind}//mesh")
    ]


def bodies_of(urdf_text: str) -> list[Shape]:
    """Return the collision bodies of a URDF, each named after its link and posed in that link's frame.

    Raises:
        ValueError: a mesh can't be read, or encloses nothing.
    """
    return [
        _body(solid, origin_of(collision), link.get("name", ""))
        for link in known_urdf(urdf_text).findall("link")
        for collision in link.findall("collision")
        for solid in collision.iterfind("geometry/*")
    ]


def _body(solid: ElementTree.Element, pose: Transform, link: str) -> Shape:
    """Return the shape of one of the four kinds that a sound URDF has; only a mesh needs coal."""
    match solid.tag:
        case "box":
            return Box(pose, triple(solid, "size"), link)
        case "cylinder":
            return Cylinder(pose, _number(solid, "radius"), _number(solid, "length"), link)
        case "sphere":
            return Sphere(pose, _number(solid, "radius"), link)
    mesh = read_mesh(solid.get("filename", ""), _scale(solid))
    return shape_of(hull_of_mesh(mesh, link), pose, link)


def _end(joint: ElementTree.Element, tag: str) -> str:
    found = joint.find(tag)
    return "" if found is None else found.get("link", "")


def _joint(joint: ElementTree.Element) -> JointFacts:
    limit = joint.find("limit")
    kind = joint.get("type", "")
    bounded = limit is not None and kind != "continuous"
    return JointFacts(
        joint.get("name", ""),
        kind,
        _end(joint, "child"),
        _number(limit, "lower") if bounded else None,
        _number(limit, "upper") if bounded else None,
        _number(limit, "velocity"),
        _number(limit, "effort"),
    )


def _link(link: ElementTree.Element) -> LinkFacts:
    from scipy.spatial.transform import Rotation  # late: not all that reads a robot's file needs its masses

    inertial = link.find("inertial")
    if inertial is None:
        return LinkFacts(link.get("name", ""), None, np.zeros(3), np.zeros((3, 3)))
    origin, inertia = inertial.find("origin"), inertial.find("inertia")
    xx, xy, xz, yy, yz, zz = (_number(inertia, f"i{axes}") for axes in ("xx", "xy", "xz", "yy", "yz", "zz"))
    turn = Rotation.from_euler("xyz", triple(origin, "rpy")).as_matrix()
    own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    mass = _number(inertial.find("mass"), "value")
    return LinkFacts(link.get("name", ""), mass, np.array(triple(origin, "xyz")), turn @ own @ turn.T)


def _scale(mesh: ElementTree.Element) -> tuple[float, float, float]:
    try:
        x, y, z = map(float, mesh.get("scale", "1 1 1").split())
    except ValueError:  # the size of a visual mesh is not needed
        return 1.0, 1.0, 1.0
    return x, y, z


def _number(element: ElementTree.Element | None, key: str) -> float:
    return 0.0 if element is None else float(element.get(key, "0"))
