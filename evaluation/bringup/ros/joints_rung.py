"""The step that checks sign, unit and latency of each joint by a small motion."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.evaluation.bringup.operator import Held
from handcart.evaluation.bringup.rung import Facts, Rung, RungFailed
from handcart.primitives.contract.tracking_error_monitor import MAX_LAG_PERIODS
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .ros_site import RosSite
from .unit_words import unit_hint

TURN_RAD, SLIDE_M = math.radians(6.0), 0.02
"""Test motion of a revolute and of a prismatic joint, in [rad] and [m]."""
TURN_SPEED, SLIDE_SPEED = math.radians(6.0), 0.02
"""Speed of the test motion, in [rad/s] and [m/s]."""
SETTLE_S = 1.5
BEGUN_SHARE = 0.2
"""Share of the test motion from which a joint has begun to move: more than its noise."""
AHEAD_SHARE = 0.5
"""Share of the begun motion by which a reading can be ahead of its command by noise alone."""
MAX_ERROR = 0.25
"""Share by which the command, the reading and a person's measurement may differ."""
SLACK_RAD, SLACK_M = math.radians(1.0), 0.003
MAX_HAND_ERROR_M = 0.08
"""Maximum distance between the hand's position by its joints and as a person measures it with a tape."""
HAND_WORDS = ("forward (backward: negative)", "to the left (right: negative)", "up")
VISIBLE_MM = 2.0
"""Smallest shift of the hand that a person can see."""


class JointTrial(NamedTuple):
    """Commanded, measured and true amount of a small motion of one joint, in [rad] or [m]."""

    commanded: float
    read: float
    """Motion by `joint_states`."""
    true: float
    """Motion by the ground truth of a bench; 0 for a real robot."""
    latency_s: float
    """Time by which the reading follows the command, in whole periods; NaN if it does not follow it."""


class JointsRung(Rung[RosSite]):
    """Bring-up step that moves each joint a little, and compares command, reading and the motion that the
    operator sees.
    """

    name = "joints"
    summary = "each joint a little: command, joint_states and what is seen agree in sign, size and time"

    @override
    def left_out(self, site: RosSite) -> str:
        return "" if site.robot.arm is not None else "the robot has no arm"

    @override
    def climb(self, site: RosSite) -> Facts:
        assert site.robot.arm is not None, "left out otherwise"
        if not site.confirm("free", "Is the arm free by 10 cm around, in the posture that it has?"):
            raise RungFailed("the arm wasn't free")
        model = site.robot.arm_model()
        with site.backend() as backend:
            facts = _check_posture(site, backend, model)
            for number, name in enumerate(site.robot.arm.joints):
                facts[name] = self._try(site, backend, model, number)
        return facts

    def _try(self, site: RosSite, backend: RosBackend, model: ArmModel, number: int) -> Facts:
        arm = _arm_of(backend)
        name = model.joint_names[number]
        slides = site.robot.joint_units.slides[number]
        unit, shown = ("mm", 1e3) if slides else ("deg", math.degrees(1.0))
        way = _way(model, arm.joints(), number, slides)
        hand = hand_shift(model, arm.joints(), number, way)
        with site.operator.hold(f"{name}: hold the space bar; letting go stops it") as held:
            done = nudge(site, backend, number, way, held)
        question = (
            f"{name}: by how much did it {'slide' if slides else 'turn'} along the URDF's axis [{unit}]?"
            f" (against it: negative; by the file, {shown * way:+.3g} {unit}: {hand})"
        )
        measured = site.number(f"{name}_{unit}", question, shown * done.true) / shown
        slack = SLACK_M if slides else SLACK_RAD
        _compare(site, name, done, measured, (unit, shown, slack))
        _check_latency(site, name, done.latency_s)
        with site.operator.hold(f"{name}: hold the space bar; it goes back") as held:
            nudge(site, backend, number, -way, held)
        return {
            f"commanded_{unit}": round(shown * done.commanded, 2),
            f"read_{unit}": round(shown * done.read, 2),
            f"measured_{unit}": round(shown * measured, 2),
            "latency_s": round(done.latency_s, 3),
        }


def _check_posture(site: RosSite, backend: RosBackend, model: ArmModel) -> Facts:
    """Compare where the readings put the hand with where a person sees it, before anything moves.

    An arm whose readings are wrong would jump with the first command.

    Raises:
        RungFailed: the hand is elsewhere.
    """
    read = model.forward(_arm_of(backend).joints())[:3, 3]
    true = model.forward(_true_joints(backend))[:3, 3]
    seen = [
        site.number(
            f"hand_{name}_mm",
            f"How far {words} is the frame `hand` from the middle of the base, on the floor [mm]?",
            1e3 * float(place),
        )
        / 1e3
        for name, words, place in zip(("x", "y", "z"), HAND_WORDS, true, strict=True)
    ]
    off = float(np.linalg.norm(read - seen))
    if off > MAX_HAND_ERROR_M:
        read_at, seen_at = (", ".join(f"{1e3 * item:.0f}" for item in place) for place in (read, seen))
        raise RungFailed(
            f"{site.spec.joint_states.topic}: by the readings the hand is at ({read_at}) mm, it is at"
            f" ({seen_at}) mm; allowed: {1e3 * MAX_HAND_ERROR_M:.0f} mm;"
            " is a joint's sign, zero or unit another one?"
        )
    return {"hand_off_mm": round(1e3 * off, 1)}


def nudge(site: RosSite, backend: RosBackend, number: int, way: float, held: Held) -> JointTrial:
    """Command a small motion of one joint while a key is held, wait for rest, and return the result.

    Args:
        site: robot or bench.
        backend: the robot.
        number: number of the joint, from 0.
        way: change of the joint's command, in [rad] or [m]; the command never changes by more.
        held: returns whether the key is still held.

    Raises:
        RungFailed: the key was let go.
    """
    arm = _arm_of(backend)
    read, true = arm.joints(), _true_joints(backend)
    command = arm.command().copy()
    begun = float(command[number])
    top = SLIDE_SPEED if site.robot.joint_units.slides[number] else TURN_SPEED
    count = math.ceil(abs(way) / (min(top, float(site.robot.joint_speeds()[number])) * backend.period))
    lag = JointLag(abs(way) * BEGUN_SHARE)
    for step in range(1, count + 1):
        if not held():
            backend.stop()
            raise RungFailed("the key was let go before the motion was over")
        command[number] = begun + way * step / count
        arm.move(command)
        backend.step()
        lag.note(command[number] - begun, float(arm.joints()[number] - read[number]))
    for _ in range(round(SETTLE_S / backend.period)):
        backend.step()
        lag.note(way, float(arm.joints()[number] - read[number]))
    moved = float(arm.joints()[number] - read[number])
    seen = float(_true_joints(backend)[number] - true[number])
    return JointTrial(way, moved, seen, lag.periods * backend.period)


class JointLag:
    """Lag of a joint's measured position behind its command in a small test motion, in control periods."""

    def __init__(self, passed: float) -> None:
        """Prepare to detect a motion by `passed`, in [rad] or [m], in either direction."""
        self._passed, self._number = passed, 0
        self._commanded = self._read = math.nan
        self._is_moved_otherwise = False

    def note(self, commanded: float, read: float) -> None:
        """Record a joint's commanded and measured motion since the start, in [rad] or [m]; called once a
        period.
        """
        if math.isnan(self._commanded) and abs(commanded) >= self._passed:
            self._commanded = self._number
        if math.isnan(self._commanded):
            self._is_moved_otherwise |= abs(read) - abs(commanded) >= AHEAD_SHARE * self._passed
        if math.isnan(self._read) and abs(read) >= self._passed:
            self._read = self._number
        self._number += 1

    @property
    def periods(self) -> float:
        """Return the lag in periods, at least 0.

        NaN if the joint has not yet moved by the distance `passed` that the constructor received. NaN also if
        the joint moved clearly ahead of the command, because something else, such as an earlier command, then
        moved it.
        """
        if not math.isfinite(self._read) or self._is_moved_otherwise:
            return math.nan
        return max(0.0, self._read - self._commanded)


def hand_shift(model: ArmModel, joints: FloatArray, number: int, way: float) -> str:
    """Describe in words how the hand moves in the base's frame when one joint of the arm moves.

    Args:
        model: model of the arm.
        joints: (n,) joints before the motion, in [rad] or [m].
        number: number of the moving joint, from 0.
        way: motion of that joint, in [rad] or [m].
    """
    after = joints.copy()
    after[number] += way
    before_pose, after_pose = model.forward(joints), model.forward(after)
    shift = 1e3 * (after_pose[:3, 3] - before_pose[:3, 3])
    names = (("forward", "backward"), ("left", "right"), ("up", "down"))
    parts = [
        f"{abs(mm):.0f} mm {pair[mm < 0.0]}"
        for mm, pair in zip(shift.tolist(), names, strict=True)
        if abs(mm) >= VISIBLE_MM
    ]
    if parts:
        return f"the hand moves {', '.join(parts)}"
    turn = after_pose[:3, :3] @ before_pose[:3, :3].T
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    axis /= np.linalg.norm(axis)
    return f"the hand turns counter-clockwise seen against ({axis[0]:.1f}, {axis[1]:.1f}, {axis[2]:.1f})"


def _way(model: ArmModel, joints: FloatArray, number: int, slides: bool) -> float:
    """Return a small motion of a joint away from its nearer limit, in [rad], or [m] if it slides."""
    size = SLIDE_M if slides else TURN_RAD
    lower, upper, now = float(model.lower[number]), float(model.upper[number]), float(joints[number])
    return size if upper - now > now - lower or not math.isfinite(lower) else -size


def _compare(
    site: RosSite, name: str, done: JointTrial, measured: float, shown: tuple[str, float, float]
) -> None:
    """Raise `RungFailed` unless command, reading and the person's measurement agree."""
    unit, factor, slack = shown
    allowed = MAX_ERROR * abs(done.commanded) + slack
    command = f"{factor * done.commanded:.3g} {unit} were commanded"
    if abs(measured - done.commanded) > allowed:
        hint = unit_hint(done.commanded, measured)
        if "sign" in hint:
            there = name in site.spec.reversed
            hint += f": {'take it out of' if there else 'add it to'} `reversed`"
        raise RungFailed(f"{name}: {command}, it moved {factor * measured:.3g} {unit}; {hint}")
    if abs(done.read - done.commanded) > allowed:
        hint = unit_hint(done.read, done.commanded)
        topic = site.spec.joint_states.topic
        raise RungFailed(f"{name}: {command}, {topic} says {factor * done.read:.3g} {unit}; {hint}")


def _check_latency(site: RosSite, name: str, latency_s: float) -> None:
    """Raise `RungFailed` if a joint follows so late that each motion of the arm would end as not following
    its commands, and if its reading moved before its command.
    """
    if math.isnan(latency_s):
        raise RungFailed(
            f"{name}: its reading moved before its command, so its latency is unknown; does it still follow"
            " an earlier command, or did something push it?"
        )
    periods = MAX_LAG_PERIODS - 1
    most = periods * site.robot.period_s
    if latency_s > most + 1e-9:
        raise RungFailed(
            f"{name}: its reading follows {latency_s:.2f} s after the command; allowed: {most:.2f} s"
            f" ({periods} periods, `period_s`); does its controller smooth or queue commands, or is its"
            " reading late?"
        )


def _arm_of(backend: RosBackend) -> Arm:
    arm = backend.get(Arm)  # type: ignore[type-abstract]
    assert arm is not None, "the robot's file has one"
    return arm


def _true_joints(backend: RosBackend) -> FloatArray:
    """Return the true joints (n,) of a bench, in [rad] or [m]; zeros for a real robot."""
    truth = backend.ground_truth()
    return np.zeros_like(_arm_of(backend).joints()) if truth is None else truth.joints.copy()
