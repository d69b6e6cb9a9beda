"""What is wrong between a robot's file and its URDF."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from files.errors import FileError
from files.suggest import suggest
from robotics.kinematics.urdf_assembly import link_names

from .can_findings import can_findings, placed_axes
from .ground_spec import OUTDOORS
from .robot_parts import UrdfError

if TYPE_CHECKING:
    from files.errors import Finding
    from files.yaml_document import Document
    from robotics.kinematics.arm_model import ArmModel

    from .robot_file import ArmSpec, RobotFile

FINGERS = ("left_finger", "right_finger")
UNREADABLE = "Could not load resource"  # coal's words about a mesh


def robot_findings(robot: RobotFile, document: Document) -> list[Finding]:
    """Everything wrong with the URDF, the joints' names and the postures, each at its place in the file."""
    try:
        urdf = robot.urdf_text()
    except FileError as error:
        return list(error.findings)
    except UrdfError as error:
        return [document.finding(error.key or ("urdf",), str(error))]
    arm = _arm_findings(robot.arm, urdf, document) if robot.arm else []
    frames = _frame_findings(robot, urdf, document)
    boxes = _box_findings(robot, document)
    return arm or [
        *frames,
        *boxes,
        *_positioning_findings(robot, document),
        *_bus_findings(robot, document),
        *can_findings(robot, document),
        *_eds_findings(robot, document),
    ]


def _eds_findings(robot: RobotFile, document: Document) -> list[Finding]:
    """What is wrong in the EDS files of its drives, and what those drives lack."""
    axes = () if robot.can is None else placed_axes(robot.can)
    named = [(place, axis, robot.folder / axis.eds) for place, axis in axes if axis.eds is not None]
    there = [each for each in named if each[2].is_file()]
    if not there:
        return []
    look = import_module("backends.can.eds_needs").eds_findings
    wrong: set[Finding] = set()
    for place, axis, path in there:
        in_the_file, lacks = look(path, axis)
        wrong.update(in_the_file)
        wrong.update(document.finding(("can", *place), words) for words in lacks)
    return sorted(wrong)


def _bus_findings(robot: RobotFile, document: Document) -> list[Finding]:
    """Whether the bus carries what goes over it each period."""
    if robot.can is None:
        return []
    # By name: who reads a robot's file needn't know its buses.
    load = import_module("backends.can.cyclic_frames").bus_load(robot.can, robot.period_s)
    if not load.too_much:
        return []
    wrong = f"cyclic frames take {load.share:.0%} of the bus at this bit rate and {robot.period_s} s a period"
    return [document.finding(("can", "bitrate_kbit_s"), f"{wrong}; allowed: at most {load.ALLOWED:.0%}")]


def _positioning_findings(robot: RobotFile, document: Document) -> list[Finding]:
    if robot.localiser == "positioning" and robot.positioning is None:
        wrong = "the robot has no positioning; needed: the section `positioning`, or scan or odometry"
        return [document.finding(("localiser",), wrong)]
    if robot.localiser in OUTDOORS and robot.imu is None:
        wrong = f"{robot.localiser} asks the gyros; needed: the section `imu`, or scan or odometry"
        return [document.finding(("localiser",), wrong)]
    return []


def _frame_findings(robot: RobotFile, urdf: str, document: Document) -> list[Finding]:
    """Links and joints that our names are expected of."""
    links = link_names(urdf)
    needed = {("urdf",): "base" if "base" not in links else None}
    for key in ("range_sensor", "camera", "imu", "gps"):
        missing = getattr(robot, key) is not None and key not in links
        needed[(key,)] = key if missing else None
    return [
        document.finding(key, f"the URDF has no link {link!r}{suggest(link, links)}")
        for key, link in needed.items()
        if link is not None
    ]


def _box_findings(robot: RobotFile, document: Document) -> list[Finding]:
    """Fingers, and a tray if there is one, must tell their size."""
    found = []
    try:
        if robot.gripper is not None and robot.arm is not None:
            robot.arm_model().with_others(dict.fromkeys(FINGERS, 0.0))
            _ = robot.finger_shape
        if robot.has_tray:
            _ = robot.tray_shape
    except ValueError as error:
        found.append(document.finding(("gripper",) if robot.gripper else ("urdf",), str(error)))
    return found


def _arm_findings(arm: ArmSpec, urdf: str, document: Document) -> list[Finding]:
    from robotics.kinematics.arm_model import ArmModel

    try:
        model = ArmModel(urdf, arm.joints)
    except ValueError as error:
        if UNREADABLE in str(error):
            lines = str(error).partition(UNREADABLE)[2].strip().splitlines()
            wrong = f"a mesh can't be read: {', '.join(lines[:2])}; allowed: STL, OBJ or DAE files"
            return [document.finding(("urdf",), wrong)]
        return [document.finding(("arm", "joints"), f"{error}; allowed: joints of the file's urdf")]
    return [
        document.finding(("arm", "postures", name), wrong)
        for name, angles in arm.postures.items()
        for wrong in posture_faults(model, arm.joints, angles)
    ]


def posture_faults(model: ArmModel, joints: tuple[str, ...], angles: tuple[float, ...]) -> list[str]:
    """Why an arm can't take a posture, in words; nothing where it can.

    Args:
        model: of the arm, with its limits.
        joints: their names.
        angles: of the joints, in [deg].
    """
    import numpy as np

    if len(angles) != len(joints):
        return [f"{len(angles)} angles; allowed: {len(joints)}, one for each joint"]
    limits = zip(joints, angles, np.degrees(model.lower), np.degrees(model.upper), strict=True)
    return [
        f"{joint} can't stand at {angle:g} deg; allowed: {low:.1f} to {high:.1f}"
        for joint, angle, low, high in limits
        if not low <= angle <= high
    ]
