"""Where a tool is, by joint angles, against where its path has it."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.numerics.arrays import FloatArray


def tool_errors(arm: ArmModel, path: ToolPath, world_T_base: Transform, angles: FloatArray) -> FloatArray:
    """Return the distances (p,) of the tool from the points of a path, in [m]; angles (p, n) in [rad]."""
    tips = np.array([(world_T_base @ arm.forward(q))[:3, 3] for q in angles])
    return np.asarray(np.linalg.norm(tips - path.points, axis=1))
