"""The URDF of a robot as MuJoCo reads it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.backends.physics.urdf.sound_urdf import SoundUrdf
from handcart.robotics.kinematics.coal_bodies import read_mesh

READABLE_SUFFIXES = (".stl", ".obj")
"""Mesh files that MuJoCo reads itself."""


def read_robot(urdf: SoundUrdf, visuals: bool = False) -> Any:
    """Read a robot's URDF into MuJoCo's `MjSpec`, with a body for each link.

    Args:
        urdf: URDF of the robot.
        visuals: whether the result contains visual shapes as well.

    Raises:
        ValueError: MuJoCo can't read the URDF.
    """
    spec = mujoco().MjSpec.from_string(_without_a_world(urdf.text))
    spec.compiler.fusestatic, spec.compiler.discardvisual = False, not visuals
    for mesh in spec.meshes:
        if mesh.file in urdf.hulls:
            mesh.uservert = urdf.hulls[mesh.file].points.ravel()
            mesh.file = ""
            mesh.inertia = mujoco().mjtMeshInertia.mjMESH_INERTIA_CONVEX
        elif visuals and Path(mesh.file).suffix.lower() not in READABLE_SUFFIXES:
            mesh.uservert, mesh.userface = _triangles(mesh.file)
            mesh.file = ""
    return spec


def _triangles(file: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a mesh file's corners (3 n,), x, y, z of each in [m], and triangles (3 m,), three corner numbers
    each.
    """
    mesh: Any = read_mesh(file)
    triangles = (mesh.tri_indices(number) for number in range(mesh.num_tris))
    faces = np.array([[triangle[0], triangle[1], triangle[2]] for triangle in triangles], dtype=np.int32)
    return np.array(mesh.vertices()).ravel(), faces.ravel()


def _without_a_world(urdf: str) -> str:
    """Rename the link that has the name which MuJoCo keeps for the world's body."""
    robot = ElementTree.fromstring(urdf)
    for element in _named_links(robot):
        key = "name" if element.tag == "link" else "link"
        if element.get(key) == "world":
            element.set(key, "world_")
    return ElementTree.tostring(robot, encoding="unicode")


def _named_links(robot: ElementTree.Element) -> Iterator[ElementTree.Element]:
    return (item for item in robot.iter() if item.tag in ("link", "parent", "child"))
