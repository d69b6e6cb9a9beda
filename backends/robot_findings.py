"""What is wrong between a robot's file and its URDF."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .robot_parts import UrdfError

if TYPE_CHECKING:
    from files.errors import Finding
    from files.yaml_document import Document
    from robotics.kinematics.arm_model import ArmModel

    from .robot_file import ArmSpec, RobotFile


def robot_findings(robot: RobotFile, document: Document) -> list[Finding]:
    """Everything wrong with the URDF, the joints' names and the postures, each at its place in the file."""
    try:
        urdf = robot.urdf_text()
    except UrdfError as error:
        key = ("urdf",) if error.part is None else ("parts", error.part)
        return [document.finding(key, str(error))]
    return _arm_findings(robot.arm, urdf, document) if robot.arm else []


def _arm_findings(arm: ArmSpec, urdf: str, document: Document) -> list[Finding]:
    from robotics.kinematics.arm_model import ArmModel

    try:
        model = ArmModel(urdf, arm.joints)
    except ValueError as error:
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
