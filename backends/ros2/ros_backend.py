"""A robot that speaks ROS 2."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.live.pace import Pace
from handcart.backends.ros2.wire.other_end import OtherEnd
from handcart.backends.ros2.wire.ros_errors import NoTopics, RosFault
from handcart.backends.ros2.wire.ros_link import Link, RosLink, node_name
from handcart.backends.ros2.wire.sole_use import sole_use
from handcart.backends.saved_state import NotAState
from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.numerics.compiled import hearing_of_compiling

from .bench.local_bench import LocalBench
from .on_the_air import (
    DISCOVERY_S,
    await_robot,
    doubled_readings,
    ended_drivers,
    other_masters,
    refuse_masters,
    restarted_servers,
    unheard,
)
from .ros_topics import RosTopics, capabilities_of, check_ros_section, command_topics

MASTERS_PERIOD_S = 1.0
"""Time between two searches for other nodes that command the robot, in [s]."""
DOUBLED_S = 25.0
"""Time in [s] after which a second node that publishes readings stops the robot: a killed node counts as
there for up to 20 s, also if its driver was started again."""


class RosBackend(Backend):
    """Backend whose commands and readings are topics, as in the section `ros2` of the robot's file.

    The constructor waits for the first message of each topic; nothing is sent before all topics exist and
    match the file. A step sends the commands, waits for the end of the period, and reads what has arrived. A
    fault (a late loop, odometry that jumps, a second node that commands the base, controllers that are gone)
    stops the base and ends the step with a `RosFault`; every further step raises the same error. If a topic
    falls silent, an access to its reading raises `StaleSensor`; if the silent topic is that of the odometry
    or the joints, the robot is stopped at once.

    On a bench (`build_on_bench`) the drivers are simulated in this process, they move the robot of a
    simulated backend, and messages are passed on without rclpy: each step advances the simulation by one
    period, no clock is read, and the same seed gives the same run. Sensors without a topic are those of the
    simulated backend.

    If this program dies, only the robot's own time-out for speed commands can stop it.
    """

    name = "ros2"
    drive_kinds = frozenset({"differential", "ackermann", "holonomic"})
    has_drives = True

    def __init__(
        self, robot: RobotFile, bench: LocalBench | None = None, drivers: OtherEnd | None = None
    ) -> None:
        """Connect to the robot.

        Args:
            robot: the robot's file.
            bench: simulated drivers in this process, owned by the backend from now on.
            drivers: other drivers in this process, such as recorded ones, owned likewise; with neither,
                those on the air, by a node of rclpy.

        Raises:
            NoTopics: the robot's file has no section `ros2`.
            WrongRosSection: the section has faults (`ros_faults`), such as joints that the arm lacks.
            NoRos: rclpy is not installed.
            NotOnTheAir: topics are missing, or are not what the file says.
        """
        if robot.ros2 is None:
            raise NoTopics(robot.folder)
        spec = robot.ros2
        check_ros_section(robot, spec)
        self.period = robot.period_s
        self.address = f"ros2 {spec.namespace or '/'}{'' if spec.domain is None else f' {spec.domain}'}"
        self._closed, self._begun = False, False
        self._fault: RosFault | None = None
        self.bench = bench
        """The simulated drivers of a bench; None with other drivers."""
        self._drivers: OtherEnd | None = bench or drivers
        self.simulated = self._drivers is not None
        self._link: Link
        if self._drivers is not None:
            self._link = self._drivers.link
        else:
            self._link = RosLink(node_name("robot"), spec.namespace, spec.domain)
        self._pace = (
            None
            if self._drivers
            else Pace(self.period, max_excess=spec.max_late_ms / 1e3, max_missed=spec.max_missed_periods)
        )
        self._looked = self._single = self._link.clock()
        self._thread, self._is_late, self._compiled = threading.get_ident(), False, 0
        self._ears = ExitStack()
        try:
            if self._drivers is None:
                self._ears.enter_context(sole_use(f"{self._link.place}, {spec.namespace or '/'}"))
                refuse_masters(command_topics(robot, spec), self._link, DISCOVERY_S, time.sleep)
            self._topics = RosTopics(robot, spec, self._link)
            waiting = (self._drivers.wait, 0.0) if self._drivers else (time.sleep, DISCOVERY_S)
            await_robot(self._topics, self._link, spec.first_message_s, *waiting)
            self._topics.begin()
            if self._drivers is None:
                self._ears.enter_context(hearing_of_compiling(self._hear_compiling))
        except BaseException:
            self._begun = False
            self.close()
            raise

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> RosBackend:
        """Build the backend for a real robot; `world` and `seed` are not used."""
        return cls(robot)

    @classmethod
    @override
    def build_on_bench(
        cls, robot: RobotFile, world: Path | None, seed: int, bench: type[Backend]
    ) -> RosBackend:
        if robot.ros2 is None:
            raise NoTopics(robot.folder)
        check_ros_section(robot, robot.ros2)
        inner = bench.build(robot, world, seed)
        try:
            backend = cls(robot, LocalBench(robot, robot.ros2, inner))
        except BaseException:
            inner.close()
            raise
        backend.remarks = inner.remarks
        return backend

    @classmethod
    @override
    def kinds(cls, robot: RobotFile) -> tuple[type[Capability], ...] | None:
        if robot.ros2 is None:
            raise NoTopics(robot.folder)
        check_ros_section(robot, robot.ros2)
        return capabilities_of(robot)

    @override
    def capabilities(self) -> tuple[Capability, ...]:
        own = self._topics.capabilities()
        others = () if self.inner is None else self.inner.capabilities()
        return (*own, *(other for other in others if not _stands_for(other, own)))

    @property
    @override
    def inner(self) -> Backend | None:
        return None if self._drivers is None else self._drivers.inner

    @override
    def view(self) -> ByteArray | None:
        return None if self.inner is None else self.inner.view()

    def step(self) -> None:
        """Send the commands, wait for the end of the period, and read what has arrived.

        Raises:
            RosFault: a fault of the connection or the robot was found, in this step or an earlier one.
            StaleSensor: no new messages of the odometry or the joints arrive.
        """
        self._pass_period(send=True)

    def _pass_period(self, send: bool) -> None:
        """Let a period pass; `send` is True to send its commands."""
        if self._fault is not None:
            raise self._fault
        if not self._begun:
            self._begun = True
            if self._pace is not None:
                self._pace.begin()
        if self._is_late and self._pace is not None:
            self._is_late = False
            self._topics.base.taken()  # it was computed from readings of before
            self._pace.begin()
        try:
            if send:
                self._topics.send()
            if self._pace is not None:
                self._pace.wait()
            elif self._drivers is not None:
                self._drivers.step()
            self._link.receive()
            self._topics.advance()
            self._check()
        except BaseException as error:
            self._stop_for_good(error)
            raise

    def watch(self) -> None:
        """Wait for one period and read what has arrived, without sending anything.

        `handcart bringup` uses it to test whether the base stops by itself.

        Raises:
            RosFault: a fault of the connection or the robot was found, in this period or an earlier one.
            StaleSensor: the odometry or the joints are silent.
        """
        self._pass_period(send=False)

    def stop(self) -> None:
        """Stop all motion; arm and gripper hold."""
        self._topics.halt()
        if self._begun and not self._closed:
            self._topics.send()

    def close(self) -> None:
        """Command zero speed to the base, and release all resources; a second call does nothing."""
        if self._closed:
            return
        if self._begun:
            with suppress(Exception):  # the robot's own time-out has to stop it then
                self.stop()
        self._closed = True
        self._ears.close()
        self._link.close()
        if self._drivers is not None:
            self._drivers.close()

    @override
    def state(self) -> object | None:
        kept = None if self._drivers is None else self._drivers.state()
        return None if kept is None else {**kept, "topics": self._topics.state()}

    @override
    def set_state(self, state: object) -> None:
        if self._drivers is None:
            super().set_state(state)
            return
        if not isinstance(state, dict) or "topics" not in state:
            raise NotAState("no state of a bench of topics; needed: topics")
        own, others = state["topics"], {key: value for key, value in state.items() if key != "topics"}
        self._topics.forget()
        self._drivers.set_state(others)
        self._topics.set_state(own, self._link.receive)
        self._looked = self._single = self._link.clock()

    @override
    def figures(self) -> Mapping[str, Any]:
        rejected = {
            sensor.source.topic: sensor.rejected for sensor in self._topics.sensors if sensor.rejected
        }
        loop = {} if self._pace is None else {"loop": self._pace.figures()}
        compiled = {"compiled_in_loop": self._compiled} if self._compiled else {}
        return {**loop, **compiled, **({"rejected_messages": rejected} if rejected else {})}

    def _hear_compiling(self, begins: bool) -> None:
        """Stop the base before a function is compiled in the control loop, which may take seconds.

        Nothing is read meanwhile; afterwards the loop continues, and isn't late.
        """
        if not self._begun or self._closed or threading.get_ident() != self._thread:
            return
        if begins:
            self._topics.stop_base()
        else:
            self._is_late = True
            self._compiled += 1

    def _check(self) -> None:
        """Raise the fault that stops the robot, if one is present."""
        if self._pace is not None and self._pace.trouble:
            raise RosFault(f"the control loop is too slow: {self._pace.trouble}")
        topics = self._topics
        if topics.odometry.jumped:
            raise RosFault(topics.odometry.jumped)
        if topics.states is not None and topics.states.jumped:
            raise RosFault(topics.states.jumped)
        if trouble := next((stream.trouble for stream in topics.streams if stream.trouble), ""):
            raise RosFault(trouble)
        topics.odometry.check_fresh()
        if topics.states is not None:
            topics.states.check_fresh()
        now = self._link.clock()
        if now - self._looked < MASTERS_PERIOD_S:
            return
        self._looked = now
        if found := [*other_masters(topics, self._link), *restarted_servers(topics)]:
            raise RosFault("; ".join(found))
        if ended := list(ended_drivers(topics, self._link)):
            raise RosFault("; ".join(ended))
        doubled = list(doubled_readings(topics, self._link))
        self._single = self._single if doubled else now
        if now - self._single > DOUBLED_S:
            raise RosFault("; ".join(doubled))
        if deaf := unheard(topics, self._link):
            raise RosFault(f"nobody listens to {', '.join(deaf)} any more")

    def _stop_for_good(self, error: BaseException) -> None:
        """Command zero speed to the base, and refuse every further step with `error`."""
        words = str(error) if isinstance(error, RosFault) else f"{type(error).__name__}: {error}"
        self._fault = error if isinstance(error, RosFault) else RosFault(words)
        with suppress(Exception):
            self._topics.halt()
            self._topics.send()


def _stands_for(part: Capability, own: tuple[Capability, ...]) -> bool:
    """Return whether one of `own` is the same part: the sensor of that name, or the only one of its kind."""
    kinds = {kind for capability in own for kind in type(capability).__mro__ if Capability in kind.__bases__}
    if not isinstance(part, tuple(kinds)):
        return False
    return not part.sensor_name or any(capability.sensor_name == part.sensor_name for capability in own)
