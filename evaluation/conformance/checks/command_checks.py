"""Checks of commands: limits, when they take effect, and that stop means stop."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from handcart.backends.backend import Backend, CommandError
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import RobotFile
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed, part_of
from handcart.evaluation.conformance.rig.periods import (
    SETTLING_PERIODS,
    all_readings,
    beside,
    drivable,
    steps,
)
from handcart.evaluation.conformance.rig.standing import MAX_REST_MOTION, TrueState

from .check import Check, CheckResult

REFUSED_NUMBERS = (math.nan, math.inf, -math.inf, 1e308, -1e308)
MAX_COASTING_M = 0.02  # [m] that a base may roll on after its last command


def limits(bench: KitBench, finding: CheckResult) -> None:
    """Check that commands of NaN, infinity, 1e308 and just beyond a limit are rejected and move nothing."""
    with bench.rig() as rig:
        commands = _bad_commands(bench, rig.backend)
        finding.measured.append(f"{len(commands)} tried")
        for words, command in commands:
            steps(rig.backend, 1)
            before = TrueState.of(rig.backend)
            try:
                command()
            except CommandError:
                pass  # the required answer
            except Exception as error:  # a backend under test may raise anything
                finding.wrong.append(f"{words}: {type(error).__name__} instead of CommandError")
            else:
                finding.wrong.append(f"{words} is taken")
            steps(rig.backend, 2)
            finding.wrong += [f"{words}: {item}" for item in before.moved(TrueState.of(rig.backend))]


def _bad_commands(bench: KitBench, backend: Backend) -> list[tuple[str, Callable[[], None]]]:
    spec, result = bench.spec(), list[tuple[str, Callable[[], None]]]()
    base = needed(backend, Base)
    top, turn = spec.drive.top_speed_m_s, math.radians(spec.drive.top_turn_deg_s)
    drives = [(bad, 0.0) for bad in (*REFUSED_NUMBERS, 1.01 * top, -1.01 * top)]
    drives += [(0.0, bad) for bad in (*REFUSED_NUMBERS, 1.01 * turn, -1.01 * turn)]
    for speed, rate in drives:
        result.append((f"drive({speed:g}, {rate:g})", lambda v=speed, w=rate: base.drive(v, w)))  # type: ignore[misc]
    arm, gripper = part_of(backend, Arm), part_of(backend, Gripper)
    if arm is not None and spec.arm is not None:
        held = arm.command()
        for number, top_rate in enumerate(spec.joint_speeds()):
            step = 1.5 * float(top_rate) * spec.period_s
            for bad in (*REFUSED_NUMBERS, 10.0, -10.0, held[number] + step, held[number] - step):
                joints = held.copy()
                joints[number] = bad
                result.append((f"joint {number + 1} to {bad:g}", lambda q=joints: arm.move(q)))  # type: ignore[misc]
        result.append(("a joint too few", lambda: arm.move(held[:-1])))
    if gripper is not None and spec.gripper is not None:
        for bad in (*REFUSED_NUMBERS, -0.001, spec.gripper.opening_mm / 1e3 + 0.001):
            result.append((f"a width of {bad:g}", lambda w=bad: gripper.move(w)))  # type: ignore[misc]
    return result


def after_a_step(bench: KitBench, finding: CheckResult) -> None:
    """Check that a command has no effect before the next step of the backend, and an effect in that step."""
    with bench.rig() as rig:
        backend = rig.backend
        steps(backend, 1)
        before, standing = all_readings(backend), TrueState.of(backend)
        _command_all(bench.spec(), backend)
        now = all_readings(backend)
        changed = [name for name in now if not np.array_equal(now[name], before[name], equal_nan=True)]
        finding.wrong += [f"{name} changes without a step" for name in changed]
        finding.wrong += [f"without a step {text}" for text in standing.truly_moved(TrueState.of(backend))]
        for _ in range(SETTLING_PERIODS):
            _command_all(bench.spec(), backend)
            backend.step()
        after = all_readings(backend)
        moving = {"wheels": "base wheel_travel", "joints": "arm joints", "width": "gripper width"}
        for name, reading in moving.items():
            if reading in after:
                far = float(np.abs(after[reading] - before[reading]).max())
                finding.expect(
                    far > 2 * MAX_REST_MOTION[name],
                    f"{name} don't follow a command of {SETTLING_PERIODS} periods",
                )


def one_period(bench: KitBench, finding: CheckResult) -> None:
    """Check that without a new command the base stops after one period, and arm and gripper stay where they
    are.
    """
    with bench.rig() as rig:
        backend = rig.backend
        for _ in range(SETTLING_PERIODS):
            _command_all(bench.spec(), backend)
            backend.step()
        last = needed(backend, Base).wheel_travel()
        steps(backend, SETTLING_PERIODS)
        coasted = float(np.abs(np.subtract(needed(backend, Base).wheel_travel(), last)).max())
        finding.at_most("rolled on without a command", 1e3 * coasted, 1e3 * MAX_COASTING_M, "mm")
        if (gripper := part_of(backend, Gripper)) is not None:
            gripper.move(gripper.width())
            steps(backend, SETTLING_PERIODS)
        before = TrueState.of(backend)
        steps(backend, 2 * SETTLING_PERIODS)
        finding.wrong += [f"without a command {item}" for item in before.moved(TrueState.of(backend))]


def stop(bench: KitBench, finding: CheckResult) -> None:
    """Check that after a call of `stop`, no command given before the call moves the robot any more."""
    seconds = 2.0
    for when in ("before its step", "in motion"):
        with bench.rig() as rig:
            backend = rig.backend
            steps(backend, 1)
            before = TrueState.of(backend)
            for _ in range(1 if when == "before its step" else SETTLING_PERIODS):
                _command_all(bench.spec(), backend)
                if when == "in motion":
                    backend.step()
            backend.stop()
            if when == "in motion":
                steps(backend, SETTLING_PERIODS)
                before = TrueState.of(backend)
            steps(backend, round(seconds / backend.period))
            wrong = before.moved(TrueState.of(backend))
            finding.wrong += [f"{when} stopped, yet within {seconds:g} s {item}" for item in wrong]


def close_twice(bench: KitBench, finding: CheckResult) -> None:
    """Check that closing a backend a second time has no effect and raises nothing."""
    rig = bench.rig()
    rig.backend.close()
    rig.backend.close()


def _command_all(spec: RobotFile, backend: Backend) -> None:
    """Command every actuator: the base ahead, a joint, the fingers."""
    needed(backend, Base).drive(*drivable(spec, 0.1, 0.1))
    arm, gripper = part_of(backend, Arm), part_of(backend, Gripper)
    if arm is not None:
        step = min(0.01, 0.5 * float(spec.joint_speeds()[-1]) * backend.period)
        arm.move(beside(spec, arm.command(), -1, step))
    if gripper is not None:
        gripper.move(max(0.0, gripper.command() - 0.001))


CHECKS = (
    Check("limits", "NaN, infinity, 1e308 and what is beyond a limit is refused, and nothing moves", limits),
    Check("after a step", "a command takes effect with the next step, not before", after_a_step),
    Check("one period", "a command not renewed stops the base; arm and gripper hold", one_period),
    Check("stop", "after stop nothing that was commanded before moves the robot", stop),
    Check("close", "closed twice, nothing happens", close_twice),
)
