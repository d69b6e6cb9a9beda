"""Recognition of URDF arms that the closed form of `PitchArm` fits."""

from __future__ import annotations

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel

from .pitch_arm import PitchArm
from .screw_chain import ScrewChain

_SAME = 1e-6  # [m] and of unit vectors


def pitch_arm_of(arm: ArmModel, azimuth_tolerance: float) -> PitchArm | None:
    """Return an arm as a `PitchArm`, whose inverse kinematics has a closed form; None for another kind of
    arm.

    The arm needs a yaw joint, three pitch joints that turn upwards, and a roll joint about the tool, all in
    one upright plane. With all joints at zero it has to be stretched out level and ahead.

    Args:
        arm: arm model.
        azimuth_tolerance: allowed turn of the tool about the vertical, in [rad].
    """
    if arm.dof != 5:
        return None
    chain = ScrewChain.of_arm(arm)
    axes = np.array([(0, 0, 1), (0, -1, 0), (0, -1, 0), (0, -1, 0), (1, 0, 0)], dtype=np.float64)
    ahead, height, links = _measures(chain)
    symmetric = abs(arm.lower[0] + arm.upper[0]) < _SAME
    tool_ahead = np.allclose(chain.base_T_tip[:3, :3], np.eye(3), atol=_SAME)
    elbow_up = arm.upper[2] < _SAME
    if not (np.allclose(chain.axes, axes, atol=_SAME) and _in_line(chain, ahead, height)):
        return None
    if not (symmetric and tool_ahead and elbow_up):
        return None
    limits = tuple((float(arm.lower[i]), float(arm.upper[i])) for i in (1, 2, 3))
    return PitchArm(ahead, height, links, float(arm.upper[0]), azimuth_tolerance, limits)  # type: ignore[arg-type]


def _measures(chain: ScrewChain) -> tuple[float, float, tuple[float, float, float]]:
    """Return the yaw axis' distance ahead of the base, the shoulder's height, and the links' lengths, in
    [m].
    """
    knots = np.append(chain.points[1:4, 0], chain.base_T_tip[0, 3])
    upper, fore, wrist = np.diff(knots).tolist()
    return float(chain.points[0, 0]), float(chain.points[1, 2]), (upper, fore, wrist)


def _in_line(chain: ScrewChain, ahead: float, height: float) -> bool:
    """Return True if yaw axis and shoulder meet, and all other joints lie straight ahead of them."""
    level = np.append(chain.points[1:, 2], chain.base_T_tip[2, 3])
    beside = np.array([chain.points[0, 1], chain.points[4, 1], chain.base_T_tip[1, 3]])
    sizes = (abs(chain.points[1, 0] - ahead), np.abs(level - height).max(), np.abs(beside).max())
    return bool(max(sizes) < _SAME)
