"""Tests of the framework with a faulty robot: rows B6, S1 to S3, S11, S12 of the fault catalogue."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.capabilities.imu import Imu
from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.robot.robot import Robot
from handcart.backends.robot.robot_errors import StaleReading
from handcart.evaluation.conformance.faults.fault import FOR_GOOD, Fault, FaultKind
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend
from handcart.evaluation.conformance.faults.rehearsal import Solo
from handcart.evaluation.conformance.faults.underway import AttemptEnding, Underway
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.reach import Reach
from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.trials.rig import Rig
from handcart.networks.task.preparing import prepare
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.outcome import Fail, GiveUp
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

BENCH = KitBench("kinematic")
WORLD = SHIPPED_FOLDER.parents[1] / "tasks" / "return_book" / "world.yaml"
FIELD = Path(__file__).parents[3] / "tasks" / "deploy_straight" / "task.yaml"


class Stand(ActionPrimitive):
    """Stays at rest for four seconds."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield from robot.wait(4.0)


def ended(primitive: ActionPrimitive, period: int, fault: Fault) -> tuple[AttemptEnding, Underway]:
    """Return the end of an attempt with a fault from a period on."""
    for _, _, underway in Solo(BENCH, primitive).attempts():
        for _ in range(period):
            underway.advance()
        return underway.finish(fault), underway
    raise AssertionError


@pytest.mark.parametrize(("speed", "turn_rate"), [(0.1, 0.0), (0.0, 0.12), (0.0, -0.12)])
def test_a_base_that_is_moved_while_it_stands_needs_a_person(speed: float, turn_rate: float) -> None:
    slide = Fault(FaultKind.SLIP, periods=10, speed=speed, turn_rate=turn_rate)
    ending, _ = ended(Stand(), 40, slide)
    assert (ending.outcome, ending.wrong) == ("GiveUp", ())
    assert ending.reason == "the base was moved while it stood"


@pytest.mark.parametrize(("aside_m", "pushes"), [(0.04, 1), (0.0, 0)])
def test_a_base_whose_wheels_roll_as_it_is_pushed_is_noticed_too(aside_m: float, pushes: int) -> None:
    with BENCH.rig() as rig:
        robot, scene = rig.robot, simulated_world(rig.backend)
        assert scene is not None
        for _ in range(25):
            robot.step()
        scene.base = scene.base.compose(Pose2(0.0, aside_m, 0.0))
        for _ in range(10):
            robot.base.drive(0.1, 0.0)
            robot.step()
        assert robot.localization.displacements == pushes


@pytest.mark.slow
@pytest.mark.parametrize("periods", [5, 60])
def test_an_old_scan_is_not_taken_for_a_new_one(periods: int) -> None:
    ending, _ = ended(Reach(ahead_m=0.4, fails=True), 10, Fault(FaultKind.STALE, "range", periods))
    assert (ending.outcome, ending.wrong) == ("Fail", ())


@pytest.mark.slow
def test_a_lost_robot_knows_nothing_of_its_pose() -> None:
    """S12: scans no longer fit, and none is taken for a new one."""
    ending, underway = ended(Reach(ahead_m=0.4, fails=True), 10, Fault(FaultKind.STALE, "range", FOR_GOOD))
    assert (ending.outcome, ending.wrong) == ("GiveUp", ())
    assert underway.robot.localization.lost
    assert underway.robot.localization.sigma == (math.inf, math.inf)


@pytest.mark.slow
@pytest.mark.parametrize("read", ["nothing", "the same", "the same for a while"])
def test_gyros_that_tell_nothing_new_are_not_believed(read: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """S2, S3: outdoors no other sensor reports at once how the base turns."""
    with prepare(FIELD, None, {}, 0) as prepared:
        rig = Rig(prepared.robot, prepared.model, prepared.backend)
        imu: Imu | None = rig.backend.get(Imu)  # type: ignore[type-abstract]
        rates, accelerations = rig.robot.get(Imu).rates, rig.robot.get(Imu).accelerations  # type: ignore[type-abstract]
        wrong: tuple[FloatArray, FloatArray] | None = None

        def read_now() -> tuple[FloatArray, FloatArray]:
            nonlocal wrong
            rolled = rig.robot.localization.travel.left
            if rolled < 1.0 or (read.endswith("while") and rolled > 1.1):
                return rates(), accelerations()
            if wrong is None:
                wrong = rates(), accelerations()
            return (np.full(3, np.nan), wrong[1]) if read == "nothing" else wrong

        monkeypatch.setattr(imu, "rates", lambda: read_now()[0])
        monkeypatch.setattr(imu, "accelerations", lambda: read_now()[1])
        world = simulated_world(rig.backend)
        assert world is not None
        begun = world.base
        ended = rig.do(MoveTo(place="1"))
        if read.endswith("while"):
            # It arrived, but its heading is less certain. It came back beside its start and was shunted.
            assert isinstance(ended, Fail), ended
            assert ended.reason.startswith("not determined: at 1 the position")
            assert math.dist(begun[:2], world.base[:2]) < rig.robot.spec.tolerance.base_mm / 1e3
            return
        assert isinstance(ended, GiveUp), ended
        assert ended.reason.startswith(
            "the robot doesn't know where it is: its gyros read nothing, or the same"
        )
        assert rig.robot.localization.travel.left < 1.6


@pytest.mark.parametrize("kind", [FaultKind.STUCK, FaultKind.STALE, FaultKind.NAN])
def test_an_arm_that_does_not_follow_is_noticed(kind: FaultKind) -> None:
    ending, _ = ended(Reach(ahead_m=0.0, swing_rad=0.5), 10, Fault(kind, "joints", FOR_GOOD))
    assert ending.outcome in ("Fail", "GiveUp")
    assert ending.wrong == ()
    assert "from its command" in ending.reason


def test_one_broken_reading_of_the_wheels_is_left_out() -> None:
    ending, underway = ended(Reach(), 10, Fault(FaultKind.NAN, "wheels", 1))
    assert (ending.outcome, ending.wrong) == ("Success", ())
    assert np.isfinite([underway.robot.pose.x, underway.robot.pose.theta]).all()


@pytest.mark.slow
def test_base_stuck_close_to_its_goal_is_given_up() -> None:
    _, _, underway = next(Solo(BENCH, MoveTo(place="shelf_3")).attempts())
    goal = underway.model.places["shelf_3"].pose
    while underway.robot.pose.distance(goal) > 0.04:
        assert underway.advance() is None
    ending = underway.finish(Fault(FaultKind.STUCK, periods=FOR_GOOD))
    assert ending.bitten
    assert (ending.outcome, ending.wrong) == ("GiveUp", ())  # it can't be brought back either
    assert "the base doesn't move, though it is driven" in ending.reason


def test_an_old_picture_is_not_taken_for_a_new_one() -> None:
    """S11: though the camera has moved."""
    with BENCH.rig() as rig:
        faulty = FaultyBackend(rig.backend)
        robot = BENCH.around(rig, faulty).robot
        robot.step()
        first = robot.picture()
        assert robot.picture() is first
        faulty.inject(Fault(FaultKind.STALE, "camera", FOR_GOOD))
        robot.step()
        assert np.array_equal(robot.picture(), first)  # nothing has moved: it may look the same
        joints = robot.arm.command()
        joints[0] += 0.02
        robot.arm.move(joints)
        robot.step()
        with pytest.raises(StaleReading, match="last picture again"):
            robot.picture()


def test_old_picture_is_detected_after_the_camera_came_back() -> None:
    """S11: at the same place a new picture has other noise."""
    with BENCH.rig() as rig:
        faulty = FaultyBackend(rig.backend)
        robot = BENCH.around(rig, faulty).robot
        robot.step()
        robot.picture()
        faulty.inject(Fault(FaultKind.STALE, "camera", FOR_GOOD))
        there_and_back(robot)
        with pytest.raises(StaleReading, match="last picture again"):
            robot.picture()


def test_noiseless_camera_may_repeat_a_picture_when_it_returns() -> None:
    spec = load_robot("librarian").without_errors()
    with make_backend("kinematic", spec, WORLD, 0) as backend:
        robot = Robot(backend, spec, Pose2(0.0, 0.0, 0.0))
        robot.step()
        first = robot.picture().copy()
        there_and_back(robot)
        assert np.array_equal(robot.picture(), first)


def there_and_back(robot: Robot) -> None:
    here = robot.arm.command()
    for turn in (0.02, 0.0):
        robot.arm.move(here + np.r_[turn, np.zeros(here.size - 1)])
        for _ in range(20):
            robot.step()
