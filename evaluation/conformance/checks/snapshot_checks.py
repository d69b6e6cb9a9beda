"""Checks of snapshots: the state measured at the start of a primitive, and the return to it."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import part_of
from handcart.evaluation.conformance.rig.periods import beside, drivable, move_joints, steps
from handcart.evaluation.conformance.rig.reach import Reach
from handcart.evaluation.judging.true_changes import not_restored
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.outcomes.outcome import Fail
from handcart.primitives.outcomes.residual import Residual, ResidualKind
from handcart.primitives.restoring.snapshot import Snapshot, residuals, take_snapshot

from .check import Check, CheckResult

REST_READINGS = 20  # readings of a robot at rest
FAILS, FAILS_QUICK = 100, 20


def covers(bench: KitBench, finding: CheckResult) -> None:
    """Check that a snapshot of the robot's state shows that base, joints or fingers have moved.

    For this, the check moves each of them by more than its tolerance in the robot's file.
    """
    with bench.rig() as rig:
        backend = rig.backend
        _wait(rig, REST_READINGS)
        start = take_snapshot(rig.robot, {})
        truth = backend.ground_truth()
        if truth is not None:
            joints = len(truth.joints)
            finding.expect(len(start.joints) == joints, f"{len(start.joints)} of {joints} joints")
            finding.measured.append(f"{joints} joints, {len(truth.bodies)} bodies")
        seen = _beyond(rig, start)
        finding.expect(not seen, f"nothing was moved, yet {', '.join(kind.value for kind in seen)} is")
        tolerance = rig.robot.spec.tolerance
        arm, gripper = part_of(backend, Arm), part_of(backend, Gripper)
        if arm is not None:
            home = arm.command()
            for number in range(len(home)):
                slides = rig.robot.spec.joint_units.slides[number]
                way = 2e-3 * tolerance.slides_mm if slides else math.radians(2.0 * tolerance.joints_deg)
                goal = beside(bench.spec(), home, number, way)
                move_joints(backend, arm, goal)
                kind = ResidualKind.SLIDING_JOINTS if slides else ResidualKind.JOINTS
                finding.expect(kind in _beyond(rig, start), f"joint {number + 1} moves unseen")
                move_joints(backend, arm, home)
        if gripper is not None:
            before = gripper.command()
            gripper.move(max(0.0, before - 3e-3 * tolerance.gripper_mm))
            steps(backend, REST_READINGS)
            finding.expect(ResidualKind.GRIPPER in _beyond(rig, start), "the fingers move unseen")
            gripper.move(before)
            steps(backend, REST_READINGS)
        speed, _ = drivable(rig.robot.spec, 0.1, 0.0)
        drive_seen(rig, speed, 2e-3 * tolerance.base_mm / speed)
        finding.expect(ResidualKind.BASE_POSITION in _beyond(rig, start), "the base moves unseen")


def drive_seen(rig: Rig, speed: float, seconds: float) -> None:
    """Drive ahead, and wait until localization has updated its estimates.

    Args:
        rig: robot in its world.
        speed: speed of the base, in [m/s].
        seconds: duration of the drive, in [s].
    """
    for _ in range(math.ceil(seconds / rig.robot.period)):
        rig.robot.base.drive(speed, 0.0)
        rig.robot.step()
    _wait(rig, REST_READINGS)


def tolerances(bench: KitBench, finding: CheckResult) -> None:
    """Check that repeated snapshots of a robot at rest differ by less than the robot file's tolerances.

    The difference is taken as 3 sigma of the readings.
    """
    with bench.rig() as rig:
        drive_seen(rig, drivable(rig.robot.spec, 0.1, 0.0)[0], 0.5)
        first = take_snapshot(rig.robot, {})
        readings: list[list[Residual]] = []
        for _ in range(REST_READINGS):
            _wait(rig, 1)
            readings.append(_measured(rig, first))
        for item in zip(*readings, strict=True):
            name, limit = item[0].label, item[0].limit
            if item[0].kind is not ResidualKind.HELD and limit is not None:
                sigma = 3.0 * float(np.sqrt(np.mean(np.square([one.value for one in item])) / 2.0))
                finding.at_most(f"3 sigma of {name}", sigma, limit, name.rsplit("_", 1)[-1])


def drift(bench: KitBench, finding: CheckResult, kind: type[Reach] = Reach) -> None:
    """Check that a primitive that ends in Fail many times in a row does not move the robot away from its
    start.

    After each Fail the primitive restores the robot's state; the errors of these restorations must not add
    up.

    Args:
        bench: backend to check.
        finding: receives the result.
        kind: class of the primitive that fails.
    """
    times = FAILS_QUICK if bench.quick else FAILS
    with bench.rig() as rig:
        first = rig.backend.ground_truth()
        spec = bench.spec()
        for number in range(times):
            outcome = rig.do(kind(fails=True))
            if not isinstance(outcome, Fail):
                finding.wrong.append(f"Fail {number + 1} is {type(outcome).__name__}: {outcome}")
                return
        last = rig.backend.ground_truth()
        finding.measured.append(f"{times} Fails")
        if first is None or last is None:
            finding.measured.append("no ground truth")
            return
        finding.at_most("base drifted", 1e3 * first.base.distance(last.base), spec.tolerance.base_mm, "mm")
        finding.wrong += not_restored(first, last, spec)


def _wait(rig: Rig, periods: int) -> None:
    for _ in range(periods):
        rig.robot.step()


def _measured(rig: Rig, start: Snapshot) -> list[Residual]:
    """Return the residuals without the uncertainty of the base's pose."""
    found = residuals(start, take_snapshot(rig.robot, {}), rig.robot.spec)
    return [residual for residual in found.all if not residual.kind.is_uncertainty]


def _beyond(rig: Rig, start: Snapshot) -> list[ResidualKind]:
    return [residual.kind for residual in _measured(rig, start) if residual.is_motion]


CHECKS = (
    Check("snapshot", "whatever is moved beyond its tolerance is seen: base, each joint, fingers", covers),
    Check("tolerances", "3 sigma of readings at rest are within the robot's tolerances", tolerances),
    Check("drift", "many Fails in a row don't add up", drift),
)
