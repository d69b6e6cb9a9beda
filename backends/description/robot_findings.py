"""What is wrong between a robot's file and its URDF."""

from __future__ import annotations

from typing import TYPE_CHECKING

from handcart.backends.urdf.robot_parts import UrdfError
from handcart.files.errors import FileError
from handcart.files.extras import lack
from handcart.files.suggest import listed, suggest
from handcart.robotics.kinematics.urdf_contents import joints_of, link_names
from handcart.robotics.kinematics.urdf_tree import joint_leaders
from handcart.tasks.domain import imported

from .ground_spec import OUTDOOR_LOCALIZERS
from .mount_findings import FINGER_LINKS, mount_findings

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document
    from handcart.files.yaml.yaml_node import KeyPath
    from handcart.robotics.kinematics.arm_model import ArmModel

    from .joint_units import JointUnits
    from .robot_file import ArmSpec, RobotFile

CAN_FINDINGS = "handcart.backends.can.devices.can_findings:can_findings"
"""Function that returns the findings in the section `can` of a robot's document."""
ROS_FINDINGS = "handcart.backends.ros2.ros_findings:ros_findings"
"""Function that returns the findings in the section `ros2` of a robot's document."""


def robot_findings(robot: RobotFile, document: Document, drives: bool = True) -> list[Finding]:
    """Return all faults of a robot's URDF, joint names and postures, each at its place in the robot's file.

    Args:
        robot: robot file.
        document: the same file, for the places of the findings.
        drives: True for the findings on the sections `can` and `ros2` as well.
    """
    try:
        urdf = robot.urdf_text()
    except FileError as error:
        return list(error.findings)
    except UrdfError as error:
        return [document.finding(error.key or ("urdf",), str(error))]
    frames = _frame_findings(robot, urdf, document)
    if robot.arm is not None:
        if wrong := lack("an arm", "arm"):
            return [*frames, document.finding(("arm",), wrong)]
        arm = _arm_findings(robot, robot.arm, urdf, document, bool(frames))
        if arm:
            return [*frames, *arm]
    return [
        *frames,
        *([] if frames else (*mount_findings(robot, urdf, document), *_box_findings(robot, document))),
        *_positioning_findings(robot, document),
        *(imported(CAN_FINDINGS)(robot, document) if drives and robot.can is not None else ()),
        *(imported(ROS_FINDINGS)(robot, document) if drives and robot.ros2 is not None else ()),
    ]


def _positioning_findings(robot: RobotFile, document: Document) -> list[Finding]:
    if robot.localizer == "positioning" and robot.positioning is None:
        wrong = "the robot has no positioning; needed: the section `positioning`, or scan or odometry"
        return [document.finding(("localizer",), wrong)]
    if robot.localizer == "beacons" and robot.beacons is None:
        wrong = "the robot hears no beacons; needed: the section `beacons`, or another localizer"
        return [document.finding(("localizer",), wrong)]
    if robot.localizer in OUTDOOR_LOCALIZERS and robot.imu is None:
        wrong = f"{robot.localizer} asks the gyros; needed: the section `imu`, or scan or odometry"
        return [document.finding(("localizer",), wrong)]
    if robot.localizer in ("particle", "gps_filter") and robot.gps is None:
        wrong = f"{robot.localizer} corrects wheels by position fixes; needed: the section `gps`, or gyro"
        return [document.finding(("localizer",), wrong)]
    blind = robot.localizer in ("gyro", "beacons")
    if blind and robot.gps is not None and robot.gps.start_heading_deg == "unknown":
        looks = f"the localizer {robot.localizer} looks at no fix that could tell it"
        wrong = f"unknown, and {looks}; needed: a number of degrees"
        return [document.finding((*robot.key_of(robot.name_of(robot.gps)), "start_heading_deg"), wrong)]
    return []


def _frame_findings(robot: RobotFile, urdf: str, document: Document) -> list[Finding]:
    """Return findings on links that the URDF lacks under the names that the program expects."""
    links = link_names(urdf)
    needed: dict[KeyPath, str] = {("urdf",): "base", **({} if robot.arm is None else {("arm",): "hand"})}
    for name, spec in robot.sensors.items():
        if link := robot.link_of(spec):
            key = robot.key_of(name)
            needed[(*key, "frame") if getattr(spec, "frame", None) else key] = link
    return [
        document.finding(key, f"the URDF has no link {link!r}{suggest(link, links)}{_how(key)}")
        for key, link in needed.items()
        if link not in links
    ]


def _how(key: KeyPath) -> str:
    """Return advice on how the robot's file can map a link that has another name than expected."""
    if key[-1] == "frame":
        return ""
    where = "as the sensor's `frame`" if key[0] == "sensors" else "under the key `links`"
    return f"; or name one of them {where}"


def _box_findings(robot: RobotFile, document: Document) -> list[Finding]:
    """Return findings for fingers without a size, and for a tray without one."""
    found = []
    try:
        if robot.gripper is not None and robot.arm is not None:
            robot.described_arm.with_others(dict.fromkeys(FINGER_LINKS, 0.0))
            _ = robot.finger_shape
        if robot.has_tray:
            _ = robot.tray_shape
    except ValueError as error:
        found.append(document.finding(("gripper",) if robot.gripper else ("urdf",), str(error)))
    return found


def _arm_findings(
    robot: RobotFile, arm: ArmSpec, urdf: str, document: Document, only_joints: bool
) -> list[Finding]:
    """Return findings about the arm; those on kinematics only without faults in the list of its joints.

    Args:
        robot: robot file.
        arm: section of the arm.
        urdf: text of the robot's URDF.
        document: the robot's file, for the places of the findings.
        only_joints: True to check the list of joints alone, because the arm's first or last link is missing.
    """
    facts = {item.name: item for item in joints_of(urdf)}
    leaders = joint_leaders(urdf)
    key = ("arm", "joints")
    found = [document.finding(key, wrong) for wrong in _joint_faults(arm.joints, list(facts), leaders)]
    found += [
        document.finding(("arm", "working_deg", name), f"{name!r} doesn't turn; allowed: joints that do")
        for name in arm.working_deg
        if name in facts and facts[name].kind == "prismatic"
    ]
    if found or only_joints:
        return found
    found += _slide_findings(robot, arm, document)
    try:
        model = robot.described_arm
    except ValueError as error:
        return [*found, document.finding(key, f"{error}; allowed: an arm mounted on the link `base`")]
    found += [
        robot.whole.finding("joint", name, "its limits leave it no room; allowed: lower below upper")
        or document.finding(key, f"{name!r} has no room between its limits")
        for name, low, high in zip(arm.joints, model.lower, model.upper, strict=True)
        if not low < high
    ]
    return found + [
        document.finding(("arm", "postures", name), wrong)
        for name, angles in arm.postures.items()
        for wrong in posture_faults(model, robot.joint_units, angles)
    ]


def _joint_faults(
    joints: Sequence[str], movable: Sequence[str], leaders: Mapping[str, tuple[str, float, float]]
) -> Iterator[str]:
    for name in dict.fromkeys(joints):
        if name not in movable:
            yield f"the URDF has no movable joint {name!r}{suggest(name, movable)}"
        elif name in leaders:
            yield f"{name!r} follows {leaders[name][0]!r} (mimic); allowed: joints that move by themselves"
        if joints.count(name) > 1:
            yield f"{name!r} stands there {joints.count(name)} times; allowed: each joint once"
    if not joints:
        yield f"an arm without joints; allowed: {listed(movable)}, or no section `arm`"


def _slide_findings(robot: RobotFile, arm: ArmSpec, document: Document) -> list[Finding]:
    units = robot.joint_units
    slide = next((name for name, slides in zip(units.names, units.slides, strict=True) if slides), None)
    if slide is None:
        return []
    return [
        document.finding(("arm",), f"the joint {slide!r} slides; needed: {key}")
        for key in ("slide_speed_mm_s", "slide_acceleration_mm_s2")
        if getattr(arm, key) is None
    ]


def posture_faults(model: ArmModel, units: JointUnits, posture: Sequence[float]) -> list[str]:
    """Return the reasons why an arm cannot reach a posture, as texts; empty if it can.

    Args:
        model: model of the arm.
        units: units of the joints in messages.
        posture: joint values in [deg] or [mm], as in the robot's file.
    """
    if len(posture) != len(units.names):
        return [f"{len(posture)} angles; allowed: {len(units.names)}, one for each joint ({units.all})"]
    limits = zip(units.names, units.si(posture), posture, model.lower, model.upper, strict=True)
    return [
        f"{joint} can't stand at {said:g} {units.unit(number)}; allowed: {_range(units, number, low, high)}"
        for number, (joint, value, said, low, high) in enumerate(limits)
        if not low <= value <= high
    ]


def _range(units: JointUnits, number: int, low: float, high: float) -> str:
    return f"{units.user_value(number, low):.1f} to {units.user_value(number, high):.1f}"
