"""Limits of commands that hold for every robot and backend."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from handcart.backends.description.robot_file import Drive, GripperSpec
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .backend import CommandError
from .capabilities.base import DriveCommand

_ROUNDING = 1e-9


def checked_drive(drive: Drive, speed: float, turn_rate: float) -> tuple[float, float]:
    """Check a forward speed in [m/s] and a turn rate to the left in [rad/s], and return them unchanged.

    Raises:
        CommandError: a value is not finite or beyond a limit.
    """
    command = checked_command(drive, speed, turn_rate)
    return command.speed, command.turn_rate


def checked_command(drive: Drive, speed: float, turn_rate: float, sideways: float = 0.0) -> DriveCommand:
    """Check the speeds of a base against the robot's limits, and return them as a command.

    Args:
        drive: drive of the robot's file.
        speed: forward, in [m/s].
        turn_rate: to the left, in [rad/s].
        sideways: to the left, in [m/s].

    Raises:
        CommandError: a value is not finite or beyond a limit.
    """
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
    _check_sideways(drive, speed, sideways)
    return DriveCommand(float(speed), float(turn_rate), float(sideways))


def _check_sideways(drive: Drive, speed: float, sideways: float) -> None:
    top = drive.top_sideways
    if not abs(sideways) <= top + _ROUNDING:
        allowed = f"-{top} to {top}" if top else f"0, because the drive is {drive.kind}"
        raise CommandError(f"a sideways speed of {sideways} m/s; allowed: {allowed}")
    if sideways != 0.0 and math.hypot(speed / drive.top_speed_m_s, sideways / top) > 1.0 + 1e-6:
        raise CommandError(
            f"a speed of {speed} m/s with {sideways} m/s sideways; allowed: "
            f"(speed / {drive.top_speed_m_s})² + (sideways / {top})² at most 1"
        )


def checked_joints(model: ArmModel, joints: FloatArray, last: FloatArray, most: FloatArray) -> FloatArray:
    """Check commanded joints (n,), in [rad] or [m], against the limits, and return them unchanged.

    Args:
        model: model of the arm.
        joints: (n,) joints commanded for the end of the next period, in [rad] or [m].
        last: (n,) joints commanded for the end of this period, in [rad] or [m].
        most: (n,) largest step of each joint in a period, in [rad] or [m].

    Raises:
        CommandError: a value is not finite, is beyond its limit, or differs from `last` by more than `most`.
    """
    wanted = np.array(joints, dtype=np.float64)
    if wanted.shape != last.shape or not np.isfinite(wanted).all():
        raise CommandError(f"joint angles {wanted.tolist()}; allowed: {model.dof} finite numbers")
    beyond = np.abs(wanted - model.clipped(wanted)) > _ROUNDING
    if beyond.any():
        raise CommandError(_each(model, beyond, lambda number: _beyond(model, number, wanted[number])))
    step = np.abs(wanted - last)
    fast = step > most * (1.0 + 1e-6) + _ROUNDING
    if fast.any():
        raise CommandError(
            _each(model, fast, lambda number: _fast(model, number, step[number], most[number]))
        )
    return wanted


def _each(model: ArmModel, wrong: BoolArray, words: Callable[[int], str]) -> str:
    return "; ".join(
        f"joint {model.joint_names[number]!r}: {words(int(number))}" for number in np.flatnonzero(wrong)
    )


def _beyond(model: ArmModel, number: int, wanted: float) -> str:
    scale, unit = _units(model, number)
    lower, upper = scale * model.lower[number], scale * model.upper[number]
    return f"{scale * float(wanted):.5g} {unit}; allowed: {lower:.5g} to {upper:.5g} {unit}"


def _fast(model: ArmModel, number: int, step: float, most: float) -> str:
    scale, unit = _units(model, number)
    return f"a step of {scale * float(step):.5g} {unit} in a period; allowed: {scale * most:.5g} {unit}"


def _units(model: ArmModel, number: int) -> tuple[float, str]:
    """Return the factor from a joint's SI unit to the unit shown to people, and that unit: "deg", or "mm" if
    it slides.
    """
    return (1e3, "mm") if model.slides[number] else (math.degrees(1.0), "deg")


def checked_width(gripper: GripperSpec, width: float) -> float:
    """Check a commanded opening in [m], and return it unchanged; raise `CommandError` below 0, beyond the
    gripper's opening, or for NaN.
    """
    opening = gripper.opening_mm / 1e3
    if not 0.0 <= width <= opening + _ROUNDING:
        raise CommandError(f"a width of {width} m; allowed: 0 to {opening}")
    return float(width)
