"""Complete report of `handcart check` on a robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.backends.urdf.robot_urdf import RobotUrdf
from handcart.files.suggest import listed
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.urdf_contents import JointFacts, bodies_of, joints_of, links_of, meshes_of
from handcart.tasks.domain import domains, imported

from .domain_facts import DomainFacts
from .masses import mass_faults
from .meshes import MeshRow, mesh_row
from .mount_remarks import mount_remarks
from .reach import HandReach, reach_of
from .remark import Remark
from .self_contact import SelfContact, self_contact, touching_words
from .sizes import size_remarks

LABEL_DISTANCE_M = 0.3  # from the camera, when it reads labels


@dataclass(frozen=True)
class LinkRow:
    """Mass of a link of the URDF, with messages about implausible mass or inertia."""

    name: str
    mass_kg: float | None
    faults: Sequence[str]


@dataclass(frozen=True)
class CameraFacts:
    """Field of view and resolution of the camera on the robot's hand."""

    across_deg: float
    """Horizontal angle of view."""
    upright_deg: float
    px_per_mm: float
    """Resolution at the distance `LABEL_DISTANCE_M`, straight ahead."""


@dataclass(frozen=True)
class Contents:
    """Joints, links, meshes and remarks of a robot's URDF, for the report on the robot."""

    joints: Sequence[JointFacts]
    links: Sequence[LinkRow]
    meshes: Sequence[MeshRow]
    remarks: Sequence[Remark]

    def figures(self) -> dict[str, Any]:
        """Return the URDF's joints, links and meshes as JSON values."""
        return {
            "joints": [joint._asdict() for joint in self.joints],
            "links": [asdict(link) for link in self.links],
            "meshes": [{**asdict(mesh), "fault": mesh.fault} for mesh in self.meshes],
        }


@dataclass(frozen=True)
class RobotReport:
    """Report on a robot from its file and URDF, with content, reach, self-contacts and remarks."""

    contents: Contents
    arm: Sequence[str]
    """Names of the arm's joints."""
    camera: CameraFacts | None
    contact: SelfContact | None
    reach: HandReach | None
    domains: Mapping[str, DomainFacts]
    """Facts that the domains report, by name of the domain."""
    remarks: Sequence[Remark]

    @property
    def warnings(self) -> list[str]:
        """All remarks of the report, each as a line of text."""
        return [str(remark) for remark in self.remarks]

    def figures(self) -> dict[str, Any]:
        """Return the report as JSON values."""
        reach, contact = self.reach, self.contact
        return {
            **self.contents.figures(),
            "camera": asdict(self.camera) if self.camera else None,
            "self_contact": asdict(contact) if contact else None,
            "reach": None if reach is None else reach.figures(),
            **{name: dict(facts.figures) for name, facts in self.domains.items() if facts.figures},
        }


def contents_of(whole: RobotUrdf) -> Contents:
    """Check joints, links and meshes of a URDF; return them with remarks about doubtful properties.

    Raises:
        ValueError: a part of the URDF cannot be read.
    """
    bodies = bodies_of(whole.text)
    joints = joints_of(whole.text)
    moved = {joint.child for joint in joints}
    links = [
        LinkRow(
            link.name,
            link.mass,
            mass_faults(link, [b for b in bodies if b.name == link.name], link.name in moved),
        )
        for link in links_of(whole.text)
    ]
    used = meshes_of(whole.text)
    meshes = [mesh_row(use) for use in used]
    sizes = size_remarks(bodies, used, whole)
    doubts = [Remark("", doubt.message, doubt) for doubt in whole.doubts]
    remarks = [*doubts, *_of_links(links, whole), *_of_meshes(meshes, whole), *sizes]
    return Contents(joints, links, meshes, remarks)


def report_of(robot: RobotFile, tried: bool = True) -> RobotReport:
    """Check a robot whose file is valid, and return the report.

    Args:
        robot: the robot's file.
        tried: whether to estimate the reach, which takes a few seconds.

    Raises:
        ValueError: a part of the URDF cannot be read.
    """
    contents = contents_of(robot.whole)
    arm = robot.arm_model() if tried and robot.arm is not None else None
    contact = None if arm is None else self_contact(arm)
    reach = None if contact is None or arm is None else _reach(robot, arm, contact)
    of_domains = _domain_facts(robot, reach)
    return RobotReport(
        contents,
        () if robot.arm is None else robot.arm.joints,
        None if robot.camera is None else _camera(robot.camera),
        contact,
        reach,
        of_domains,
        [
            *contents.remarks,
            *_of_contact(contact, reach),
            *_of_robot(robot, contents.joints),
            *(Remark("", words) for facts in of_domains.values() for words in facts.remarks),
            *_of_drives(robot),
            *mount_remarks(robot),
        ],
    )


def _reach(robot: RobotFile, arm: ArmModel, contact: SelfContact) -> HandReach | None:
    """Return the reach of the arm, with contacts of pairs that always touch allowed."""
    allowed = ArmModel(robot.urdf_text(), arm.joint_names, allowed=arm.allowed | set(contact.always))
    return reach_of(robot, allowed)


def _domain_facts(robot: RobotFile, reach: HandReach | None) -> dict[str, DomainFacts]:
    return {
        domain.name: imported(domain.robot_facts)(robot, reach) for domain in domains() if domain.robot_facts
    }


def _camera(camera: CameraSpec) -> CameraFacts:
    across, upright = (
        math.degrees(2.0 * math.atan(pixels / (2.0 * camera.focal_px)))
        for pixels in (camera.width_px, camera.height_px)
    )
    return CameraFacts(
        round(across, 1), round(upright, 1), round(camera.focal_px / LABEL_DISTANCE_M / 1e3, 2)
    )


def _of_links(links: Sequence[LinkRow], whole: RobotUrdf) -> list[Remark]:
    return [
        Remark(f"link {link.name!r}", fault, whole.finding("link", link.name, fault))
        for link in links
        for fault in link.faults
    ]


def _of_meshes(meshes: Sequence[MeshRow], whole: RobotUrdf) -> list[Remark]:
    return [
        Remark(
            f"link {mesh.link!r}",
            f"{mesh.kind} mesh {mesh.file!r}: {mesh.fault}",
            whole.finding("link", mesh.link, mesh.fault),
        )
        for mesh in meshes
        if mesh.fault
    ]


def _of_drives(robot: RobotFile) -> list[Remark]:
    """Return remarks about monitoring that the robot's CAN drives lack."""
    if robot.can is None:
        return []
    from handcart.backends.can.eds.lacks import not_watched

    return [Remark(name, words) for name, axis in robot.can.axes() for words in not_watched(axis)]


def _of_contact(contact: SelfContact | None, reach: HandReach | None) -> list[Remark]:
    if contact is None:
        return []
    remarks = []
    if contact.always:
        named = listed(f"{a} with {b}" for a, b in contact.always)
        words = f"links that touch however the arm stands: {named}"
        remarks.append(
            Remark("", f"{words}; if they may, `handcart check --allow` writes that into the file")
        )
    if reach is None:
        often = ", ".join(touching_words(*pair) for pair in contact.often[:3])
        remarks.append(Remark("", f"no posture was found that is free of the robot itself: {often}"))
    return remarks


def _of_robot(robot: RobotFile, joints: Sequence[JointFacts]) -> list[Remark]:
    wheels = driven_wheels(joint.name for joint in joints)._asdict()
    undriven = [
        f"no joint '{side}_wheel': the backend pybullet can't drive; name one: `drive: {{{side}: JOINT}}`"
        for side in wheels
        if not wheels[side]
    ]
    if robot.arm is None:
        return [Remark("", item) for item in undriven]
    of_arm = [joint for joint in joints if joint.name in robot.arm.joints]
    at = robot.whole.finding
    moves = [
        Remark(f"joint {joint.name!r}", wrong, at("joint", joint.name, wrong))
        for joint in of_arm
        for wrong in _of_joint(joint)
    ]
    return [*moves, *(Remark("", item) for item in undriven)]


def _of_joint(joint: JointFacts) -> list[str]:
    limp = ["no effort: in pybullet it is limp"] if joint.effort <= 0 else []
    return limp + (["no speed limit: that of the robot's file counts"] if joint.velocity <= 0 else [])
