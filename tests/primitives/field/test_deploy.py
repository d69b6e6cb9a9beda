"""Tests of DEPLOY alone: a base at rest next to its target."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.backend import CommandError
from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.localization.lost import Lost
from handcart.backends.simulation.field.field_props import FieldProps
from handcart.evaluation.trials.rig import Rig
from handcart.files.models.loading import load
from handcart.networks.task.preparing import prepare
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.field.deploy import Deploy, _spread
from handcart.primitives.field.field import Field
from handcart.primitives.field.field_work import FieldWork
from handcart.primitives.field.scara_arm import scara_of
from handcart.primitives.field.sensor_arm import MAX_YIELD_M, SensorArm
from handcart.primitives.field.target import Laid
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.primitives.restoring.patience import Patience
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform

TASK = Path(__file__).parents[3] / "tasks" / "deploy_straight" / "task.yaml"
TARGETS = "name,x_m,y_m\nhere,0.05,-0.76\nfar,14,-0.75\n"
WORLD = """\
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0}
ground: {}
sensors: {count: 2}
"""


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    (tmp_path / "targets.csv").write_text(TARGETS, encoding="utf-8")
    (tmp_path / "world.yaml").write_text(WORLD, encoding="utf-8")
    settings = {"targets": str(tmp_path / "targets.csv"), "world": str(tmp_path / "world.yaml")}
    with prepare(TASK, None, settings, 2) as prepared:
        yield Rig(prepared.robot, prepared.model, prepared.backend)


def lying(rig: Rig) -> Any:
    return rig.backend.scene.of(FieldProps).sensors["1"]  # type: ignore[attr-defined]


@pytest.mark.parametrize("towards", [0.0, 90.0, 180.0, 270.0])
def test_reach_is_measured_from_the_arms_own_joint(rig: Rig, towards: float) -> None:
    """The same in all directions, however far from the base's origin the arm is mounted."""
    field = rig.model.of(FieldWork).field
    assert field is not None
    arm = SensorArm(rig.robot, field)
    arm.scara = arm.scara._replace(mount=(0.3, 0.1, *arm.scara.mount[2:]))
    reach, heading = arm.scara.upper + arm.scara.fore, math.radians(towards)
    ahead = np.array([math.cos(heading), math.sin(heading)])
    arm.check_near((reach + 0.029) * ahead, unsure=0.03)
    with pytest.raises(Discrepancy, match="doesn't reach"):
        arm.check_near((reach + 0.031) * ahead, unsure=0.03)


@pytest.mark.slow
def test_a_sensor_is_laid_where_it_is_believed_to_be(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its ellipse is what the pose's errors make of it; where it lies no other is laid."""
    robot, noted, deploy = rig.robot, [], Deploy(target="here")
    model: Any = rig.model
    where = robot.localization
    monkeypatch.setattr(where, "mark", lambda: noted.append((where.pose, where.covariance)))
    assert deploy.unmet_precondition(robot, model) == ""
    assert isinstance(rig.do(deploy), Success)
    assert deploy.unmet_precondition(robot, model) == "the sensor of target 'here' is laid already"
    assert "doesn't reach the target" in Deploy(target="far").unmet_precondition(robot, model)
    assert "unknown target 'there'" in Deploy(target="there").unmet_precondition(robot, model)
    (laid,) = rig.model.of(FieldWork).laid
    truly = rig.backend.scene.base.inverse().apply(lying(rig).pose[None, :2, 3])[0]  # type: ignore[attr-defined]
    assert lying(rig).rest.value == "table"
    assert truly == pytest.approx(laid.beside, abs=0.03)
    ((pose, covariance),) = noted
    assert pose.apply(np.array([laid.beside]))[0] == pytest.approx((laid.x, laid.y))
    draws = np.random.default_rng(0).multivariate_normal(pose, covariance, 20_000)
    places = np.array([Pose2(*draw).apply(np.array([laid.beside]))[0] for draw in draws.tolist()])
    spread = np.cov(places.T)
    assert laid.spread == pytest.approx(spread, abs=0.03 * float(np.trace(spread)))


@pytest.mark.slow
def test_without_ground_below_it_the_sensor_is_not_let_go(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pit that is deeper than the arm looks for ground."""
    monkeypatch.setattr("handcart.primitives.field.deploy.GROUND_TOLERANCE_M", -0.06)
    failed = rig.do(Deploy(target="here"))
    assert isinstance(failed, Fail), failed
    assert failed.reason == "no ground is below the sensor"
    assert rig.model.of(FieldWork).laid == ()


@pytest.mark.slow
def test_a_sensor_that_falls_over_when_it_is_let_go_is_no_success(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Closed fingers feel for its top. A released sensor cannot be taken back: a person has to look."""

    def fall(sensor: Any) -> None:
        sensor.pose = sensor.pose @ transform((0.2, 0.0, 0.03), (0.0, np.pi / 2, 0.0))

    scene, fallen = rig.backend.scene, False  # type: ignore[attr-defined]
    step = rig.robot.step

    def watching(*slow: bool) -> None:
        nonlocal fallen
        step(*slow)
        sensors = scene.of(FieldProps).sensors
        if not fallen and "1" in sensors and sensors["1"].rest.value == "table":
            fall(sensors["1"])
            scene.changes, fallen = scene.changes + 1, True

    monkeypatch.setattr(rig.robot, "step", watching)
    ended = rig.do(Deploy(target="here"))
    assert isinstance(ended, GiveUp), ended
    assert ended.reason.startswith("the sensor fell over")
    joints = np.array(rig.robot.spec.posture("home"))
    assert np.allclose(rig.robot.arm.command(), joints)


@pytest.mark.slow
@pytest.mark.parametrize("after", [1, 20, 60])
def test_cancel_while_fingers_open_completes_the_release(rig: Rig, after: int) -> None:
    """Half open they would let it slide; the arm isn't to carry off what they still hold."""
    deploy, robot = Deploy(target="here"), rig.robot
    periods = attempt(deploy, robot, rig.model)
    while deploy._no_return is None:
        next(periods)
        robot.step()
    for _ in range(after):
        next(periods)
        robot.step()
    where = lying(rig).pose.copy()
    periods.throw(Discrepancy("cancelled by the operator"))
    ended = None
    while ended is None:
        robot.step()
        try:
            next(periods)
        except StopIteration as end:
            ended = end.value
    assert isinstance(ended, GiveUp), ended
    assert ended.reason.startswith("cancelled by the operator; after a point of no return")
    assert lying(rig).rest.value == "table"
    assert np.linalg.norm(lying(rig).pose[:3, 3] - where[:3, 3]) < 0.01
    assert robot.gripper.width() > 0.025
    assert robot.arm.command() == pytest.approx(robot.spec.posture("home"), abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("after", "falls"), [(1, False), (40, False), (200, False), (40, True)])
def test_refused_commands_after_release_leave_a_measured_success(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, after: int, falls: bool
) -> None:
    """The release is completed, and closed fingers feel for the sensor; where it fell a person looks."""
    robot, deploy, left = rig.robot, Deploy(target="here"), [0]

    def refusing(command: Any) -> Any:
        def commanded(*given: Any) -> None:
            left[0] -= 1
            if left[0] >= 0:
                raise CommandError("refused")
            command(*given)

        return commanded

    for actuator in (robot.arm, robot.gripper):
        monkeypatch.setattr(actuator, "move", refusing(actuator.move))
    periods, count, ended = attempt(deploy, robot, rig.model, patience=Patience(3, 0.2)), 0, None
    while ended is None:
        robot.step()
        count += deploy._no_return is not None
        left[0] = 2 if count == after else left[0]
        if count == after and falls:
            lying(rig).pose = lying(rig).pose @ transform((0.2, 0.0, 0.03), (0.0, np.pi / 2, 0.0))
            rig.backend.scene.changes += 1  # type: ignore[attr-defined]
        try:
            next(periods)
        except StopIteration as end:
            ended = end.value
    assert left[0] < 0
    assert isinstance(ended, GiveUp if falls else Success), ended
    if not falls:
        assert deploy.facts["finished_after"] == "CommandError: refused"
        assert lying(rig).rest.value == "table"
    assert robot.arm.command() == pytest.approx(robot.spec.posture("home"), abs=1e-3)


@pytest.mark.parametrize("pushed", [-0.8, 0.8])
def test_the_hand_gives_way_to_what_leans_on_a_finger(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, pushed: float
) -> None:
    """It moves as far as it is pushed, in that direction, up to the arm's limit."""
    robot = rig.robot
    field = rig.model.of(FieldWork).field
    assert field is not None
    arm = SensorArm(robot, field)
    for step in (arm.take(), arm.reach(arm.place_beside(np.array([0.05, -0.76])))):
        for _ in step:
            robot.step()
    until = 0.02 if pushed > 0.0 else 1.0
    begun = robot.base_T("hand")

    def gone() -> float:
        return float((robot.base_T("hand") - begun)[:3, 3] @ begun[:3, 1])

    def force() -> Any:
        return np.array([0.0, pushed if abs(gone()) < until else 0.0, 0.0])

    monkeypatch.setattr(robot.backend.get(Arm), "hand_force", force)  # type: ignore[type-abstract]
    for _ in arm.give_way():
        robot.step()
    farthest = min(until, MAX_YIELD_M)
    assert math.copysign(1.0, pushed) * gone() == pytest.approx(farthest, abs=0.006)


@pytest.mark.parametrize("free_above", [0.36, 0.0])
def test_on_its_way_aside_a_sensor_that_touches_the_ground_is_lifted(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, free_above: float
) -> None:
    """It isn't dragged, which turns it in the fingers; where it can't be got free it isn't let go."""
    robot = rig.robot
    field = rig.model.of(FieldWork).field
    assert field is not None
    arm = SensorArm(robot, field)
    here, there = (arm.place_beside(np.array([x, -0.76])) for x in (0.05, -0.07))

    def follow(steps: Iterator[object]) -> None:
        for _ in steps:
            robot.step()

    for steps in (arm.take(), arm.reach(here), arm.slide(0.4)):
        follow(steps)

    def force() -> Any:
        rises = float(np.hypot(*(arm.scara.tip(robot.arm.command()) - here))) > 0.05
        touches = rises and robot.arm.command()[2] > free_above
        return np.array([-10.0 if touches else 0.0, 0.0, 0.0])

    monkeypatch.setattr(robot.backend.get(Arm), "hand_force", force)  # type: ignore[type-abstract]
    aside = Deploy(target="here")._lead_clear(robot, arm, there, 0.0)
    if free_above:
        follow(aside)
        assert robot.arm.command()[2] == pytest.approx(0.34, abs=1e-3)
        assert arm.scara.tip(robot.arm.command()) == pytest.approx(there, abs=1e-3)
    else:
        with pytest.raises(Discrepancy, match="an obstacle is at the sensor's target"):
            follow(aside)


@pytest.mark.slow
@pytest.mark.parametrize("last", [False, True])
def test_together_only_the_last_sensor_brings_the_arm_home(rig: Rig, last: bool) -> None:
    """Otherwise the fingers are lifted off the sensor, and the next drive does the rest."""
    work, robot = rig.model.of(FieldWork), rig.robot
    if last:
        work.laid = (Laid("far", 14.0, -0.75, (1.0, 0.0, 1.0), (14.0, -0.75), 0.0),)
    deploy = Deploy(target="here", together=True)
    assert isinstance(rig.do(deploy), Success)
    joints, home = robot.arm.command(), np.array(robot.spec.posture("home"))
    if last:
        assert np.allclose(joints, home)
    else:
        assert abs(joints[0] - home[0]) > 0.5
        assert joints[2] == pytest.approx(float(deploy.facts["lowered_mm"]) / 1e3 - 0.20, abs=1e-3)


@pytest.mark.parametrize("away", [(0.6, -0.8), (-0.7, 0.4), (0.0, 1.0)])
def test_point_covariance_follows_from_the_pose_of_the_base(away: tuple[float, float]) -> None:
    """With a heading error to the left, a point ahead errs to the left, and a point on the left backwards."""
    covariance = np.array([[4e-4, 1e-4, 2e-4], [1e-4, 9e-4, -3e-4], [2e-4, -3e-4, 4e-4]])
    spec = SimpleNamespace(arm=SimpleNamespace(accuracy_mm=20.0))
    robot: Any = SimpleNamespace(localization=SimpleNamespace(covariance=covariance), spec=spec)
    draws = np.random.default_rng(0).multivariate_normal(np.zeros(3), covariance, 40_000)
    places = np.array([Pose2(*draw).apply(np.array([away]))[0] for draw in draws.tolist()])
    expected = np.cov(places.T) + 0.02**2 * np.eye(2)
    assert _spread(robot, np.array(away)) == pytest.approx(expected, abs=0.03 * float(np.trace(expected)))


def test_nothing_is_laid_while_the_fixes_contradict_what_is_claimed(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    doubt = Lost("the fixes of the last minute contradict what is claimed", "Gps", "mean square", 3.0, 1.5)
    monkeypatch.setattr(type(rig.robot.localization), "doubt", property(lambda self: doubt))
    failed = rig.do(Deploy(target="here", longest_s=2.0))
    assert isinstance(failed, Fail), failed
    assert failed.reason == f"the target's place is not determined: {doubt.why}"
    assert rig.model.of(FieldWork).laid == ()


def test_a_fail_leaves_the_target_within_reach(rig: Rig) -> None:
    """The arm reaches it from any place and heading within the tolerances."""
    robot, work = rig.robot, rig.model.of(FieldWork)
    model: Any = rig.model
    room = Deploy(target="here").base_room(robot, model)
    assert 0.15 < room < 1e-3 * robot.spec.tolerance.base_mm
    arm, target, turn = scara_of(robot), work.targets["here"], math.radians(robot.spec.tolerance.base_deg)
    rng = np.random.default_rng(0)

    def reached(off: float) -> list[bool]:
        found = []
        for angle, turned in rng.uniform((-math.pi, -turn), (math.pi, turn), (500, 2)).tolist():
            stand = target.stand.compose(Pose2(off * math.cos(angle), off * math.sin(angle), turned))
            place = (
                Pose2(*arm.mount[:2], arm.mount[3])
                .inverse()
                .apply(stand.inverse().apply(np.array([[target.x, target.y]])))
            )
            found.append(arm.inverse(place[0]) is not None)
        return found

    assert all(reached(room))
    assert not all(reached(room + 0.05))
    assert Deploy(target="nowhere").base_room(robot, model) == math.inf


@pytest.mark.parametrize("name", ["deploy_straight", "deploy_zigzag", "deploy_field"])
def test_a_shipped_field_allows_a_turn_that_the_arm_allows(rig: Rig, name: str) -> None:
    """Turned by as much as the file allows, the base may still be 250 mm off along, or 100 mm across."""
    field = load(TASK.parents[1] / name / "field.yaml", Field)
    turn = field.stand_tolerance_deg
    assert turn is not None
    arm = scara_of(rig.robot)
    to_arm = Pose2(*arm.mount[:2], arm.mount[3]).inverse()
    off = [(0.25, 0.0), (-0.25, 0.0), (0.0, 0.1), (0.0, -0.1)]
    for (x, y), sign in product(off, (-1.0, 0.0, 1.0)):
        stand = Pose2(x, y, sign * math.radians(turn))
        place = to_arm.apply(stand.inverse().apply(np.array([[0.0, -field.aside_m]])))
        assert arm.inverse(place[0]) is not None
    assert field.stand_tolerance_mm == pytest.approx(2.0 * 3.0 * Deploy(target="here").sure_mm)
