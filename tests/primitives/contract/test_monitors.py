"""When a base counts as stuck, and an arm as not following; the small values of a primitive's contract."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.description.joint_units import JointUnits
from handcart.primitives.contract.intents import UNRECORDED_INTENTS, Intents
from handcart.primitives.contract.standstill_monitor import (
    MIN_MOTION,
    STANDSTILL_TIMEOUT_S,
    StandstillMonitor,
)
from handcart.primitives.contract.tracking_error_monitor import (
    IN_A_ROW,
    MAX_LAG_PERIODS,
    TRACKING_TOLERANCE_RAD,
    TrackingErrorMonitor,
)
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.outcomes.calibrated import Calibrated, as_facts
from handcart.primitives.outcomes.cause import MAX_CALLS, Cause, cause_of
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success, fail_if_restored
from handcart.primitives.outcomes.residual import Residuals, read_residuals
from handcart.robotics.geometry.pose2 import Pose2

PERIOD = 0.0625


def base() -> Any:
    return SimpleNamespace(pose=Pose2(0.0, 0.0, 0.0), held=None, command=DriveCommand(), period=PERIOD)


def checks_until_stuck(robot: Any, monitor: StandstillMonitor, most: int = 400) -> int | None:
    """Return the number of checks until the base counts as stuck; None if it never does."""
    for number in range(most):
        try:
            monitor.check()
        except Discrepancy as stuck:
            assert stuck.check == "standstill"
            assert stuck.measured == Measured(
                "Base", "time driven without moving", STANDSTILL_TIMEOUT_S + PERIOD, STANDSTILL_TIMEOUT_S, "s"
            )
            return number
    return None


@pytest.mark.parametrize("driven", [(0.1, 0.0), (0.0, -0.1), (-0.1, 0.0), (0.0, 0.0, 0.1)])
def test_a_base_that_is_driven_and_stands_is_stuck_after_its_time(driven: tuple[float, ...]) -> None:
    robot = base()
    robot.command = DriveCommand(*driven)
    assert checks_until_stuck(robot, StandstillMonitor(robot)) == round(STANDSTILL_TIMEOUT_S / PERIOD) == 160


def test_a_base_that_is_not_driven_or_waits_is_not_stuck() -> None:
    robot = base()
    monitor = StandstillMonitor(robot)
    assert checks_until_stuck(robot, monitor) is None
    robot.command, robot.held = DriveCommand(0.1), "somebody"
    assert checks_until_stuck(robot, monitor) is None


@pytest.mark.parametrize(
    ("step", "stuck"),
    [
        ((0.9 * MIN_MOTION[0], 0.0, 0.0), True),
        ((0.0, 1.1 * MIN_MOTION[0], 0.0), False),
        ((0.0, 0.0, 0.9 * MIN_MOTION[1]), True),
        ((0.0, 0.0, -1.1 * MIN_MOTION[1]), False),
    ],
)
def test_motion_begins_the_time_again_and_trembling_does_not(
    step: tuple[float, float, float], stuck: bool
) -> None:
    robot = base()
    monitor = StandstillMonitor(robot)
    robot.command = DriveCommand(0.1)
    assert checks_until_stuck(robot, monitor, 150) is None
    robot.pose = Pose2(*step)
    expected = 160 - 150 if stuck else 161
    assert checks_until_stuck(robot, monitor) == expected
    assert math.degrees(MIN_MOTION[1]) == pytest.approx(0.3)


class Follows:
    """An arm of two joints, its readings and commands as the test says."""

    def __init__(self, slides: bool = False) -> None:
        self.reading, self.commanded = np.zeros(2), np.zeros(2)
        units = JointUnits(("a", "b"), (False, slides), (False, False))
        self.spec = SimpleNamespace(joint_units=units)
        self.backend = SimpleNamespace(get=lambda _: self)

    def joints(self) -> Any:
        return self.reading

    def command(self) -> Any:
        return self.commanded


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("off", "late"),
    [(0.99 * TRACKING_TOLERANCE_RAD, False), (1.01 * TRACKING_TOLERANCE_RAD, True), (math.nan, True)],
)
def test_a_joint_off_all_its_commands_is_noticed_after_some_periods(
    sign: float, off: float, late: bool
) -> None:
    arm: Any = Follows()
    monitor = TrackingErrorMonitor(arm)
    arm.reading = np.array([0.0, sign * off])
    for _ in range(MAX_LAG_PERIODS + IN_A_ROW - 2):
        monitor.check()
    if not late:
        for _ in range(10):
            monitor.check()
        return
    with pytest.raises(Discrepancy) as error:
        monitor.check()
    assert error.value.check == "following"
    if not math.isnan(off):
        assert str(error.value) == "joint 2 is 0.02 rad from its command"
        expected = Measured("Arm", "joint 2 off its command", off, TRACKING_TOLERANCE_RAD, "rad")
        assert error.value.measured == expected


def test_a_sliding_joint_is_told_in_mm() -> None:
    arm: Any = Follows(slides=True)
    monitor = TrackingErrorMonitor(arm)
    arm.reading = np.array([0.0, -0.0304])
    with pytest.raises(Discrepancy, match=r"joint 2 is 30\.4 mm from its command") as error:
        for _ in range(20):
            monitor.check()
    assert error.value.measured == Measured("Arm", "joint 2 off its command", 30.4, 20.0, "mm")


def test_joints_may_follow_late_but_not_later() -> None:
    """The allowed lag is the number of kept commands; a single reading may be broken."""
    for late in (MAX_LAG_PERIODS - 1, MAX_LAG_PERIODS):
        arm: Any = Follows()
        monitor = TrackingErrorMonitor(arm)
        noticed = False
        for period in range(40):
            arm.commanded = np.array([0.1 * period, 0.0])
            arm.reading = np.array([0.1 * max(0, period - late), 0.0])
            try:
                monitor.check()
            except Discrepancy:
                noticed = True
                break
        assert noticed == (late == MAX_LAG_PERIODS)
    arm = Follows()
    monitor = TrackingErrorMonitor(arm)
    for period in range(60):
        arm.reading = np.array([9.0 if period % 3 else 0.0, 0.0])
        monitor.check()


def test_a_robot_without_an_arm_has_nothing_to_follow() -> None:
    robot: Any = SimpleNamespace(backend=SimpleNamespace(get=lambda _: None))
    for _ in range(20):
        TrackingErrorMonitor(robot).check()


def test_a_fail_is_given_where_all_is_within_its_limit() -> None:
    at, over = {"base_mm": 40.0, "held": 0.0}, {"base_mm": 40.0, "held": 0.0}
    assert isinstance(fail_if_restored("why", True, read_residuals(at, over)), Fail)
    far = read_residuals({"base_mm": 40.01, "held": math.inf, "x": 1.0}, {**over, "x": 2})
    outcome = fail_if_restored("why", False, far)
    words = "why; and not restored: base_mm 40 (at most 40), held inf (at most 0)"
    assert outcome == GiveUp(words, far)
    assert isinstance(fail_if_restored("why", False, read_residuals({"base_mm": math.nan}, over)), GiveUp)
    assert isinstance(fail_if_restored("why", False, Residuals()), Fail)


def test_outcomes_and_causes_do_not_change_any_more() -> None:
    fail = fail_if_restored("why", False, Residuals())
    outcome: Any
    for outcome in (Success(), fail, GiveUp("why"), Cause("why", "motion")):
        with pytest.raises(FrozenInstanceError):
            outcome.reason = "because"
    assert (Success().evidence, len(GiveUp("why").residuals)) == ({}, 0)
    assert "_proof" not in repr(fail)


def test_what_is_raised_says_what_was_measured_and_by_whom() -> None:
    read = Measured("Arm", "force", 8.0, 7.0, "N")
    plain, full = Discrepancy("why"), Discrepancy("why", True, read, "rest")
    assert (plain.permanent, plain.measured, plain.check) == (False, None, "")
    assert (str(full), full.permanent, full.measured, full.check) == ("why", True, read, "rest")
    need = NeedsPerson("why", read, "push")
    assert (str(need), need.reason, need.measured, need.check) == ("why", "why", read, "push")
    assert Measured("Camera", "marks") == ("Camera", "marks", None, None, "")


def raised(error: Exception, deep: int = 0) -> Exception:
    """The error with its traceback, from some functions deeper."""

    def deeper(left: int) -> None:
        if left:
            deeper(left - 1)
        raise error

    try:
        deeper(deep)
    except Exception as caught:
        return caught
    raise AssertionError


def test_a_cause_names_the_calls_and_no_more_than_some() -> None:
    cause = cause_of(raised(Discrepancy("why"), deep=2), restoring=False)
    assert cause.calls == ("raised", *["raised.<locals>.deeper"] * 3)
    assert (cause.check, cause.fault, cause.restoring) == ("framework", "", False)
    assert len(cause_of(raised(Discrepancy("why"), deep=30), restoring=False).calls) == MAX_CALLS
    fault = cause_of(raised(KeyError("x")), restoring=True)
    assert (fault.check, fault.fault, fault.restoring, fault.reason) == ("restore", "KeyError", True, "'x'")
    assert cause_of(raised(NeedsPerson("why", check="push")), restoring=False).check == "push"
    evidence = Evidence()
    evidence.blame(raised(Discrepancy("one")))
    evidence.blame(raised(Discrepancy("two")), restoring=True)
    assert [(item.reason, item.restoring) for item in evidence.causes] == [("one", False), ("two", True)]


def test_calibrated_values_are_told_by_the_end_of_their_key() -> None:
    found = {
        "camera.calibrated.focal_px": Calibrated(601.23456, 0.123456),
        "offset": Calibrated((0.123456, -2.0), (0.01, 0.02)),
    }
    assert as_facts(found) == {
        "focal_px": 601.23,
        "focal_px_sigma": 0.12346,
        "offset": "0.1235, -2",
        "offset_sigma": "0.01, 0.02",
    }


def test_a_meant_contact_covers_its_part_and_name_alone() -> None:
    meant = MeantContact("hand", "book_*")
    assert meant.covers("hand", "book_3")
    assert not meant.covers("arm", "book_3")
    assert not meant.covers("hand", "shelf")
    assert not meant.covers("hand", "Book_3")


def test_without_a_journal_all_that_is_intended_is_kept_at_once() -> None:
    UNRECORDED_INTENTS.intends("the lamp goes out")
    UNRECORDED_INTENTS.passed("it is out")
    assert Intents().kept is True
