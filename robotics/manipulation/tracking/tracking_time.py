"""Timing of an arm along its path, with the wanted tool speed where the joints allow it, less elsewhere."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.toppra_library import (
    JointAccelerationConstraint,
    JointTorqueConstraint,
    JointVelocityConstraintVarying,
    SeidelToppra,
    SplineInterpolator,
)
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import FloatArray

from .tracking_limits import ArmLoad, LimitUse


class TimedTracking(NamedTuple):
    """Joint angles of an arm along a path, one set-point each control period; the arm rests at both ends."""

    set_points: FloatArray
    """Joint angles (k, n), one row each period, in [rad]."""
    lengths: FloatArray
    """Arc length (k,) along the path at each set-point, in [m]."""
    use: LimitUse
    """Use of the limits, at every set-point; nothing above 1."""


class TrackingLimits(NamedTuple):
    """Limits of the tool's speed and of the joints' accelerations and torques for following a path."""

    speed: float
    """Maximum speed of the tool, in [m/s]."""
    acceleration: FloatArray
    """Acceleration limits (n,) of the joints, in [rad/s²]."""
    torque: FloatArray
    """Torque limits (n,) of the joints, in [Nm]."""
    force: float = 0.0
    """Force with which the tool pushes along the path, in [N]."""


def time_tracking(
    arm: ArmModel, path: ToolPath, angles: FloatArray, limits: TrackingLimits, period: float
) -> TimedTracking:
    """Return timed set-points along a path.

    The angles are joined by a cubic spline over the arc length; TOPP-RA (Pham and Pham 2018) computes the
    highest speed along the spline that keeps the limits. If differences of the set-points still exceed a
    limit, the complete motion is slowed down.

    Args:
        arm: arm model.
        path: path of the tool.
        angles: (p, n) joint angles that reach the path's points, in [rad].
        limits: limits of speed, acceleration and torque.
        period: time between set-points, in [s].

    Raises:
        Untrackable: the first point at which the torque limits are exceeded already while the arm holds still
            and pushes.
        ValueError: a limit or the period isn't above zero.
    """
    if min(limits.speed, *limits.acceleration, *limits.torque, period) <= 0.0 or limits.force < 0.0:
        raise ValueError("speed, acceleration, torque and period must be above zero, the force not below")
    load = ArmLoad(arm)
    push = _push(arm, load, path, angles, limits.force)
    _check_holding(arm, load, angles, push, limits.torque)
    s, speed = _fastest(arm, load, path, angles, limits, push)
    times = np.concatenate(([0.0], np.cumsum(2.0 * np.diff(s) / (speed[:-1] + speed[1:]))))
    spline, pushes = CubicSpline(path.lengths, angles), CubicSpline(path.lengths, push)
    count = max(2, int(np.ceil(times[-1] / period)))
    for _ in range(_STRETCHES):
        along = _progress(s, speed, times, np.linspace(0.0, times[-1], count + 1))
        set_points = spline(along)
        use = load.use(set_points, period, limits.torque, pushes(along))
        fastest = float(np.abs(np.diff(along)).max()) / (period * limits.speed)
        if use.violations == 0 and fastest <= 1.0 + 1e-9:
            return TimedTracking(set_points, along, use)
        count = int(count * 1.02) + 1
    index = int(np.argmax(use.torque.max(axis=1)))
    raise Untrackable(int(np.searchsorted(path.lengths, along[index])), "takes too much torque at any speed")


def time_evenly(
    arm: ArmModel, path: ToolPath, angles: FloatArray, limits: TrackingLimits, ramp: float, period: float
) -> TimedTracking:
    """Return set-points for a constant tool speed, with a ramp at both ends, for an arm on a driving base.

    Args:
        arm: kinematics of the arm.
        path: path of the tool.
        angles: (p, n) joint angles at the points of the path, in [rad].
        limits: limits of speed, torque and force.
        ramp: acceleration along the path at its ends, in [m/s²].
        period: time between set-points, in [s].

    Raises:
        Untrackable: a joint would be too fast, or its torque too large, at a point of the path.
        ValueError: speed, ramp, torque or period isn't above zero, or the force is below zero.
    """
    if min(limits.speed, ramp, *limits.torque, period) <= 0.0 or limits.force < 0.0:
        raise ValueError("speed, ramp, torque and period must be above zero, the force not below")
    load = ArmLoad(arm)
    push = _push(arm, load, path, angles, limits.force)
    _check_holding(arm, load, angles, push, limits.torque)
    spline, pushes = CubicSpline(path.lengths, angles), CubicSpline(path.lengths, push)
    speed = limits.speed
    for _ in range(_STRETCHES):
        along = _trapezoid(path.length, speed, ramp, period)
        set_points = spline(along)
        use = load.use(set_points, period, limits.torque, pushes(along))
        if use.violations == 0 and use.speed.max() <= _FOR_FEEDBACK:
            return TimedTracking(set_points, along, use)
        speed /= 1.05
    index = int(np.argmax(use.torque.max(axis=1)))
    raise Untrackable(int(np.searchsorted(path.lengths, along[index])), "takes too much torque at any speed")


def _trapezoid(length: float, speed: float, ramp: float, period: float) -> FloatArray:
    """Arc lengths (k,), one each `period`, from rest to rest."""
    speed = min(speed, np.sqrt(length * ramp))
    rising, whole = speed / ramp, length / speed + speed / ramp
    times = np.linspace(0.0, whole, int(np.ceil(whole / period)) + 1)
    left = whole - times
    even = speed * (times - 0.5 * rising)
    up, down = 0.5 * ramp * times**2, length - 0.5 * ramp * left**2
    return np.asarray(np.where(times < rising, up, np.where(left < rising, down, even)))


_STRETCHES = 100
_FOR_FEEDBACK = 0.75  # of the joints' speeds: the rest makes good what the base does
_ROOM = 0.98  # of the torque limits for TOPP-RA, which looks at fewer places


def _push(arm: ArmModel, load: ArmLoad, path: ToolPath, angles: FloatArray, force: float) -> FloatArray:
    """Return (p, n) sizes of the torques for the force along the path, in [Nm]; any turn of the base is the
    same.
    """
    if force == 0.0:
        return np.zeros_like(angles)
    tips = np.array([arm.forward(q)[:3, 3] for q in angles])
    spline = CubicSpline(path.lengths, tips)(path.lengths, 1)
    tangents = spline / np.linalg.norm(spline, axis=1, keepdims=True)
    return np.abs([load.push(q, force * k) for q, k in zip(angles, tangents, strict=True)])


def _check_holding(
    arm: ArmModel, load: ArmLoad, angles: FloatArray, push: FloatArray, torque: FloatArray
) -> None:
    still = np.zeros(arm.dof)
    for index, (q, more) in enumerate(zip(angles, push, strict=True)):
        needed = np.abs(load.torques(q, still, still)) + more
        if (needed > _ROOM * torque).any():
            joint = int(np.argmax(needed / torque))
            raise Untrackable(
                index,
                f"takes {needed[joint]:.1f} Nm of {arm.joint_names[joint]!r}; "
                f"allowed: {_ROOM * torque[joint]:.1f} Nm at rest",
            )


def _fastest(
    arm: ArmModel, load: ArmLoad, path: ToolPath, angles: FloatArray, limits: TrackingLimits, push: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Arc lengths (g,) and the highest speed along the path at each (g,), from rest to rest."""
    spline = SplineInterpolator(path.lengths, angles, bc_type="not-a-knot")

    def velocity(s: float) -> FloatArray:
        """Joint limits (n, 2) that also keep the tool at its speed."""
        bound = np.minimum(arm.velocity, limits.speed * np.abs(spline(s, 1)) + 1e-9)
        return np.column_stack((-bound, bound))

    room = _ROOM * limits.torque - push.max(axis=0)
    constraints: list[Any] = [
        JointVelocityConstraintVarying(velocity),
        JointAccelerationConstraint(np.column_stack((-limits.acceleration, limits.acceleration))),
    ]
    still = np.zeros(arm.dof)
    if all((np.abs(load.torques(q, still, still)) < room).all() for q in angles):
        constraints.append(
            JointTorqueConstraint(load.torques, np.column_stack((-room, room)), np.zeros(arm.dof))
        )
    grid = np.unique(np.concatenate((path.lengths, np.linspace(0.0, path.length, 4 * len(path.points)))))
    solver = SeidelToppra(constraints, spline, grid)
    _, speed, _ = solver.compute_parameterization(0.0, 0.0)
    if speed is None or not np.all(np.isfinite(speed)):
        raise RuntimeError("TOPP-RA found no speed along a path from rest to rest")
    return grid, np.maximum(speed, 0.0)


def _progress(s: FloatArray, speed: FloatArray, times: FloatArray, at: FloatArray) -> FloatArray:
    """Return arc lengths (k,) in [m] at the times `at` (k,) in [s].

    Acceleration is constant between the points of the grid, which have arc lengths `s` (g,), speeds `speed`
    (g,) and times `times` (g,).
    """
    index = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(s) - 2)
    dt = at - times[index]
    gain = (speed[index + 1] - speed[index]) / (times[index + 1] - times[index])
    return np.asarray(np.clip(s[index] + speed[index] * dt + 0.5 * gain * dt**2, s[0], s[-1]))
