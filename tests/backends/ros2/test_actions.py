"""Arms and grippers by actions: goals of one period, and what becomes of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.ros_spec import RosArmSpec, RosGripperSpec, RosSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.air_check.air_report import listen
from handcart.backends.ros2.bench.local_air import LocalLink
from handcart.backends.ros2.bench.local_goals import LocalGoalSender
from handcart.backends.ros2.goal_stream import GoalStream
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.wire.goals import GoalStage
from handcart.backends.ros2.wire.ros_errors import NotOnTheAir, RosFault, WrongRosSection

from .conftest import Make

ARM, HAND = "arm_controller/follow_joint_trajectory", "gripper_controller/gripper_cmd"
LIFT = "lift_controller/follow_joint_trajectory"
BY_ACTIONS: dict[str, Any] = {
    "arm": {
        "actions": {LIFT: ("joint_1", "joint_2"), ARM: ("joint_6", "joint_5", "joint_4", "joint_3")},
    },
    "gripper": {"action": HAND, "max_effort_n": 20.0},
}
WAY = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


def arm_of(backend: RosBackend) -> Arm:
    """Return the arm by topics."""
    arm = backend.get(Arm)  # type: ignore[type-abstract]
    assert arm is not None
    return arm


def swing(backend: RosBackend, periods: int = 20) -> np.ndarray:
    """Move all joints by 0.01 rad in each period; return the true motion."""
    arm, inner = arm_of(backend), backend.inner.get(Arm)  # type: ignore[type-abstract,union-attr]
    assert inner is not None
    begun = arm.joints()
    for step in range(1, periods + 1):
        arm.move(begun + 0.01 * step * WAY)
        backend.step()
    return np.asarray(inner.command() - begun)


def goals_of(stream: GoalStream) -> list[GoalStage]:
    """Return the states of a stream's goals that are not over."""
    return [watched.goal.state for watched in stream._watched]


def test_goals_move_an_arm_as_topics_do(make: Make) -> None:
    more: dict[str, Any] = {"names": {"joint_2": "shoulder_lift"}, "reversed": ("joint_3",)}
    with make(**more) as by_topics, make(**BY_ACTIONS, **more) as by_actions:
        assert swing(by_actions) == pytest.approx(swing(by_topics), abs=1e-9)
        by_actions.step()
        by_actions.step()
        assert [goals_of(stream) for stream in by_actions._topics.streams] == [[], [], []]


def test_a_goal_ends_with_its_period(make: Make) -> None:
    """Without a next one, as after this program was killed, the arm holds."""
    with make(**BY_ACTIONS) as backend:
        swing(backend, 10)
        bench, inner = backend.bench, backend.inner.get(Arm)  # type: ignore[type-abstract,union-attr]
        assert bench is not None and inner is not None
        reached = inner.command()
        for _ in range(10):
            bench.step()
        assert inner.command() == pytest.approx(reached, abs=1e-9)


def test_a_stop_cancels_what_is_under_way(make: Make) -> None:
    arm = {**BY_ACTIONS["arm"], "latency_ms": 1000.0}
    with make(**{**BY_ACTIONS, "arm": arm}) as backend:
        swing(backend, 3)
        assert GoalStage.RUNNING in goals_of(backend._topics.streams[0])
        backend.stop()
        backend.step()
        backend.step()
        inner = backend.inner.get(Arm)  # type: ignore[type-abstract,union-attr]
        assert inner is not None
        held = inner.command()
        for _ in range(40):
            backend.step()
        assert inner.command() == pytest.approx(held, abs=1e-9)
        assert goals_of(backend._topics.streams[0]) == []


def test_an_action_with_another_server_stops_the_robot(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its controller was started again, and the last goal never ends."""
    servers = {b"first"}
    monkeypatch.setattr(LocalGoalSender, "servers", lambda sender: frozenset(servers))
    with make(**BY_ACTIONS) as backend:
        swing(backend, 10)
        servers.discard(b"first")  # it died: that nobody serves the action is another fault
        for _ in range(30):
            backend.step()
        servers.add(b"second")
        with pytest.raises(RosFault, match=rf"{LIFT}: another server .* was its controller started again\?"):
            for _ in range(30):
                backend.step()


@pytest.mark.parametrize(
    ("fault", "name", "words"),
    [
        ("rejects", ARM, "rejected a goal; is it active"),
        ("aborts", ARM, "aborted a goal: GOAL_TOLERANCE_VIOLATED"),
        ("cancels", ARM, "somebody else cancelled a goal"),
        ("unanswered", ARM, "no answer to a goal"),
        ("rejects", HAND, "rejected a goal; is it active"),
        ("cancels", HAND, "somebody else cancelled a goal"),
    ],
)
def test_a_goal_that_comes_to_nothing_stops_the_robot(make: Make, fault: str, name: str, words: str) -> None:
    with make(faults=(f"{fault}@{name}@0.3",), **BY_ACTIONS) as backend:
        gripper = backend.get(Gripper)  # type: ignore[type-abstract]
        assert gripper is not None
        swing(backend, 4)
        begun = arm_of(backend).command()
        with pytest.raises(RosFault, match=f"{name}: .*{words}"):
            for period in range(40):
                arm_of(backend).move(begun + 0.01 * (period + 1) * WAY)
                gripper.move(0.07 if period % 2 else 0.0)
                backend.step()
        with pytest.raises(RobotFault, match=name):
            backend.step()


def test_a_goal_of_another_node_stops_the_robot(make: Make) -> None:
    with make(**BY_ACTIONS) as backend:
        assert backend.bench is not None
        swing(backend, 2)
        other = LocalLink(backend.bench.air, "moveit").goal_sender("control_msgs/GripperCommand", HAND)
        other.send(other.new_goal())
        with pytest.raises(RosFault, match=f"{HAND}: a goal of another node is executed"):
            swing(backend, 5)


@pytest.mark.slow
def test_fingers_by_an_action_press_and_open(make: Make) -> None:
    for way in ({"action": HAND}, {"action": ARM, "action_type": "FollowJointTrajectory"}):
        with make(gripper=way) as backend:
            gripper = backend.get(Gripper)  # type: ignore[type-abstract]
            assert gripper is not None
            for width, pressing in ((0.05, False), (0.0, True), (0.06, False)):
                gripper.move(width)
                for _ in range(60):
                    backend.step()
                assert gripper.width() == pytest.approx(width, abs=2e-3)
                assert gripper.closed_on_something() is pressing


def test_an_action_that_nobody_serves_is_named_before_anything_moves(
    monkeypatch: pytest.MonkeyPatch, make: Make
) -> None:
    monkeypatch.setattr(LocalLink, "serve_action", lambda *_: None)
    with pytest.raises(NotOnTheAir) as words:
        make(**BY_ACTIONS, first_message_s=0.2)
    for name in (ARM, LIFT, HAND):
        assert f"{name}: nobody serves the action; needed: a controller that takes control_msgs/" in str(
            words.value
        )


def test_an_action_of_another_type_is_told_with_its_type(make: Make) -> None:
    with make(gripper={"action": HAND}) as backend:
        assert backend.bench is not None
        spec = RosSpec(gripper=RosGripperSpec(action=HAND, action_type="FollowJointTrajectory"))
        robot = load_robot("librarian").model_copy(update={"ros2": spec})
        spec = spec.model_copy(update={"first_message_s": 0.2})
        report = listen(robot, spec, backend.bench.link, backend.bench.step, 0.2)
    words = [fault.words for fault in report.faults if HAND in fault.words]
    assert words == [
        f"{HAND}: /bench (control_msgs/GripperCommand) serves it; needed: control_msgs/FollowJointTrajectory"
    ]


def test_a_replaced_goal_with_a_broken_tolerance_is_trouble(make: Make) -> None:
    with make(**BY_ACTIONS) as backend:
        stream = backend._topics.streams[0]
        stream.send(stream.sender.new_goal())
        last = stream._watched[-1].goal
        stream.send(stream.sender.new_goal())
        result = last.new_result()  # type: ignore[attr-defined]
        result.error_code = -4
        last.end(GoalStage.ABORTED, result)  # type: ignore[attr-defined]
        stream.advance()
        assert "PATH_TOLERANCE_VIOLATED" in stream.trouble


def test_a_file_that_names_two_ways_is_refused() -> None:
    with pytest.raises(ValidationError, match="action and topic; allowed: an action, or a topic"):
        RosGripperSpec(action=HAND, topic="gripper/command")
    with pytest.raises(ValidationError, match="max_effort_n without an action"):
        RosGripperSpec(max_effort_n=5.0)
    both = RosArmSpec(actions={ARM: ("joint_1",)}, controllers={"arm/command": ("joint_1",)})
    assert both.joints_by_topic(("joint_1",)) == {"arm/command": ("joint_1",)}
    with pytest.raises(WrongRosSection, match="2 controllers have the joint 'joint_1'"):
        from handcart.backends.ros2.ros_topics import check_ros_section

        check_ros_section(load_robot("librarian"), RosSpec(arm=both))
