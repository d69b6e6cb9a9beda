"""All that `handcart check` tells about a robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from backends.driven_wheels import driven_wheels
from backends.robot_file import RobotFile
from backends.sensor_specs import CameraSpec
from robotics.kinematics.urdf_contents import JointFacts, bodies_of, joints_of, links_of, meshes_of

from .masses import mass_faults
from .meshes import MeshRow, mesh_row
from .reach import Reach, reach_of

AWAY = 0.3  # [m] from the camera: where it reads labels


@dataclass(frozen=True)
class LinkRow:
    """A link's mass, and what is implausible about it."""

    name: str
    mass_kg: float | None
    faults: Sequence[str]


@dataclass(frozen=True)
class CameraFacts:
    """What the camera sees."""

    across_deg: float
    """Angle of view, left to right."""
    upright_deg: float
    px_per_mm: float
    """On something `AWAY` before it, straight ahead."""


@dataclass(frozen=True)
class RobotReport:
    """A robot by its files."""

    joints: Sequence[JointFacts]
    links: Sequence[LinkRow]
    meshes: Sequence[MeshRow]
    camera: CameraFacts | None
    reach: Reach | None
    warnings: Sequence[str]

    def figures(self) -> dict[str, Any]:
        """The same for programs."""
        reach = self.reach
        return {
            "joints": [each._asdict() for each in self.joints],
            "links": [asdict(each) for each in self.links],
            "meshes": [{**asdict(each), "fault": each.fault} for each in self.meshes],
            "camera": asdict(self.camera) if self.camera else None,
            "reach": None
            if reach is None
            else {
                "radii_m": reach.radii,
                "heights_m": reach.heights,
                "grasps": [asdict(each) for each in reach.grasps],
            },
        }


def report_of(robot: RobotFile, tried: bool = True) -> RobotReport:
    """Look at a robot whose file is right.

    Args:
        robot: by its file.
        tried: whether its reach is tried, which takes a few seconds.

    Raises:
        ValueError: something in the URDF can't be read.
    """
    urdf = robot.urdf_text()
    joints, bodies = joints_of(urdf), bodies_of(urdf)
    links = [
        LinkRow(link.name, link.mass, mass_faults(link, [b for b in bodies if b.name == link.name]))
        for link in links_of(urdf)
    ]
    meshes = [mesh_row(each) for each in meshes_of(urdf)]
    reach = reach_of(robot) if tried and robot.arm is not None else None
    camera = None if robot.camera is None else _camera(robot.camera)
    return RobotReport(
        joints,
        links,
        meshes,
        camera,
        reach,
        [*_of_links(links), *_of_meshes(meshes), *_of_robot(robot, joints), *_of_drives(robot)],
    )


def _camera(camera: CameraSpec) -> CameraFacts:
    across, upright = (
        math.degrees(2.0 * math.atan(pixels / (2.0 * camera.focal_px)))
        for pixels in (camera.width_px, camera.height_px)
    )
    return CameraFacts(round(across, 1), round(upright, 1), round(camera.focal_px / AWAY / 1e3, 2))


def _of_links(links: Sequence[LinkRow]) -> list[str]:
    return [f"link {each.name}: {fault}" for each in links for fault in each.faults]


def _of_meshes(meshes: Sequence[MeshRow]) -> list[str]:
    return [f"link {each.link}: {each.kind} mesh {each.file}: {each.fault}" for each in meshes if each.fault]


def _of_drives(robot: RobotFile) -> list[str]:
    """What its drives lack, and its file accepts."""
    if robot.can is None:
        return []
    from backends.can.lacks import not_watched

    return [f"{name}: {words}" for name, axis in robot.can.axes() for words in not_watched(axis)]


def _of_robot(robot: RobotFile, joints: Sequence[JointFacts]) -> list[str]:
    wheels = driven_wheels(joint.name for joint in joints)._asdict()
    told = [
        f"no joint '{side}_wheel': the backend pybullet can't drive" for side in wheels if not wheels[side]
    ]
    if robot.arm is None:
        return told
    of_arm = [joint for joint in joints if joint.name in robot.arm.joints]
    told += [
        f"joint {each.name} has no effort: in pybullet it is limp" for each in of_arm if each.effort <= 0
    ]
    told += [f"joint {each.name} has no speed: it can't move" for each in of_arm if each.velocity <= 0]
    if not robot.has_tray:
        told.append("no link 'tray': RECOGNIZE and PICK_UP take a book from one")
    missing = [name for name in ("home", "look_at_tag", "carry") if name not in robot.arm.postures]
    return told + [f"no posture {name!r}: return_book needs it" for name in missing]
