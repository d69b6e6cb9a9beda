"""The satellite receiver of a simulated robot, as a driver's topic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from handcart.backends.backend import Backend
from handcart.backends.capabilities.gps import Gps
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.ros2.wire.ros_link import Link

from .bench_messages import fix_message, no_fix_message


class BenchReceiver:
    """Driver of a simulated satellite receiver, which also reports that it has no fix."""

    def __init__(self, robot: RobotFile, spec: RosSpec, inner: Backend, link: Link) -> None:
        """Begin without an answer; the arguments are those of `RosBench`."""
        self._spec, self._link, self._period = spec.gps, link, inner.period
        self._gps = inner.get(Gps)  # type: ignore[type-abstract]
        self._every = 0.0 if robot.gps is None else robot.gps.period_s
        self._answered = 0.0

    def begin(self, time: float) -> None:
        """Count the time to the next answer from `time`, in [s] of the simulation."""
        self._answered = time

    def messages(self, now: float, time: float) -> Mapping[str, Any]:
        """Return the receiver's message of this period by its topic; none while no answer is due.

        Args:
            now: time of ROS, in [s].
            time: simulated time, in [s].
        """
        spec, receiver = self._spec, self._gps
        if spec is None or receiver is None:
            return {}
        fix = receiver.fix()
        if fix is not None:
            self._answered = time
            return {spec.topic: fix_message(self._link, now, spec, fix)}
        if spec.silent_without_fix or time - self._answered < self._every - 0.5 * self._period:
            return {}
        self._answered = time
        return {spec.topic: no_fix_message(self._link, now)}
