"""The same robot through the middleware: a bench in another process. Runs where rclpy is installed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.ros_spec import RosLidarSpec, RosOdometrySpec, RosSpec, RosVelocitySpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.air_check.air_description import describe_air
from handcart.backends.ros2.air_check.air_report import listen
from handcart.backends.ros2.bench.bench_faults import BenchFaults, TopicFault
from handcart.backends.ros2.bench.served_joints import ServedJoints
from handcart.backends.ros2.goal_stream import GoalStream
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.wire.goals import GoalSender, GoalStage, SentGoal, ServedGoal
from handcart.backends.ros2.wire.messages import TRAJECTORY_ACTION, trajectory_goal
from handcart.backends.ros2.wire.ros_errors import NotOnTheAir
from handcart.backends.ros2.wire.ros_link import RosLink
from handcart.backends.ros2.wire.transports import shares_memory

pytest.importorskip(
    "rclpy", reason="rclpy is not installed; needed: the extra ros2, apart", exc_type=ImportError
)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # of a parser that rclpy imports
]
DOMAIN = str(100 + os.getpid() % 100)


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep this test's topics on this machine, and apart from those of others."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_DOMAIN_ID", DOMAIN)
    monkeypatch.setenv("ROS_PYTHON_CHECK_FIELDS", "1")


@pytest.fixture(autouse=True)
def middleware(alone: None) -> None:
    """Skip where this machine passes no messages between two nodes."""
    heard: list[object] = []
    speaker, listener = RosLink("speaker"), RosLink("listener")
    listener.subscribe("geometry_msgs/Twist", "heard", heard.append)
    speak, until = speaker.publisher("geometry_msgs/Twist", "heard"), time.monotonic() + 20.0
    while not heard and time.monotonic() < until:
        speak(speaker.message("geometry_msgs/Twist"))
        time.sleep(0.05)
        listener.receive()
    speaker.close()
    listener.close()
    if not heard:
        pytest.skip("the middleware passes no messages between two nodes of this machine")


@pytest.fixture
def bench() -> Iterator[subprocess.Popen[str]]:
    """Run the cart's drivers in another process."""
    words = [sys.executable, "-m", "handcart", "bench", "cart", "--ros2", "--seconds", "90"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        assert process.stdout is not None
        assert "topics of /" in process.stdout.readline()
        yield process
        process.kill()


def patient_backend() -> RosBackend:
    """Return the cart by topics, on a machine that may be busy."""
    robot = load_robot("cart")
    spec = RosSpec(first_message_s=30.0, max_late_ms=1000.0, same_clock=True)
    return RosBackend(robot.model_copy(update={"ros2": spec}).read_in(robot.folder))


def test_it_drives_and_reads_through_the_middleware(bench: subprocess.Popen[str]) -> None:
    with patient_backend() as backend:
        base, lidar = backend.get(Base), backend.get(RangeSensor)  # type: ignore[type-abstract]
        assert base is not None and lidar is not None
        for _ in range(40):
            base.drive(0.2, 0.0)
            backend.step()
        assert len(lidar.scan().ranges) == 360
        travel = base.wheel_travel()
        assert 0.15 < travel.left < 0.5
        assert backend.figures()["loop"]["periods"] == 40


def test_a_bench_that_is_killed_stops_the_run(bench: subprocess.Popen[str]) -> None:
    with patient_backend() as backend:
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None
        backend.step()
        bench.send_signal(signal.SIGKILL)
        killed = time.monotonic()
        with pytest.raises(RobotFault, match=r"odom"):
            while time.monotonic() - killed < 10.0:
                base.drive(0.1, 0.0)
                backend.step()
        assert time.monotonic() - killed < 3.0


def test_nobody_on_the_air_is_told_with_all_topics() -> None:
    robot = load_robot("cart")
    spec = RosSpec(first_message_s=1.0)
    with pytest.raises(NotOnTheAir) as refused:
        RosBackend(robot.model_copy(update={"ros2": spec}).read_in(robot.folder))
    assert str(refused.value).startswith(
        f"no driver of the robot is on the air in ROS domain {DOMAIN}; needed:"
    )
    for words in ("(odom): nobody publishes it", "(scan): nobody publishes it", "cmd_vel: nobody listens"):
        assert words in str(refused.value)


def test_a_second_master_is_named_before_anything_moves(bench: subprocess.Popen[str]) -> None:
    other = RosLink("teleop")
    other.publisher("geometry_msgs/Twist", "cmd_vel")
    try:
        with pytest.raises(NotOnTheAir, match=r"cmd_vel: .*teleop.* publishes it"):
            patient_backend()
    finally:
        other.close()


def test_a_check_compares_the_file_with_the_air(bench: subprocess.Popen[str]) -> None:
    other = RosLink("teleop")
    other.publisher("geometry_msgs/Twist", "cmd_vel")
    robot, link = load_robot("cart"), RosLink("check")
    spec = RosSpec(
        first_message_s=30.0,
        odometry=RosOdometrySpec(stale_ms=3000.0),
        lidar=RosLidarSpec(stale_ms=3000.0),
    )
    try:
        report = listen(robot, spec, link, lambda: time.sleep(0.005), 3.0)
        stamped = spec.model_copy(update={"velocity": RosVelocitySpec(type="TwistStamped")})
        wrong = listen(robot, stamped, link, lambda: time.sleep(0.005), 0.5)
    finally:
        other.close()
        link.close()
    assert [fault.words for fault in report.faults] == [
        "cmd_vel: /teleop (geometry_msgs/Twist) publishes it; allowed: nobody but this program"
    ]
    assert 1.0 < {topic.topic: topic.rate_hz for topic in report.topics}["odom"] < 25.0
    assert any("geometry_msgs/TwistStamped is sent" in fault.words for fault in wrong.faults)


def test_a_robot_on_the_air_describes_itself(bench: subprocess.Popen[str]) -> None:
    controller, link = RosLink("arm_controller"), RosLink("draft")
    controller._node.declare_parameter("joints", ["joint_1", "joint_2"])
    spinning = threading.Event()

    def answer() -> None:
        while not spinning.wait(0.01):
            controller.receive()

    answering = threading.Thread(target=answer)
    answering.start()
    try:
        heard: list[object] = []
        link.subscribe("sensor_msgs/LaserScan", "scan", heard.append)
        until = time.monotonic() + 30.0
        while not heard and time.monotonic() < until:  # the machine may be busy
            time.sleep(0.05)
            link.receive()
        described = describe_air(link, lambda: time.sleep(0.005), 6.0)
        joints = link.joints_of("/arm_controller")
    finally:
        spinning.set()
        answering.join()
        controller.close()
        link.close()
    assert "<robot" in described.urdf
    assert described.topics["geometry_msgs/Twist"] == ("/cmd_vel",)
    assert described.topics["nav_msgs/Odometry"] == ("/odom",)
    assert described.messages["/scan"].angle_increment > 0.0
    assert joints == ["joint_1", "joint_2"]


def test_the_base_is_stopped_while_something_is_compiled(bench: subprocess.Popen[str]) -> None:
    with patient_backend() as backend:
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None
        for _ in range(20):
            base.drive(0.2, 0.0)
            backend.step()
        backend._hear_compiling(True)
        time.sleep(2.0)
        backend._hear_compiling(False)
        before = base.wheel_travel()
        base.drive(0.2, 0.0)
        backend.step()  # not late, and the command from before is dropped
        assert base.wheel_travel().left - before.left < 0.2 * 0.6
        backend.step()
        assert backend.figures()["compiled_in_loop"] == 1


def test_goals_pass_the_middleware_and_come_back() -> None:
    pytest.importorskip("control_msgs", reason="control_msgs is not installed: no wheel of it is published")
    name, joints, faults = "arm/follow_joint_trajectory", ("joint_1", "joint_2"), BenchFaults(0.05)
    drivers, program = RosLink("drivers"), RosLink("program")
    served = ServedJoints(drivers, TRAJECTORY_ACTION, name, joints, faults)
    stream = GoalStream(
        program.goal_sender(TRAJECTORY_ACTION, name), name, TRAJECTORY_ACTION, 5.0, time.monotonic
    )
    now, at = 0.0, dict.fromkeys(joints, 0.0)

    def pass_period() -> None:
        nonlocal now
        drivers.receive()
        at.update(served.wanted(now, 0.05, at))
        now += 0.05
        served.settle(now, at, False)
        time.sleep(0.02)
        program.receive()
        stream.advance()

    try:
        until = time.monotonic() + 20.0
        while not stream.sender.is_ready() and time.monotonic() < until:
            pass_period()
        assert drivers.action_servers(name) == [f"/drivers ({TRAJECTORY_ACTION})"]
        assert program.actions_of(TRAJECTORY_ACTION) == [f"/{name}"]
        for step in range(1, 6):
            stream.send(trajectory_goal(program, stream.sender, joints, [0.1 * step, -0.1 * step], 0.05))
            pass_period()
        for _ in range(100):
            if not stream._watched:
                break
            pass_period()
        assert at == pytest.approx({"joint_1": 0.5, "joint_2": -0.5}, abs=1e-6)
        assert not stream._watched and not stream.trouble
        faults.add(TopicFault("rejects", name, 0.0))
        stream.send(trajectory_goal(program, stream.sender, joints, [0.0, 0.0], 0.05))
        for _ in range(100):
            if stream.trouble:
                break
            pass_period()
        assert f"{name}: the controller rejected a goal" in stream.trouble
    finally:
        drivers.close()
        program.close()


class CountingRig:
    """Server, client and a rival's client of `Fibonacci`: its messages are published as a wheel."""

    KIND, ANSWER_S = "test_msgs/Fibonacci", 1.0

    def __init__(self, name: str = "count") -> None:
        """Connect all three to an action of this name."""
        self.name = name
        self.links = [RosLink(name) for name in ("drivers", "program", "rival")]
        self.served: list[ServedGoal] = []
        self.verdict: bool | None = True
        self.links[0].serve_action(self.KIND, self.name, lambda goal: self.verdict, self.served.append)
        sender, self.rival = (link.goal_sender(self.KIND, self.name) for link in self.links[1:])
        self.stream = GoalStream(sender, self.name, self.KIND, self.ANSWER_S, time.monotonic)

    def await_that(self, condition: Callable[[], bool]) -> None:
        """Exchange messages until a condition holds."""
        until = time.monotonic() + 20.0
        while not condition():
            assert time.monotonic() < until
            time.sleep(0.01)
            for link in self.links:
                link.receive()
            self.stream.advance()

    def sent(self, verdict: bool | None, sender: GoalSender | None = None) -> SentGoal:
        """Send a goal by the stream, or by a sender alone, that gets a verdict."""
        self.verdict = verdict
        goal = self.stream.sender.new_goal()
        goal.order = 7
        if sender is not None:
            return sender.send(goal)
        self.stream.forget()
        self.stream.send(goal)
        return self.stream._watched[0].goal

    def ended(self, stage: GoalStage, asked: bool = False) -> str:
        """Let a goal of the stream end, when it is asked to or without; return the trouble."""
        sent = self.sent(True)
        self.await_that(lambda: bool(self.served) and sent.state is GoalStage.RUNNING)
        goal = self.served.pop()
        assert goal.request.order == 7
        if asked:
            self.stream.cancel()
            self.await_that(lambda: goal.is_cancel_asked)
        result = goal.new_result()
        result.sequence = [1, 1, 2]
        goal.end(stage, result)
        self.await_that(lambda: sent.state is stage)
        assert list(sent.result.sequence) == [1, 1, 2]
        return self.stream.trouble


def test_any_action_passes_the_middleware_with_each_of_its_ends() -> None:
    pytest.importorskip("test_msgs", reason="ros-test-msgs is not installed")
    rig = CountingRig()
    try:
        rig.await_that(lambda: rig.stream.sender.is_ready() and rig.rival.is_ready())
        assert rig.links[1].actions_of(rig.KIND) == [f"/{rig.name}"]  # before the node's name is known
        assert rig.links[1].actions_of("test_msgs/NestedMessage") == []
        assert rig.ended(GoalStage.SUCCEEDED) == ""
        assert rig.ended(GoalStage.CANCELED, asked=True) == ""
        assert rig.ended(GoalStage.ABORTED) == "count: the controller aborted a goal"
        for verdict, words in ((False, "the controller rejected a goal"), (None, "no answer to a goal")):
            rig.sent(verdict)
            rig.await_that(lambda: bool(rig.stream.trouble))
            assert words in rig.stream.trouble
        rig.stream.forget()
        rig.sent(True, rig.rival)
        rig.await_that(lambda: bool(rig.stream.trouble))
        assert "a goal of another node is executed" in rig.stream.trouble
    finally:
        for link in rig.links:
            link.close()


def test_a_server_that_was_started_again_is_noticed() -> None:
    """Its goals never end for their sender (rclcpp #2241)."""
    pytest.importorskip("test_msgs", reason="ros-test-msgs is not installed")
    rig = CountingRig("count_again")
    try:
        rig.await_that(rig.stream.sender.is_ready)
        rig.await_that(lambda: bool(rig.stream.sender.servers()))
        rig.stream.begin()
        sent = rig.sent(True)
        rig.await_that(lambda: sent.state is GoalStage.RUNNING)
        assert not rig.stream.restart
        rig.links[0].close()
        rig.links[0] = RosLink("drivers")
        rig.links[0].serve_action(rig.KIND, rig.name, lambda goal: True, rig.served.append)
        rig.await_that(lambda: bool(rig.stream.restart))
        assert "was its controller started again" in rig.stream.restart
        assert sent.state is GoalStage.RUNNING
    finally:
        for link in rig.links:
            link.close()


def test_a_slow_publisher_of_joints_is_heard_beside_a_fast_one() -> None:
    kind, heard = "sensor_msgs/JointState", list[str]()
    program, arm, hand = RosLink("program"), RosLink("arm"), RosLink("hand")
    try:
        program.subscribe(kind, "joints", lambda message: heard.append(message.name[0]))
        fast, slow = arm.publisher(kind, "joints"), hand.publisher(kind, "joints")
        until = time.monotonic() + 20.0
        while arm.subscribers("joints") + hand.subscribers("joints") < 2 and time.monotonic() < until:
            time.sleep(0.05)
        time.sleep(1.0)
        for publish, name, count in ((slow, "finger", 1), (fast, "shoulder", 25)):
            message = program.message(kind)
            message.name, message.position = [name], [0.0]
            for _ in range(count):
                publish(message)
            time.sleep(0.5)
        program.receive()
    finally:
        for link in (program, arm, hand):
            link.close()
    assert heard[0] == "finger"
    assert heard.count("shoulder") == 25


def test_no_memory_is_shared_that_a_killed_node_could_lock() -> None:
    link = RosLink("apart")
    try:
        assert not shares_memory()
    finally:
        link.close()
