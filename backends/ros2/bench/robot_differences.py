"""Differences between the robot behind a bench and the robot's file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.files.errors import InputError
from handcart.files.suggest import suggest

TIMEOUT_NAME, LATENCY_NAME, FINGER_LATENCY_NAME = "timeout", "joints.latency", "gripper.latency"
TIME_NAMES = (TIMEOUT_NAME, LATENCY_NAME, FINGER_LATENCY_NAME)
FIXED_NAMES = {
    "velocity.forward": "factor of the speed that the base drives for a commanded one",
    "velocity.sideways": "the same, sideways",
    "velocity.turn": "the same, of the turn rate",
    "odometry.forward": "factor of the distance that the odometry reports",
    "odometry.turn": "the same, of the angle",
    "gripper": "factor of the fingers' positions in ROS",
    "depth": "factor of a depth camera's distances",
    "scan": "factor of the lidar's ranges",
    "scan.side": "-1 for a lidar that counts the other way round, as one mounted upside down",
    "imu": "factor of the inertial unit's accelerations",
    LATENCY_NAME: "time in [s] after which a joint obeys its command",
    FINGER_LATENCY_NAME: "time in [s] after which the fingers obey their command",
    TIMEOUT_NAME: "time in [s] for which the base keeps its last speeds",
}
"""Differences by name; a joint's name, or `state.` and a joint's name, is the factor of its positions."""
STATE_PREFIX = "state."


class RobotDifferences:
    """Differences of a simulated robot from its file, set on purpose to test that checks of the robot find
    them.

    Most differences are factors by which a quantity is multiplied, such as -1 for a wrong sign, or 57.3 for
    degrees in place of radians; some are times in [s].
    """

    def __init__(self, factors: Mapping[str, float] | None = None) -> None:
        """Take the factors by name; None: the robot is as its file says."""
        self._factors = dict(factors or {})

    @classmethod
    def read(cls, words: Iterable[str], robot: RobotFile, spec: RosSpec) -> RobotDifferences:
        """Parse the differences between a simulated robot and its file from texts such as `joint_3=-1`.

        Args:
            words: texts of the form NAME=FACTOR.
            robot: robot file.
            spec: its section `ros2`.

        Raises:
            InputError: a name or a number is invalid; the error lists all of them.
        """
        joints = () if robot.arm is None else robot.arm.joints
        allowed = [*FIXED_NAMES, *joints, *(STATE_PREFIX + joint for joint in joints)]
        found, wrong = dict[str, float](), list[str]()
        for word in words:
            name, _, value = word.partition("=")
            if name not in allowed:
                wrong.append(f"{name!r} is no difference of this robot{suggest(name, allowed)}")
                continue
            try:
                number = float(value)
            except ValueError:
                number = math.nan
            if not math.isfinite(number) or number == 0.0 or (name in TIME_NAMES and number < 0.0):
                wrong.append(f"{word!r}: allowed: NAME=FACTOR, a finite number other than 0")
            found[name] = number
        if wrong:
            raise InputError("\n".join(wrong))
        return cls(found)

    def factor(self, name: str) -> float:
        """Return the factor by which the simulated robot multiplies a quantity; 1 without a difference.

        Names of quantities are those in `FIXED_NAMES`, the joints' names, and `state.` with a joint's name.
        """
        return self._factors.get(name, 1.0)

    def state_factor(self, joint: str) -> float:
        """Return the factor by which the simulated robot scales the position of a joint that it publishes."""
        return self.factor(joint) * self.factor(STATE_PREFIX + joint)

    def timeout(self, usual: float) -> float:
        """Return the time in [s] for which the base of the simulated robot keeps its last speeds without a
        new command.

        Args:
            usual: time in [s] that is returned unless the bench was started with another time-out.
        """
        return self._factors.get(TIMEOUT_NAME, usual)

    @property
    def joint_latency_s(self) -> float:
        """Delay between a command to a simulated joint and the start of its motion, in [s]."""
        return self._factors.get(LATENCY_NAME, 0.0)

    @property
    def finger_latency_s(self) -> float:
        """Delay between a command to the fingers and the start of their motion, in [s]."""
        return self._factors.get(FINGER_LATENCY_NAME, 0.0)
