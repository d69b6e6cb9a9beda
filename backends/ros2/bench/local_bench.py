"""A bench and its topics in this process: messages are handed over without rclpy."""

from __future__ import annotations

from typing import Any

from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.plain_values import from_plain
from handcart.backends.ros2.wire.other_end import OtherEnd
from handcart.backends.saved_state import NotAState

from .bench_faults import BenchFaults
from .local_air import LocalAir, LocalLink
from .robot_differences import RobotDifferences
from .ros_bench import RosBench


class LocalBench(OtherEnd):
    """Simulated robot with drivers on topics within this process.

    Its time advances only with the steps of the program, not with a clock.
    """

    def __init__(
        self,
        robot: RobotFile,
        spec: RosSpec,
        inner: Backend,
        faults: BenchFaults | None = None,
        differences: RobotDifferences | None = None,
    ) -> None:
        """Connect a simulated robot, owned by the bench from now on, to topics in this process.

        Args:
            robot: the robot's file.
            spec: its section `ros2`.
            inner: the simulated robot.
            faults: planned faults of the topics; None: none.
            differences: how the simulated robot differs from the file; None: it doesn't.
        """
        self.air = LocalAir()
        self._has_receiver = robot.gps is not None
        self._inner = inner
        self._link = LocalLink(self.air, "handcart")
        self._drivers = RosBench(robot, spec, inner, LocalLink(self.air, "bench"), faults, differences)

    @property
    @override
    def inner(self) -> Backend:
        return self._inner

    @property
    @override
    def link(self) -> LocalLink:
        return self._link

    @override
    def wait(self, seconds: float) -> None:
        """Advance the topics' time by `seconds` [s], and publish the sensors' readings of the resting robot.

        A robot with a satellite receiver is simulated for one control period instead, whatever `seconds` is:
        only a simulated period can bring a new satellite fix, and not every period does.
        """
        if self._has_receiver:
            self.step()
            return
        self.air.time += seconds
        self._drivers.announce()

    @property
    def speeds(self) -> DriveCommand:
        """Speeds at which the simulated base is driving now."""
        return self._drivers.speeds

    @override
    def step(self) -> None:
        """Simulate one control period: execute the received commands and publish the readings."""
        self.air.time += self.inner.period
        self._drivers.step()

    @override
    def state(self) -> dict[str, object] | None:
        """Return the state of robot, drivers and time; None if the simulated robot cannot save its state."""
        inner = self.inner.state()
        if inner is None:
            return None
        return {"inner": inner, "time": self.air.time, **self._drivers.state()}

    @override
    def set_state(self, state: Any) -> None:
        """Restore a state that `state` returned, and publish the sensors' readings in this state.

        Raises:
            NotAState: the data are not a state of a `LocalBench`.
        """
        needed = {"inner", "time", *self._drivers.state()}
        if not isinstance(state, dict) or state.keys() != needed:
            raise NotAState(f"no state of a bench of topics; needed: {', '.join(sorted(needed))}")
        self.air.time = from_plain(state["time"], float, "time")
        self.inner.set_state(state["inner"])
        self._drivers.set_state(state)
        self._drivers.announce()

    @override
    def close(self) -> None:
        """Close the simulated robot."""
        self._drivers.close()
