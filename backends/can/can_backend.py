"""A robot whose wheels are CANopen drives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import can

from backends.backend import Backend
from backends.can_spec import VIRTUAL, CanSpec
from backends.capability import Capability
from backends.robot_file import RobotFile
from backends.scene.load_world import load_world
from backends.scene.scene import Scene
from backends.scene.world_file import WorldFile

from .bench import Bench
from .can_base import CanBase
from .can_line import CanLine
from .drive_pair import STILL, DrivePair
from .errors import BusFault, CanFault, NoDrives, NoInterface
from .pace import Pace


class CanBackend(Backend):
    """A differential drive: two CiA 402 drives in profile velocity mode, where the robot's file says.

    A step sends both target velocities (60FFh) by PDO, waits for the end of the period, sends a SYNC, and
    waits for the statuswords (6041h) and positions (6064h) that answer it. A drive that is silent or not in
    OPERATION ENABLED ends the step with a `CanFault`: both wheels have been braked and have no torque then,
    and every further step ends with the same fault.

    With the interface `virtual` the drives are simulated in this process: a period passes with each step, no
    clock is read, and the same seed gives the same run. With a world's file their wheels drive a base
    through it, seen by its range sensor (see `DrivenScene`). With any other interface drives are expected on
    the bus, a step lasts a period of the wall clock, and there are wheels alone.

    On metal a command lives until the next step: who computes for long between two steps lets the wheels
    turn on. Drives are not yet told to stop by themselves when they hear nothing.
    """

    name = "can"

    def __init__(self, robot: RobotFile, world: WorldFile | None, seed: int) -> None:
        """Open the interface and enable the drives.

        Raises:
            NoDrives: the robot's file has no section `can`.
            TooManyCounts: the speeds of that file don't fit into the drives' 32 bits.
            NoInterface: the interface can't be opened.
            CanFault: a drive is missing, is of a wrong kind, or doesn't become ready.
        """
        if robot.can is None:
            raise NoDrives()
        self.period = robot.period_s
        virtual = robot.can.interface == VIRTUAL
        self.simulated = virtual
        self.address = f"{robot.can.interface} {robot.can.channel}"
        self._periods, self._closed = 0, False
        self._fault: CanFault | None = None
        self._wheels = DrivePair(robot, robot.can)
        self._base = CanBase(robot.drive, self._wheels)
        self.bench = Bench(robot, robot.can, world, seed) if virtual else None
        """What is simulated; None with real drives."""
        self._line, pace = self._open(robot.can)
        try:
            with _bus("setting the drives up"):
                self._wheels.start(self._line, pace)
        except BaseException:
            self.close()
            raise

    def _open(self, spec: CanSpec) -> tuple[CanLine, Callable[[], None]]:
        """The line to the drives, and what waits for the end of a period."""
        if self.bench is not None:
            drives = self.bench.drives
            return CanLine(drives.open(), drives.serve), lambda: None
        return CanLine(_interface(spec)), Pace(self.period).wait

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> CanBackend:
        """See `Backend`; the world is read for simulated drives alone."""
        virtual = robot.can is not None and robot.can.interface == VIRTUAL
        return cls(robot, load_world(world) if virtual and world is not None else None, seed)

    @property
    def scene(self) -> Scene | None:
        """Ground truth, None where no world is simulated: only evaluation may read it."""
        driven = self.bench and self.bench.driven
        return driven.scene if driven else None

    def capabilities(self) -> tuple[Capability, ...]:
        """See `Backend`."""
        driven = self.bench and self.bench.driven
        sensor = driven.range_sensor if driven else None
        return (self._base,) if sensor is None else (self._base, sensor)

    def step(self) -> None:
        """See `Backend`.

        Raises:
            CanFault: a drive is silent or not enabled, or the interface fails, now or in an earlier step.
        """
        if self._fault is not None:
            raise self._fault
        self._periods += 1
        try:
            with _bus("driving"):
                self._base.advance()
        except CanFault as fault:
            self._fault = fault
            self._let_go()
            raise
        finally:
            if self.bench is not None:
                self.bench.advance(self._periods)  # also by what the wheels roll while they brake

    def stop(self) -> None:
        """See `Backend`; raises `BusFault` if the interface fails."""
        self._base.forget()
        if self._fault is None and not self._closed:
            with _bus("stopping"):
                self._wheels.send(STILL)

    def close(self) -> None:
        """See `Backend`; the wheels are braked, then lose their torque."""
        if self._closed:
            return
        self._closed = True
        if self._fault is None:
            self._let_go()
        self._line.close()
        if self.bench is not None:
            self.bench.close()

    def _let_go(self) -> None:
        # An interface that fails can't be asked for more.
        with suppress(can.CanError):
            self._wheels.let_go()


@contextmanager
def _bus(doing: str) -> Iterator[None]:
    """Tell of a failing interface in our words."""
    try:
        yield
    except can.CanError as error:
        raise BusFault(doing, str(error)) from error


def _interface(spec: CanSpec) -> can.BusABC:
    try:
        return can.Bus(interface=spec.interface, channel=spec.channel, bitrate=1000 * spec.bitrate_kbit_s)
    except (can.CanError, OSError, ImportError, ValueError) as error:
        raise NoInterface(spec.interface, spec.channel, 1000 * spec.bitrate_kbit_s, str(error)) from error
