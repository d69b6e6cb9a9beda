"""The arm as it may be used."""

from __future__ import annotations

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.kinematics.arm_model import ArmModel


def working_arm(spec: RobotFile) -> ArmModel:
    """Return the model of the robot's arm, with joint speeds limited by the URDF and by the robot's file.

    Raises:
        Discrepancy: the robot has no arm.
    """
    if spec.arm is None:
        raise Discrepancy("the robot's file has no arm", permanent=True, cause=causes.UNSUITABLE)
    arm = spec.arm_model()
    arm.velocity = np.minimum(arm.velocity, spec.joint_speeds())
    return arm
