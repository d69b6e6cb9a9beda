"""Collision meshes of a URDF as convex hulls, which every engine takes whatever the mesh's format was."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.coal_bodies import hull_of_mesh, read_mesh
from handcart.robotics.kinematics.urdf_frames import origin_of
from handcart.robotics.kinematics.urdf_reading import read_urdf
from handcart.robotics.numerics.arrays import FloatArray, IntArray


class HullMesh(NamedTuple):
    """Convex hull of a collision mesh, as triangles; the scale in the URDF is already applied."""

    points: FloatArray
    """Corners (n, 3) in the mesh's frame, in [m]."""
    faces: IntArray
    """Triangles (m, 3) as indices of `points`, counter-clockwise as seen from outside."""

    def obj(self) -> str:
        """Return the hull as a Wavefront OBJ file."""
        corners = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in self.points.tolist())
        return corners + "".join(f"f {a} {b} {c}\n" for a, b, c in (self.faces + 1).tolist())


REACHES_DOWN_M = 0.003
"""Height above the floor, in [m], below which a body would drag on the floor when the base sinks a little."""
FLOOR_CLEARANCE_M = 0.01
"""Height above the floor, in [m], to which the lower parts of such bodies are lifted."""


class HullUrdf(NamedTuple):
    """URDF whose collision meshes were replaced by their convex hulls, and these hulls."""

    text: str
    """The URDF, in which each collision mesh has a hull's name as its `filename`, and no scale."""
    hulls: Mapping[str, HullMesh]
    """Convex hulls, by the mesh name that the URDF uses."""
    cut: Sequence[str]
    """Links whose mesh reached down to the floor."""


def with_hulls(urdf_text: str, floor_T_links: Mapping[str, Transform] | None = None) -> HullUrdf:
    """Replace the collision meshes of a URDF by their convex hulls; meshes are named by absolute paths.

    Kinematics and motion planning check the same hulls, so that all backends collide alike.

    Args:
        urdf_text: URDF of the robot.
        floor_T_links: pose (4, 4) above the floor (z = 0) of each link that must not touch the floor, by
            name; points of their hulls that reach down to the floor are lifted. This happens if the base's
            mesh includes wheels and casters.

    Raises:
        ValueError: a mesh cannot be read, or encloses no volume.
    """
    robot, maker = read_urdf(urdf_text), _Hulls()
    for link in robot.findall("link"):
        name = link.get("name", "")
        for collision in link.findall("collision"):
            for mesh in collision.iterfind("geometry/mesh"):
                hull = maker.of_mesh(mesh.get("filename", ""), mesh.attrib.pop("scale", "1 1 1"), name)
                if floor_T_links is not None and name in floor_T_links:
                    hull = maker.off_the_floor(hull, floor_T_links[name] @ origin_of(collision), name)
                mesh.set("filename", hull)
    used = {mesh.get("filename", "") for mesh in robot.iterfind("link/collision/geometry/mesh")}
    hulls = {name: hull for name, hull in maker.hulls.items() if name in used}
    return HullUrdf(ElementTree.tostring(robot, encoding="unicode"), hulls, maker.cut)


class _Hulls:
    """The hulls of a robot as they are made."""

    def __init__(self) -> None:
        self.hulls: dict[str, HullMesh] = {}
        self.cut: list[str] = []
        self._names: dict[tuple[str, str], str] = {}

    def of_mesh(self, file: str, scale: str, link: str) -> str:
        """Return the name of a mesh's hull, computed once; links that have the same mesh and scale share it.

        Args:
            file: path of the mesh.
            scale: its attribute `scale` in the URDF.
            link: link that has the mesh, for messages.
        """
        if (file, scale) not in self._names:
            self._names[file, scale] = self._add(_hull(file, scale, link))
        return self._names[file, scale]

    def off_the_floor(self, name: str, floor_T_mesh: Transform, link: str) -> str:
        """Return the name of the hull, or of a copy that doesn't reach down to the floor.

        Args:
            name: name of the hull.
            floor_T_mesh: (4, 4) pose of the mesh's frame above the floor (z = 0).
            link: link that has the hull.
        """
        shorter = _off_the_floor(self.hulls[name], floor_T_mesh)
        if shorter is None:
            return name
        self.cut.append(link)
        return self._add(shorter)

    def _add(self, hull: HullMesh) -> str:
        name = f"hull_{len(self.hulls) + 1}.obj"
        self.hulls[name] = hull
        return name


def _off_the_floor(hull: HullMesh, floor_T_mesh: Transform) -> HullMesh | None:
    """Return the hull with its points near the floor lifted; None if all points are higher, or all lower.

    Args:
        hull: hull in the mesh's frame.
        floor_T_mesh: (4, 4) pose of the mesh's frame above the floor (z = 0).
    """
    up, height = floor_T_mesh[2, :3], float(floor_T_mesh[2, 3])
    heights = hull.points @ up + height
    if heights.min() > REACHES_DOWN_M or heights.max() <= FLOOR_CLEARANCE_M:
        return None
    lifts = np.maximum(FLOOR_CLEARANCE_M - heights, 0.0)
    return HullMesh(hull.points + lifts[:, None] * up, hull.faces)


def _hull(file: str, scale: str, link: str) -> HullMesh:
    x, y, z = map(float, scale.split())
    hull: Any = hull_of_mesh(read_mesh(file, (x, y, z)), link)
    triangles = (hull.polygons(number) for number in range(hull.num_polygons))
    faces = np.array([[triangle[0], triangle[1], triangle[2]] for triangle in triangles], dtype=np.int64)
    return HullMesh(np.array(hull.points()), faces)
