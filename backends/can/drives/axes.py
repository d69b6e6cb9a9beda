"""All drives of a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path

from canopen.objectdictionary import ObjectDictionary

from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.bus.pdo_layout import CIA402_MODES
from handcart.backends.description.can_spec import AxisSpec, CanSpec
from handcart.backends.description.robot_file import RobotFile

from .axis import HOLD_COMMAND, Axis
from .axis_check import AxisCheck
from .axis_limits import AxisLimits, gripper_limits, joint_limits, wheel_limits
from .axis_units import AxisUnits
from .drive_dictionary import drive_dictionary
from .drive_setup import look, set_up
from .enabling import enable

_ANSWER_WITHIN = 0.5  # share of a period


class Axes(Mapping[str, Axis]):
    """All driven axes of a robot, by name (`left wheel`, `joint 1`, `gripper`).

    A fault of one drive stops all axes, each with the kind of stop that the robot's file gives it.
    """

    def __init__(self, robot: RobotFile, spec: CanSpec) -> None:
        """Plan the drives by a robot's file and its section `can`, without sending anything.

        Raises:
            TooManyCounts: a possible command to an axis does not fit into 32 bits.
            FileError: an EDS file is missing, or cannot be read.
        """
        self._spec, self._period = spec, robot.period_s
        self._axes = {
            name: _axis(name, item, units, limits, robot)
            for name, item, units, limits in planned_axes(robot, spec)
        }
        self.left, self.right = self._axes["left wheel"], self._axes["right wheel"]
        self.joints = [self._axes[f"joint {number}"] for number in range(1, len(spec.joints) + 1)]
        """Axes in the order of the arm's joints."""
        self.gripper = self._axes.get("gripper")

    def __getitem__(self, name: str) -> Axis:
        return self._axes[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._axes)

    def __len__(self) -> int:
        return len(self._axes)

    @property
    def names(self) -> dict[int, str]:
        """Names of the drives as they appear in messages, such as `left wheel`, by node ID."""
        return {axis.spec.node: axis.name for axis in self.values()}

    def set_up(self, line: CanLine) -> None:
        """Write the settings of all drives and read them back.

        Raises:
            CanFault: a drive does not answer or is of an unsuitable kind, or a setting is read back
                differently.
        """
        self._line = line
        for axis in self.values():
            line.add_node(axis)
        set_up(self.values(), self._spec, self._period)

    def look(self) -> None:
        """Read the present position of each axis from its drive; raise `CanFault` if a drive cannot be
        read.
        """
        look(self.values())

    def enable(self, simulated: bool, beat: Callable[[], None]) -> None:
        """Enable the torque of all drives at standstill, and begin to check that they follow their commands.

        Args:
            simulated: True for simulated drives, which need no waiting by the wall clock.
            beat: sends this program's heartbeat if it is due.

        Raises:
            CanFault: a drive cannot be enabled.
        """
        enable(tuple(self.values()), simulated, beat)
        self._checks = [AxisCheck(axis) for axis in self.values()]

    def send(self) -> None:
        """Send the commands of this period to the drives of all axes."""
        for axis in self.values():
            axis.send()

    def sync(self) -> None:
        """End a control period: send SYNC, and receive the drives' answers that arrive within half a
        period.
        """
        self._line.drain()  # late frames belong to an earlier SYNC
        for axis in self.values():
            axis.ask()
        self._line.sync.transmit()
        axes = tuple(self.values())
        self._line.wait(lambda: all(axis.answered for axis in axes), _ANSWER_WITHIN * self._period)

    def check(self) -> None:
        """Check the drive of each axis after a SYNC.

        Raises:
            CanFault: a drive does not answer, is not enabled, or does not follow its commands.
        """
        for check in self._checks:
            check.check()

    def end_handshakes(self) -> None:
        """Clear the bit "new set-point" in the controlword of each drive that has acknowledged this bit."""
        for axis in self.values():
            axis.end_handshake()

    def hold(self) -> None:
        """Make every axis slow down from the next period on, and hold the position at which it stops."""
        for axis in self.values():
            axis.hold()

    def quick_stop(self) -> None:
        """Stop all axes, each with the kind of stop that the robot's file gives it."""
        _each(axis.quick_stop for axis in self.values())

    @property
    def at_rest(self) -> bool:
        """True if all drives have answered the last SYNC, each with a velocity of at most 1 % of its axis'
        top speed.
        """
        return all(axis.answered and axis.stands for axis in self.values())

    @property
    def periods_to_rest(self) -> int:
        """Number of periods within which a quick stop brings all axes to rest."""
        longest = max(axis.limits.speed / axis.limits.braking for axis in self.values())
        return 3 + round(longest / self._period)

    def disable(self) -> None:
        """Switch off the torque of all drives, except those with `stop: hold` in the robot's file."""
        _each(axis.disable for axis in self.values())

    def leave(self) -> None:
        """Put all drives into PRE-OPERATIONAL by NMT: in this state, PDOs that arrive late move nothing."""
        _each(axis.leave for axis in self.values())

    @property
    def holding(self) -> tuple[Axis, ...]:
        """Axes whose drives hold their position with torque after the program has ended."""
        return tuple(axis for axis in self.values() if axis.spec.stop == HOLD_COMMAND)


def _each(acts: Iterable[Callable[[], None]]) -> None:
    """Call all functions, even if one raises; its exception is raised at the end."""
    with ExitStack() as all_of_them:
        for act in reversed(list(acts)):
            all_of_them.callback(act)


def planned_axes(robot: RobotFile, spec: CanSpec) -> Iterator[tuple[str, AxisSpec, AxisUnits, AxisLimits]]:
    """Yield name, description, units and limits of each axis that the section `can` describes."""
    for name, wheel in zip(("left wheel", "right wheel"), spec.wheels, strict=True):
        yield (
            name,
            wheel,
            AxisUnits(wheel.counts_per_m(robot.drive.wheel_radius_m)),
            wheel_limits(robot, wheel),
        )
    if spec.joints:
        model = robot.arm_model()
        for place, joint in enumerate(spec.joints):
            units = AxisUnits(joint.counts_per_unit, joint.zero_counts)
            yield f"joint {place + 1}", joint, units, joint_limits(robot, joint, model, place)
    if spec.gripper is not None:
        units = AxisUnits(spec.gripper.counts_per_m, spec.gripper.zero_counts)
        yield "gripper", spec.gripper, units, gripper_limits(robot, spec.gripper)


def _axis(name: str, spec: AxisSpec, units: AxisUnits, limits: AxisLimits, robot: RobotFile) -> Axis:
    kind = "velocity" if name.endswith("wheel") else "position"
    mode = CIA402_MODES[kind, getattr(spec, "mode", "profile")]
    return Axis(name, spec, mode, units, limits, _dictionary(spec, robot), robot.period_s)


def _dictionary(spec: AxisSpec, robot: RobotFile) -> ObjectDictionary:
    if spec.eds is None:
        return drive_dictionary(spec.node)
    return drive_dictionary(spec.node, Path(robot.folder) / spec.eds)
