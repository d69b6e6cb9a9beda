"""Logs of vehicles that the filters know nothing of; `benchmarks.field.foreign` plays more."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from benchmarks.field.foreign import JumpCount, Played, jumps_refused, played
from benchmarks.field.foreign_logs import SIDEWAYS_IMU, ForeignLog, record_foreign
from handcart.evaluation.offline_localization.checks.fix_noise import suppose_noise, white_error
from handcart.evaluation.offline_localization.checks.jump_gate import JumpGate
from handcart.evaluation.offline_localization.checks.mirror import check_mirror
from handcart.evaluation.offline_localization.checks.mount import axes_rotation, check_mount, mounted
from handcart.evaluation.offline_localization.checks.tilt import without_tilt_drift
from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import ANY_VEHICLE
from handcart.robotics.navigation.outdoors.gyro_odometry import GyroOdometry


@cache
def recorded(name: str, seed: int = 1, duration: float = 120.0) -> ForeignLog:
    return record_foreign(name, seed, duration)


@cache
def replayed(name: str, kind: str = "gps_filter") -> Played:
    return played(recorded(name), kind)


@pytest.mark.parametrize("name", ["mower", "truck", "skid"])
def test_a_foreign_vehicles_heading_is_known_within_30_s(name: str) -> None:
    found = replayed(name)
    assert found.known_after < 30.0
    assert 0.1 < found.nees < 6.0
    assert found.meanwhile < 6.0  # [m] off before the heading is known


def without_fixes_before(foreign: ForeignLog, time: float) -> ForeignLog:
    """The receiver begins to give fixes after a time in [s]; the start's heading is known."""
    log, fixes = foreign.log, foreign.log.fixes.copy()
    fixes[log.times < log.times[0] + time] = math.nan
    start = math.nan, math.nan, float(log.reference[0, 2])
    return foreign._replace(log=log._replace(fixes=fixes, start=start))


@pytest.mark.parametrize("name", ["mower", "truck"])
def test_a_late_first_fix_does_not_tell_where_the_drive_began(name: str) -> None:
    """A truck is claimed 2 m from where its first fix is, and is 140 m away from it."""
    found = played(without_fixes_before(recorded(name), 30.0)).replayed
    off = np.hypot(*found.errors[0, :2])
    claimed = math.sqrt(np.trace(found.covariances[0, :2, :2]))
    assert off > 5.0
    assert off < 2.0 * claimed


@pytest.mark.parametrize("name", ["mower", "skid"])
def test_particles_receive_the_vehicles_errors(name: str) -> None:
    """They were given the receiver's alone: 7.9 m off with 0.64 m claimed."""
    found = replayed(name, "particle")
    assert found.known_after < 60.0
    assert found.nees < 8.0
    assert found.refused < 0.2


def test_jumps_are_refused_and_listed_also_where_skipped() -> None:
    foreign = recorded("truck", seed=0)
    found = played(foreign)
    counted = jumps_refused(foreign, found.replayed)
    assert counted == JumpCount(counted.beyond_5, counted.beyond_5, counted.beyond_3, counted.beyond_3)
    assert counted.beyond_3 >= 2
    skipped = [fix for fix in found.replayed.fixes if not fix.believed and fix.time % 1.0 > 0.1]
    assert skipped
    assert all("against wheels and gyros" in fix.why for fix in skipped)


def test_good_fixes_pass_the_gate() -> None:
    found, log = replayed("mower"), recorded("mower")
    outside = sum(not fix.believed for fix in found.replayed.fixes) - (log.jumps > 0.0)[::20].sum()
    assert outside < 0.1 * len(found.replayed.fixes)


def test_the_white_error_is_estimated_from_the_log() -> None:
    truck, mower = (white_error(recorded(name).log.thinned(1.0), 1.0) for name in ("truck", "mower"))
    assert truck is not None
    assert mower is not None
    assert 0.35 < truck < 0.8  # 0.4 m white, some slow error within ten seconds
    assert 0.5 < mower < 1.0


def test_a_log_without_an_accuracy_says_what_is_supposed() -> None:
    supposed = suppose_noise(recorded("mower").log, ANY_VEHICLE)
    assert "states no accuracy of the fixes" in supposed.notes[0]
    assert 0.5 < supposed.noise.gps_white < 1.0


@pytest.mark.parametrize(("stated", "is_believed"), [(0.02, False), (0.7, True), (9.0, False)])
def test_an_accuracy_is_believed_if_the_fixes_agree(stated: float, is_believed: bool) -> None:
    log = recorded("mower").log
    log = log._replace(sigmas=np.where(np.isfinite(log.fixes[:, 0]), stated, math.nan))
    supposed = suppose_noise(log, ANY_VEHICLE)
    assert bool(np.isfinite(supposed.log.sigmas).any()) == is_believed
    doubts = [note for note in supposed.notes if f"the receiver states {stated:.2f} m" in note]
    assert len(doubts) == (not is_believed)


def test_a_vehicle_that_never_stands_does_not_tip_over() -> None:
    def tilt(log: DriveLog) -> float:
        odometry, most = GyroOdometry(Pose2(0.0, 0.0, 0.0)), 0.0
        for rates, felt, wheels in zip(log.rates, log.accelerations, log.wheels, strict=True):
            odometry.update(rates, felt, wheels, 0.05)
            most = max(most, *map(abs, odometry.tilt))
        return math.degrees(most)

    log = recorded("truck", seed=0).log
    assert tilt(log) > 10.0
    assert tilt(without_tilt_drift(log)) < 5.0


def test_a_unit_mounted_sideways_is_found_and_turned() -> None:
    log = recorded("skid").log
    mount = check_mount(log)
    assert "gravity is along its +y axis" in mount.words
    assert mount.axes == "z,x,y"
    turned = axes_rotation(mount.axes)
    assert turned is not None
    np.testing.assert_allclose(turned, SIDEWAYS_IMU.T)
    np.testing.assert_allclose(mount.base_R_imu, SIDEWAYS_IMU.T, atol=0.05)
    assert check_mount(mounted(log, mount.base_R_imu)).words == ""


UPRIGHT = mounted(record_foreign("skid", 1, 120.0).log, SIDEWAYS_IMU.T)


def test_a_unit_upside_down_is_told_from_one_that_reads_minus_g() -> None:
    assert check_mount(UPRIGHT).words == ""
    down = check_mount(mounted(UPRIGHT, np.diag([1.0, -1.0, -1.0])))
    assert down.axes == "x,-y,-z"
    minus = UPRIGHT._replace(accelerations=-UPRIGHT.accelerations)
    assert check_mount(minus).words == ""


def test_gyros_that_turn_without_the_wheels_are_found_without_gravity() -> None:
    turned = mounted(UPRIGHT, np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    found = check_mount(turned._replace(accelerations=0.0 * turned.accelerations))
    assert "its gyros turn with the wheels" in found.words


@pytest.mark.parametrize("axes", ["x,y", "x,x,z", "x,-y,z", "a,b,c", "", "x,y,z,x"])
def test_axes_that_are_no_frame_are_rejected(axes: str) -> None:
    assert axes_rotation(axes) is None


@pytest.mark.parametrize("name", ["truck", "skid"])
def test_exchanged_axes_of_the_fixes_show_as_a_mirror_image(name: str) -> None:
    log = UPRIGHT if name == "skid" else recorded(name).log
    assert check_mirror(log, 1.0) == ""
    assert "are exchanged" in check_mirror(log._replace(fixes=log.fixes[:, ::-1]), 1.0)


def test_a_doubtful_heading_turns_no_good_fix_into_a_jump() -> None:
    """A heading 0.2 rad off lays a fix 7 m aside after 35 m."""
    fix, there = 35.0 * np.array([math.cos(0.2), math.sin(0.2)]), Pose2(35.0, 0.0, 0.0)
    refused = []
    for doubt in (math.radians(1.0), math.radians(10.0)):
        gate = JumpGate(0.5)
        gate.refusal(0.0, np.zeros(2), Pose2(0.0, 0.0, 0.0), 0.0, 0.0, math.nan, doubt)
        refused.append(bool(gate.refusal(5.0, fix, there, 35.0, 0.0, math.nan, doubt)))
    assert refused == [True, False]
