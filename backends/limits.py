"""What no robot may be commanded, whatever the backend."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import Drive, GripperSpec
from handcart.robotics.kinematics.arm_model import ArmModel

from .backend import CommandError

_ROUNDING = 1e-9

Vector = NDArray[np.float64]


def checked_drive(drive: Drive, speed: float, turn_rate: float) -> tuple[float, float]:
    """A speed in [m/s] and a turn rate in [rad/s] within the robot's limits; raises `CommandError`."""
    top, top_turn = drive.top_speed_m_s, math.radians(drive.top_turn_deg_s)
    # Written so that NaN is refused too.
    if not abs(speed) <= top + _ROUNDING:
        raise CommandError(f"a speed of {speed} m/s; allowed: -{top} to {top}")
    if not abs(turn_rate) <= top_turn + _ROUNDING:
        raise CommandError(f"a turn rate of {turn_rate} rad/s; allowed: -{top_turn:.3f} to {top_turn:.3f}")
    sharpest = drive.sharpest_per_m * abs(speed) if drive.kind == "ackermann" else math.inf
    if abs(turn_rate) > sharpest + _ROUNDING:
        raise CommandError(
            f"a turn rate of {turn_rate} rad/s at {speed} m/s; allowed: -{sharpest:.3f} to {sharpest:.3f},"
            f" a curvature of {drive.sharpest_per_m} 1/m"
        )
    return float(speed), float(turn_rate)


def checked_joints(model: ArmModel, joints: Vector, last: Vector, most: Vector) -> Vector:
    """Joint angles (n,) in [rad] within the limits.

    Args:
        model: of the arm.
        joints: wanted at the end of the next period.
        last: commanded for the end of this one.
        most: that a joint may move in a period.

    Raises:
        CommandError: a value isn't finite, is beyond its limit, or too far from the last.
    """
    wanted = np.array(joints, dtype=np.float64)
    if wanted.shape != last.shape or not np.isfinite(wanted).all():
        raise CommandError(f"joint angles {wanted.tolist()}; allowed: {model.dof} finite numbers")
    if (wanted < model.lower - _ROUNDING).any() or (wanted > model.upper + _ROUNDING).any():
        allowed = f"{model.lower.round(4).tolist()} to {model.upper.round(4).tolist()}"
        raise CommandError(
            f"joint angles {', '.join(f'{each:.5g}' for each in wanted)} rad; allowed: {allowed}"
        )
    step = np.abs(wanted - last)
    if (step > most * (1.0 + 1e-6) + _ROUNDING).any():
        wrong = f"joint steps of {step.round(5).tolist()} rad in a period"
        raise CommandError(f"{wrong}; allowed: {most.round(5).tolist()}")
    return wanted


def checked_width(gripper: GripperSpec, width: float) -> float:
    """An opening in [m] within the gripper's range; raises `CommandError`."""
    opening = gripper.opening_mm / 1e3
    if not 0.0 <= width <= opening + _ROUNDING:
        raise CommandError(f"a width of {width} m; allowed: 0 to {opening}")
    return float(width)
