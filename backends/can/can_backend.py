"""A robot whose wheels, joints and fingers are CANopen drives."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import can
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.bus.errors import BrokenOff, BusFault, CanFault, LateLoop, NoDrives
from handcart.backends.can.bus.frame_log import FrameLog
from handcart.backends.can.bus.frame_names import names_of
from handcart.backends.can.bus.heartbeat import Heartbeat
from handcart.backends.can.bus.open_bus import open_bus
from handcart.backends.can.drives.axes import Axes
from handcart.backends.can.sensors.live_sensors import await_first, open_sensors
from handcart.backends.can.watches.bus_guard import BusGuard
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.can_spec import VIRTUAL_INTERFACE, CanSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.live.live_sensor import LiveSensor
from handcart.backends.live.pace import Pace
from handcart.backends.plain_values import attributes, from_plain, set_attributes
from handcart.backends.saved_state import NotAState
from handcart.robotics.numerics.arrays import ByteArray

from .can_parts import CanParts, capabilities_of

_LISTENED = 2.0  # periods of a master, its SYNC or its heartbeat


class CanBackend(Backend):
    """Backend with CiA 402 drives, as in the robot's file: wheels, joints and gripper.

    The constructor writes all settings of all drives and reads them back; no drive has torque. The first step
    enables them. A step sends this program's heartbeat and the commands by PDO, waits for the end of the
    period, sends a SYNC, and receives the drives' answers. Any fault of a drive or the bus stops all axes,
    each with its own kind of stop, and ends the step with a `CanFault`; every further step raises the same
    error, until a new backend is built.

    On a bench (the interface `virtual`, or `build_on_bench`) the drives are simulated in this process, and
    they move the robot of a simulated backend: each step advances the simulation by one period, no clock is
    read, and the same seed gives the same run. Sensors that are not on the bus are those of the simulated
    backend. Without a bench, drives are expected on the bus, and a step lasts one period of the wall clock.
    Long computations run in a thread (`Robot.compute`) and do not delay the steps. If the steps pause for
    longer than the drives' heartbeat time, the drives stop.
    """

    name = "can"
    has_drives = True

    def __init__(self, robot: RobotFile, bench: Bench | None) -> None:
        """Open the interface, and set the drives up.

        Args:
            robot: the robot's file.
            bench: simulated drives, owned by the backend from now on; None: real ones.

        Raises:
            NoDrives: the robot's file has no section `can`.
            TooManyCounts: a possible command to an axis does not fit into the drives' 32 bits.
            NoInterface: the interface cannot be opened.
            NoSensor: a sensor that is not on the bus cannot be opened, or delivers nothing.
            CanFault: a drive is missing, is of a wrong kind, or is not set as it should be.
        """
        if robot.can is None:
            raise NoDrives()
        self.period = robot.period_s
        self.bench = bench
        """The simulated drives; None with real drives."""
        self.simulated = bench is not None
        self.address = f"{robot.can.interface} {robot.can.channel}"
        self._spec, self._periods = robot.can, 0
        self._fault: CanFault | None = None
        self._enabled = self._closed = self._is_looking_on = False
        self._sensors: list[LiveSensor] = []
        self.epoch = 0
        """Number of stops; commands of an earlier epoch move nothing."""
        self.axes = Axes(robot, robot.can)
        """The drives, by the names of the parts that they move."""
        self._parts = CanParts(robot, robot.can, self.axes)
        self._pace = None if bench else Pace(self.period, sleep=self._listen)
        self._line = self._open(robot.can)
        self._guard = BusGuard(self._line, self.axes, robot.can, self._now)
        self._heartbeat = Heartbeat(self._line, robot.can.our_node, robot.can.heartbeat_ms / 1e3, self._now)
        try:
            with _bus("setting the drives up"):
                self._set_up()
            self._guard.end_set_up()
            self._parts.begin()
            if bench is None:
                self._sensors = open_sensors(robot, robot.can.sensors)
                await_first(self._sensors)
        except BaseException:
            self.close()
            raise

    def _open(self, spec: CanSpec) -> CanLine:
        stamps = "robot" if self.bench else "unix"
        log = FrameLog(spec.channel, self._stamp, lambda: names_of(self._line, stamps))
        self.recording = log
        if self.bench is not None:
            return CanLine(self.bench.open(), self.bench.serve, log.note)
        return CanLine(open_bus(spec), None, log.note)

    def _set_up(self) -> None:
        """Set the drives up, unless another master has them: our first frame would stop its robot."""
        if self.bench is None:
            self._line.wait(self._guard.check, _LISTENED * max(self.period, self._spec.heartbeat_ms / 1e3))
        try:
            self.axes.set_up(self._line)
        except CanFault:
            self._guard.check()  # two nodes with one ID are the cause of odd answers
            raise
        self._guard.check()

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> CanBackend:
        """Build the backend for a real bus, or with simulated drives if the robot's file names the interface
        `virtual`.

        With simulated drives and a world, the robot that they move is simulated in this world as well.
        """
        if robot.can is not None and robot.can.interface == VIRTUAL_INTERFACE:
            from handcart.backends.kinematic.kinematic_backend import KinematicBackend

            return cls._on_bench(robot, world, seed, KinematicBackend if world is not None else None)
        return cls(robot, None)

    @classmethod
    @override
    def build_on_bench(
        cls, robot: RobotFile, world: Path | None, seed: int, bench: type[Backend]
    ) -> CanBackend:
        return cls._on_bench(robot, world, seed, bench)

    @classmethod
    def _on_bench(
        cls, robot: RobotFile, world: Path | None, seed: int, bench: type[Backend] | None
    ) -> CanBackend:
        if robot.can is None:
            raise NoDrives()
        inner = None if bench is None else bench.build(robot, world, seed)
        with ExitStack() as parts:  # closed here unless the backend owns them
            if inner is not None:
                parts.callback(inner.close)
            stand = Bench(robot, robot.can, inner)
            parts.callback(stand.close)
            backend = cls(robot, stand)
            parts.pop_all()
        backend.remarks = () if inner is None else inner.remarks
        return backend

    @classmethod
    @override
    def kinds(cls, robot: RobotFile) -> tuple[type[Capability], ...] | None:
        return capabilities_of(robot) if robot.can and robot.can.interface != VIRTUAL_INTERFACE else None

    @property
    def inner(self) -> Backend | None:
        """With simulated drives, the backend that simulates the robot that they move; None on a real bus, or
        without a world.
        """
        return self.bench.inner if self.bench else None

    @override
    def capabilities(self) -> tuple[Capability, ...]:
        sensors = [sensor for sensor in self._sensors if isinstance(sensor, Capability)]
        own = (*self._parts.capabilities(), *sensors)
        others = () if self.inner is None else self.inner.capabilities()
        return (*own, *(other for other in others if not _same_kind(other, own)))

    def step(self) -> None:
        """Send the commands, wait for the end of the period and receive the drives' answers.

        Raises:
            CanFault: a drive or the bus has a fault, now or in an earlier step.
        """
        with self._or_stopped("driving"):
            self._period()

    def _period(self) -> None:
        if not self._enabled:
            self.enable()
        self._periods += 1
        self._heartbeat.beat()
        self._parts.pass_on()
        self.axes.send()
        if self._pace is not None:
            self._pace.wait()
            if self._pace.trouble:
                raise LateLoop(self._pace.trouble)
        self.axes.sync()
        for sensor in self._sensors:
            sensor.advance()
        self._guard.check()
        self.axes.check()
        self.axes.end_handshakes()

    def _listen(self, seconds: float) -> None:
        """Wait and receive frames; outside of `watch` a fault that a frame shows ends the wait at once."""
        going_on = self._fault is None and not self._closed and not self._is_looking_on
        self._line.wait(self._guard.check if going_on else lambda: None, seconds)

    def enable(self) -> None:
        """Enable the drives while they are at rest; called in the first step. A second call does nothing."""
        if self._enabled:
            return
        with self._or_stopped("enabling the drives"):
            self._guard.check()
            self.axes.enable(self.simulated, self._heartbeat.beat)
            self._enabled = True
            self._guard.begin()
            if self._pace is not None:
                self._pace.begin()

    def watch(self, beat: bool = True) -> None:
        """Let a period pass without commands and checks, to test whether enabled drives stop by themselves.

        Args:
            beat: True to send this program's heartbeat in the period.
        """
        with self._or_stopped("looking on"):
            if beat:
                self._heartbeat.beat()
            if self._pace is not None:
                self._is_looking_on = True
                self._pace.wait()
                self._is_looking_on = False
            self.axes.sync()

    def stop(self) -> None:
        """Stop all motion; arm and gripper hold their positions.

        Raises:
            CanFault: a command could not be sent; all axes are then stopped for good.
        """
        self.epoch += 1
        if self._fault is not None or not self._enabled or self._closed:
            self._parts.halt()
            return
        with self._or_stopped("stopping"):
            self._parts.halt()
            self._line.flush()
            self._parts.pass_on()
            self.axes.send()

    def close(self) -> None:
        """Stop all axes as the robot's file states, and release all resources; a second call does nothing."""
        if self._closed:
            return
        self._closed = True
        with ExitStack() as leaving:  # all of it, whatever one of them raises; from below up
            if self.bench is not None:
                leaving.callback(self.bench.close)
            if hasattr(self, "_line"):
                leaving.callback(self._line.close)
            for sensor in self._sensors:
                leaving.callback(sensor.close)
            if self._fault is None and self._enabled:
                self._stop_for_good()

    @override
    def view(self) -> ByteArray | None:
        inner = self.bench.inner if self.bench else None
        return None if inner is None else inner.view()

    def state(self) -> object | None:
        """Return the state of the bench for a checkpoint; None for drives on a real bus, or if it cannot be
        saved.
        """
        inner = None if self.bench is None or self.bench.inner is None else self.bench.inner.state()
        if inner is None or self.bench is None:
            return None
        return {"inner": inner, "time": self.bench.time, "parts": attributes(self._parts, CanParts.STATE)}

    @override
    def set_state(self, state: object) -> None:
        if self.bench is None or self.bench.inner is None:
            super().set_state(state)
            return
        if not isinstance(state, dict) or state.keys() != {"inner", "time", "parts"}:
            raise NotAState("no state of simulated drives; needed: inner, time, parts")
        kept = {**state, "time": from_plain(state["time"], float, "time")}
        self.bench.inner.set_state(kept["inner"])
        self.bench.stand_as_left(kept["time"])
        self.axes.look()
        set_attributes(self._parts, CanParts.STATE, kept["parts"])

    @override
    def figures(self) -> Mapping[str, Any]:
        return {} if self._pace is None else {"loop": self._pace.figures()}

    @contextmanager
    def _or_stopped(self, doing: str) -> Iterator[None]:
        """Stop drives that have torque for good, each in its own way, if anything is raised inside."""
        if self._fault is not None:
            raise self._fault
        try:
            with _bus(doing):
                yield
        except BaseException as error:
            if self._fault is None:
                self._fault = error if isinstance(error, CanFault) else BrokenOff(doing, error)
                if self._enabled:
                    self._stop_for_good()
            raise

    def _stop_for_good(self) -> None:
        """Stop all axes for good: drop queued frames; an interface that fails gets no commands.

        Each of these actions is done even if the one before it has raised an error.
        """
        self.epoch += 1
        axes = self.axes
        steps = (self._line.flush, self._brake, axes.disable, axes.sync, axes.leave)
        with suppress(can.CanError, BusFault), ExitStack() as stopping:
            for step in (self._deliver, *reversed(steps)):
                stopping.callback(step)
            self._parts.halt()

    def _brake(self) -> None:
        """Repeat the quick stop until all axes report that they are at rest.

        The order is repeated because drives that hear no command for a while leave OPERATIONAL, and then
        take none.
        """
        for _ in range(self.axes.periods_to_rest):
            self._heartbeat.beat()
            self.axes.quick_stop()
            self.axes.sync()
            if self.axes.at_rest:
                return
            if self._pace is not None:
                self._pace.wait()

    def _deliver(self) -> None:
        """Receive the frames that have arrived, and let simulated drives answer, without waiting."""
        self._line.wait(lambda: False, 0.0)

    def _now(self) -> float:
        """Return the time in [s]: the bench's, or the monotonic clock's."""
        return self.bench.time if self.bench else time.monotonic()

    def _stamp(self) -> float:
        return self.bench.time if self.bench else time.time()


def _same_kind(part: Capability, own: tuple[Capability, ...]) -> bool:
    """Return whether a capability is of the same kind as one of `own`."""
    kinds = {kind for capability in own for kind in type(capability).__mro__ if Capability in kind.__bases__}
    return isinstance(part, tuple(kinds))


@contextmanager
def _bus(doing: str) -> Iterator[None]:
    """Raise errors of the interface as `BusFault`."""
    try:
        yield
    except can.CanError as error:
        raise BusFault(doing, str(error)) from error
