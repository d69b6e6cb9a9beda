"""Checks of what a robot declares: units, frames, signs, rates."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.description.simulated_errors import Errors
from handcart.backends.robot.localization.lidar import Lidar
from handcart.backends.robot.mounted_camera import known_camera, mount_of
from handcart.backends.sensors.all_kinds import all_capabilities, is_declared
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed, part_of
from handcart.evaluation.conformance.rig.periods import (
    STEERING_PERIODS,
    all_readings,
    beside,
    changing_readings,
    different_readings,
    drivable,
    drive,
    driven,
    move_joints,
    noisy_readings,
    sideways_speed,
    steps,
)
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.robotics.numerics.arrays import FloatArray

from .check import Check, CheckResult

# share by which a simulated robot may differ from its file: radii, tread, slip, starting up
MAX_FILE_DIFFERENCE = 0.10
FORCE_AT_REST = 3.0  # [N]
MIN_LEVER_M = 0.1  # [m] from a joint to the hand, to convert the hand's error to an angle
STEERING_LOSS_RATIO = 0.7  # share of a car's turn that is lost while it steers
BEAM_DEG = 0.1  # by which a beam may be off where the robot's file has it
SIGN_TEST_MOVE_RAD = 0.02  # [rad] that a joint is moved for its sign


def declared(bench: KitBench, finding: CheckResult) -> None:
    """Check that the backend has exactly the capabilities (base, arm, sensors) that the robot's file has."""
    spec = bench.spec()
    with bench.rig() as rig:
        for kind in all_capabilities():
            wanted = is_declared(kind, spec)
            there = rig.backend.get(kind) is not None
            finding.expect(there or not wanted, f"the robot's file has a {kind.__name__}, the backend none")
            finding.expect(wanted or not there, f"the backend has a {kind.__name__}, the robot's file none")
        finding.measured.append(f"{len(rig.backend.capabilities())} capabilities")


def readings(bench: KitBench, finding: CheckResult) -> None:
    """Check the readings of the robot at rest in its posture `home`.

    They must have the right shapes, agree with that posture, and lie within the limits and the lidar's range
    that the robot's file states.
    """
    spec = bench.spec()
    with bench.rig() as rig:
        backend = rig.backend
        steps(backend, 2)
        travel = needed(backend, Base).wheel_travel()
        finding.at_most("wheel travel at rest", max(map(abs, travel)), 1e-3, "m")
        if (arm := part_of(backend, Arm)) is not None and spec.arm is not None:
            home = np.array(spec.posture("home"))
            finding.expect(arm.joints().shape == home.shape, f"{arm.joints().shape} joints, not {home.shape}")
            finding.at_most(
                "joints at home, off", math.degrees(np.abs(arm.joints() - home).max()), 0.5, "deg"
            )
            finding.expect(arm.hand_force().shape == (3,), "the force isn't (3,)")
            finding.at_most("force at rest", float(np.abs(arm.hand_force()).max()), FORCE_AT_REST, "N")
        if (gripper := part_of(backend, Gripper)) is not None and spec.gripper is not None:
            most = spec.gripper.opening_mm + 1.0
            finding.expect(0.0 <= gripper.width() <= most / 1e3, f"a width of {gripper.width()} m")
        if (camera := part_of(backend, Camera)) is not None and spec.camera is not None:
            image, size = camera.image(), (spec.camera.height_px, spec.camera.width_px)
            finding.expect(image.shape == size and image.dtype == np.uint8, f"the picture is {image.shape}")
            finding.expect(int(image.max()) - int(image.min()) > 20, "the picture shows nothing")
            finding.expect(abs(camera.model.K[0, 0] - spec.camera.focal_px) < 1e-6, "another focal length")
        if (sensor := part_of(backend, RangeSensor)) is not None and spec.range_sensor is not None:
            _scan_readings(sensor.scan(), Lidar(sensor, spec), spec.range_sensor, finding)


def _scan_readings(scan: Scan, lidar: Lidar, spec: RangeSpec, finding: CheckResult) -> None:
    """Check angles and ranges of a raw scan; a driver's substitutes for missing ranges are allowed."""
    finding.expect(scan.ranges.shape == scan.angles.shape == (spec.beams,), f"{scan.ranges.shape} beams")
    met = scan.ranges[np.isfinite(scan.ranges)]
    finding.expect(bool((met <= spec.reach_m).all()), "a range beyond the reach")
    finding.expect(bool((np.diff(scan.angles) > 0.0).all()), "the beams don't go counter-clockwise")
    if scan.angles.shape == (spec.beams,):
        off = np.degrees(np.abs(np.angle(np.exp(1j * (scan.angles - spec.angles())))).max())
        finding.at_most("beams off start_deg to end_deg", float(off), BEAM_DEG, "deg")
    finding.expect(not lidar.blockage, lidar.blockage)


def signs_of_the_base(bench: KitBench, finding: CheckResult) -> None:
    """Check that the base moves forward and turns left as commanded, by its wheels and the ground truth."""
    spec, tread = bench.spec(), bench.spec().drive.tread_m
    speed, turn_rate, car = 0.2, 0.5, spec.drive.kind == "ackermann"
    with bench.rig() as rig:
        curve = speed if car else 0.0  # there and back: rooms are small
        ways = [(speed, 0.0), (-speed, 0.0), (curve, turn_rate), (-curve, -turn_rate)]
        for forward, turn in (drivable(spec, *way) for way in ways):
            periods = STEERING_PERIODS if car and turn else 20
            seconds = periods * spec.period_s
            steers = STEERING_LOSS_RATIO * abs(turn) * seconds if car else 0.0
            before = rig.backend.ground_truth()
            left, right = driven(rig.backend, forward, turn, periods)
            far, round_ = 0.5 * (left + right), (right - left) / tread
            words = f"{forward:g} m/s and {turn:g} rad/s for {seconds:g} s"
            _near(finding, f"wheels by {words}", far, forward * seconds, 0.02, "m")
            _near(finding, f"wheels turn by {words}", round_, turn * seconds, max(steers, 0.03), "rad")
            after = rig.backend.ground_truth()
            if before is not None and after is not None:
                went = after.base.relative_to(before.base)
                _near(finding, f"truly by {words}", went.x, forward * seconds, 0.03, "m")
                room = max(steers, 0.05)
                _near(finding, f"truly turned by {words}", went.theta, turn * seconds, room, "rad")


def signs_of_sideways_motion(bench: KitBench, finding: CheckResult) -> None:
    """Check that a holonomic base moves to the left as commanded and does not turn.

    The motion is taken from the wheels' readings and the ground truth.
    """
    if bench.spec().drive.kind != "holonomic":
        raise Skipped("the base cannot drive sideways")
    with bench.rig() as rig:
        base, seconds = needed(rig.backend, Base), 20 * bench.spec().period_s
        speed = sideways_speed(bench.spec(), 0.2)
        for sideways in (speed, -speed):
            before, stood = base.wheel_travel(), rig.backend.ground_truth()
            drive(rig.backend, 0.0, 0.0, 20, sideways)
            went, after = np.subtract(base.wheel_travel(), before), rig.backend.ground_truth()
            words = f"{sideways:g} m/s sideways for {seconds:g} s"
            _near(finding, f"wheels by {words}", float(went[2]), sideways * seconds, 0.02, "m")
            finding.at_most(f"the sides rolled by {words}", float(np.abs(went[:2]).max()), 0.02, "m")
            if stood is not None and after is not None:
                moved = after.base.relative_to(stood.base)
                _near(finding, f"truly by {words}", moved.y, sideways * seconds, 0.04, "m")
                _near(finding, f"truly ahead by {words}", moved.x, 0.0, 0.03, "m")
                _near(finding, f"truly turned by {words}", moved.theta, 0.0, 0.05, "rad")


def signs_of_the_scan(bench: KitBench, finding: CheckResult) -> None:
    """Check that the lidar's scan turns to the right by the angle by which the base turns to the left."""
    if bench.spec().drive.kind == "ackermann":
        raise Skipped("a car can't turn on the spot")
    with bench.rig() as rig:
        sensor = needed(rig.backend, RangeSensor)
        steps(rig.backend, 1)
        before = Lidar(sensor, bench.spec()).scan()
        wanted, (_, turn_rate) = 0.5, drivable(bench.spec(), 0.0, 0.5)
        left, right = driven(rig.backend, 0.0, turn_rate, round(20 * wanted / turn_rate))
        turn = (right - left) / bench.spec().drive.tread_m
        after = Lidar(sensor, bench.spec()).scan()
        seen = best_turn(before.ranges, after.ranges, before.angles)
        _near(finding, "the scan turned", seen, -turn, 0.06, "rad")


def signs_of_the_joints(bench: KitBench, finding: CheckResult) -> None:
    """Check that each joint moves to its commanded angle, in [rad], while the others stay."""
    with bench.rig() as rig:
        arm = needed(rig.backend, Arm)
        start, gives = arm.command(), _gives(bench.spec().errors)
        worst = truly = 0.0
        for number in range(len(start)):
            for sign in (1.0, -1.0):
                goal = beside(bench.spec(), start, number, sign * (SIGN_TEST_MOVE_RAD + 2.0 * gives))
                move_joints(rig.backend, arm, goal)
                worst = max(worst, float(np.abs(arm.joints() - goal).max()))
                truth = rig.backend.ground_truth()
                if truth is not None:
                    truly = max(truly, float(np.abs(truth.joints - goal).max()))
            move_joints(rig.backend, arm, start)
        finding.at_most("joints off their command", 1e3 * worst, 5.0, "mrad")
        finding.at_most("joints truly off", 1e3 * truly, 5.0 + 1e3 * gives, "mrad")


def _gives(errors: Errors) -> float:
    """Return the allowed difference between a joint's true angle and its encoder, by the robot's errors, in
    [rad].
    """
    off = errors.hand_systematic_mm + 3.0 * errors.hand_repeat_mm + errors.hand_uniform_mm
    return off / 1e3 / MIN_LEVER_M


def fingers(bench: KitBench, finding: CheckResult) -> None:
    """Check that the fingers open to the commanded width, in [m], and press on each other when closed."""
    spec = bench.spec().gripper
    with bench.rig() as rig:
        gripper = needed(rig.backend, Gripper)
        assert spec is not None
        opening = spec.opening_mm / 1e3
        periods = round(1.5 * opening / (spec.speed_mm_s / 1e3) / rig.backend.period) + 10
        for width in (0.5 * opening, opening, 0.0):
            gripper.move(width)
            steps(rig.backend, periods)
            finding.at_most(f"opening of {1e3 * width:g}, off", 1e3 * abs(gripper.width() - width), 1.0, "mm")
        finding.expect(gripper.closed_on_something(), "closed fingers don't press on each other")


def mounts(bench: KitBench, finding: CheckResult) -> None:
    """Check that camera and lidar are mounted where the URDF, or a calibration, has them."""
    with bench.rig() as rig:
        robot = rig.robot
        if (camera := part_of(rig.backend, Camera)) is not None:
            assert robot.spec.camera is not None
            known = known_camera(robot.spec.camera, mount_of(robot.spec, robot.spec.camera))
            finding.expect(camera.carrier == known.carrier, f"the camera is carried by {camera.carrier!r}")
            off = float(np.abs(camera.carrier_T_camera - known.carrier_T_camera).max())
            finding.at_most("camera off", off, 1e-6)
        if (sensor := part_of(rig.backend, RangeSensor)) is not None:
            from handcart.robotics.kinematics.urdf_frames import base_T_frame

            assert robot.spec.range_sensor is not None
            urdf = base_T_frame(robot.spec.urdf_text(), robot.spec.link_of(robot.spec.range_sensor))
            beside = np.abs(np.array(sensor.scan().base_T_sensor[:2]) - urdf[:2, 3]).max()
            finding.at_most("range sensor off", float(beside), 1e-6, "m")


def rates(bench: KitBench, finding: CheckResult) -> None:
    """Check that each sensor has one reading a period, so that a second call in a period returns the same
    reading.

    Within the next periods the noise of a sensor must change its reading. A simulation without noise is
    accepted if its readings change while the base drives.
    """
    with bench.rig() as rig:
        backend = rig.backend
        steps(backend, 1)
        seen = all_readings(backend)
        again = all_readings(backend)
        finding.expect(set(seen) == set(again), "a reading comes and goes")
        for name in sorted(different_readings(seen, again)):
            finding.expect(False, f"asked again, {name} is another")
        fresh = changing_readings(backend, 5)
        finding.measured.append(f"new within five periods at rest: {', '.join(sorted(fresh)) or 'nothing'}")
        without_noise = noisy_readings(backend) - fresh
        if not without_noise:
            return
        if not backend.simulated:
            finding.expect(False, f"a sensor without noise for six periods is stale: {sorted(without_noise)}")
            return
        before = all_readings(backend)
        drive(backend, *drivable(bench.spec(), 0.1, 0.2), 20)
        after = all_readings(backend)
        stale = sorted(without_noise - different_readings(before, after))
        finding.expect(not stale, f"the same at rest and after the base drove: {stale}")
        finding.measured.append(f"without noise: {', '.join(sorted(without_noise))}")


def best_turn(before: FloatArray, after: FloatArray, angles: FloatArray) -> float:
    """Return the angle by which a later scan is turned to the left of an earlier one, in [rad].

    A scan turns to the left if the sensor turns to the right. Angles up to 1 rad to either side are tried.
    Scans of less than a full turn are compared where they overlap, up to half of their field of view.

    Args:
        before: (n,) ranges of the earlier scan, in [m].
        after: (n,) ranges of the later scan, in [m].
        angles: (n,) angles of the beams in the sensor's frame, evenly spaced, in [rad].
    """
    spacing, count = float(angles[1] - angles[0]), len(angles)
    whole = angles[-1] - angles[0] + 1.5 * spacing > 2.0 * math.pi
    most = min(round(1.0 / spacing), count if whole else count // 2)
    turns = np.arange(-most, most + 1)
    near, now = np.minimum(before, 5.0), np.minimum(after, 5.0)
    beams = np.arange(count)
    costs = []
    for turn in turns.tolist():
        overlaps = np.full(count, whole) | ((beams - turn >= 0) & (beams - turn < count))
        costs.append(float(np.median(np.abs(np.roll(near, turn) - now)[overlaps])))
    return float(turns[int(np.argmin(costs))] * spacing)


def _near(finding: CheckResult, what: str, found: float, wanted: float, room: float, unit: str) -> None:
    allowed = max(room, MAX_FILE_DIFFERENCE * abs(wanted))
    finding.expect(
        abs(found - wanted) <= allowed,
        f"{what}: {found:.3g} {unit}; allowed: {wanted:.3g} give or take {allowed:.2g}",
    )


CHECKS = (
    Check("capabilities", "the backend has what the robot's file says", declared),
    Check("readings", "shapes, units and ranges of readings at rest", readings),
    Check("base", "forward is forward, left is left, in m/s and rad/s", signs_of_the_base),
    Check("sideways", "left is left, in m/s, of a base that drives sideways", signs_of_sideways_motion),
    Check("scan's frame", "turning left moves what is seen to the right", signs_of_the_scan),
    Check("joints", "each joint moves to its commanded angle, in rad", signs_of_the_joints),
    Check("fingers", "they open to the commanded width, and press when closed", fingers),
    Check("mounts", "camera and range sensor are where the URDF has them", mounts),
    Check("rates", "a reading is taken once a period, and a new one in the next", rates),
)
