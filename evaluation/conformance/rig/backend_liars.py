"""Mutant backends, each with one fault that the kit has to find."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping

import numpy as np

from handcart.backends.backend import Backend, CommandError
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gps import Fix, Gps
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.positioning import PoseReading, Positioning
from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.robot_file import RobotFile
from handcart.evaluation.conformance.rig.parts import part_of
from handcart.evaluation.layers.layered_backend import LayeredBackend
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

QUEUE_DELAY_PERIODS = 10  # periods by which a queued command comes late
KEPT_SCAN_PERIOD = 5  # periods of which one scan arrives
SCAN_DELAY_S = 0.2
TRAVEL_FACTOR = 1.25  # of what wheels report


class KeepsDriving(LayeredBackend):
    """Backend with a planted fault, by which a command to the base lasts until the next one, not for one
    period.

    The conformance kit has to find this fault.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)
        self._command: tuple[float, ...] = (0.0, 0.0)

    def base_drive(self, base: Base, *command: float) -> None:
        """Drive the base, and remember the command to repeat it in later steps."""
        base.drive(*command)
        self._command = command

    def step(self) -> None:
        """Repeat the last command of the base, then simulate a period; this is the fault of the mutant."""
        base = part_of(self.inner, Base)
        if base is not None and any(self._command):
            base.drive(*self._command)
        self.inner.step()

    def stop(self) -> None:
        """Stop the base, and no longer repeat its last command in later periods."""
        self._command = (0.0, 0.0)
        self.inner.stop()


class QueuesCommands(LayeredBackend):
    """Mutant backend that repeats the last command after a stop."""

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)
        self._command: tuple[float, ...] = (0.0, 0.0)
        self._due = -1

    def base_drive(self, base: Base, *command: float) -> None:
        """Drive the base, and remember the command to repeat it after a stop."""
        base.drive(*command)
        self._command = command

    def stop(self) -> None:
        """Stop, but keep the base's last command, which `step` sends again a few periods later."""
        self.inner.stop()
        self._due = QUEUE_DELAY_PERIODS

    def step(self) -> None:
        """Send the base's last command again a few periods after a stop (the planted fault), then step."""
        base = part_of(self.inner, Base)
        self._due -= 1
        if base is not None and 0 <= self._due < QUEUE_DELAY_PERIODS // 2:
            base.drive(*self._command)
        self.inner.step()


class TakesAnything(LayeredBackend):
    """Mutant backend that silently accepts commands beyond a limit, or NaN."""

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def base_drive(self, base: Base, *command: float) -> None:
        """Pass on the commanded speeds, and hide the error if they are rejected (the mutant's fault)."""
        _try(lambda: base.drive(*command))

    def arm_move(self, arm: Arm, joints: FloatArray) -> None:
        """Pass on the commanded joints (n,), in [rad] or [m], and hide the error if they are rejected."""
        _try(lambda: arm.move(joints))

    def gripper_move(self, gripper: Gripper, width: float) -> None:
        """Accept every width in [m], also beyond the limits."""
        _try(lambda: gripper.move(width))


def _try(command: Callable[[], None]) -> None:
    try:
        command()
    except CommandError:
        return


class MovesAtOnce(LayeredBackend):
    """Mutant backend whose base moves as soon as it is commanded, without waiting for the next step."""

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def base_drive(self, base: Base, *command: float) -> None:
        """Drive the base and step at once, so that the command acts before the caller's next step."""
        base.drive(*command)
        self.inner.step()


class WrongUnits(LayeredBackend):
    """Backend with a planted fault, by which it reports the wheels' travel in millimetres instead of metres.

    The conformance kit has to find this fault.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def base_wheel_travel(self, base: Base) -> WheelTravel:
        """Return the wheels' travel in [mm] instead of [m]."""
        travel = base.wheel_travel()
        return WheelTravel(*(1e3 * way for way in travel))


class EchoesCommands(LayeredBackend):
    """Mutant backend that reports the commanded joints as measured, while the first joint moves half as
    far.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)
        self._start: FloatArray | None = None
        self._commanded: FloatArray | None = None

    def arm_move(self, arm: Arm, joints: FloatArray) -> None:
        """Pass on the commanded joints (n,), in [rad] or [m], but move the first joint only half as far."""
        if self._start is None:
            self._start = arm.command()
        halved = np.array(joints, dtype=np.float64)
        halved[0] = 0.5 * (self._start[0] + halved[0])
        arm.move(halved)
        self._commanded = np.array(joints, dtype=np.float64)

    def arm_command(self, arm: Arm) -> FloatArray:
        """Return the commanded joints (n,), in [rad] or [m]."""
        return arm.command() if self._commanded is None else self._commanded.copy()

    def arm_joints(self, arm: Arm) -> FloatArray:
        """Return the commanded joints (n,), in [rad] or [m], instead of the measured ones."""
        return arm.joints() if self._commanded is None else self._commanded.copy()


class RollsDice(LayeredBackend):
    """Mutant backend whose ranges change with each call, by the wall clock."""

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def range_sensor_scan(self, sensor: RangeSensor) -> Scan:
        """Return a scan with an error of up to 1 mm that differs at each call."""
        scan = sensor.scan()
        return scan._replace(ranges=scan.ranges + 1e-3 * math.sin(1e6 * time.perf_counter()))


class HalfPixel(LayeredBackend):
    """Mutant backend whose pictures are shifted by half a pixel, as if coordinates were those of the pixels'
    edges, not of their middles.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def camera_image(self, camera: Camera) -> ByteArray:
        """Return the picture (h, w), grey, moved by half a pixel along the rows."""
        image = camera.image().astype(np.float64)
        return np.asarray(0.5 * (image + np.roll(image, 1, axis=1))).astype(np.uint8)


class Undelayed(LayeredBackend):
    """Mutant backend that reports the delayed pose of an external positioning system as if it had
    no delay.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def positioning_reading(self, positioning: Positioning) -> PoseReading | None:
        """Return the delayed pose of the positioning system as if it were measured now (age 0); None without
        one.
        """
        reading = positioning.reading()
        return None if reading is None else reading._replace(age=0.0)


class TurnsOtherWay(LayeredBackend):
    """Mutant backend whose gyro axes point down."""

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def imu_rates(self, imu: Imu) -> FloatArray:
        """Return the angular velocities (3,) about the IMU's axes, in [rad/s], with the opposite signs."""
        return -imu.rates()


class FixInMillimetres(LayeredBackend):
    """Backend with a planted fault, by which its satellite receiver reports positions in millimetres.

    The conformance kit has to find this fault.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def gps_fix(self, gps: Gps) -> Fix | None:
        """Return the fix in [mm] instead of [m]; None if no fix arrived."""
        fix = gps.fix()
        return None if fix is None else fix._replace(position=1e3 * fix.position)


class DropsScans(LayeredBackend):
    """Backend with a planted fault, by which four of five lidar scans are lost and an older scan is returned
    instead.

    The conformance kit has to find this fault.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)
        self._kept: Scan | None = None
        self._number = 0

    def step(self) -> None:
        """Step the backend by one period, and in every fifth period allow a new scan."""
        self.inner.step()
        self._number += 1
        if self._number % KEPT_SCAN_PERIOD == 0:
            self._kept = None

    def range_sensor_scan(self, sensor: RangeSensor) -> Scan:
        """Return the last scan that was not lost."""
        if self._kept is None:
            self._kept = sensor.scan()
        return self._kept


class DelaysScans(LayeredBackend):
    """Mutant backend whose scans are delayed by 200 ms."""

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)
        self._queue: list[Scan] = []
        self._length = 1 + round(SCAN_DELAY_S / inner.period)

    def step(self) -> None:
        """Step the wrapped backend, and append the scan of this period to the queue of delayed scans."""
        self.inner.step()
        sensor = part_of(self.inner, RangeSensor)
        if sensor is not None:
            self._queue = [*self._queue, sensor.scan()][-self._length :]

    def range_sensor_scan(self, sensor: RangeSensor) -> Scan:
        """Return the oldest scan in the queue, which is 200 ms old."""
        return self._queue[0] if self._queue else sensor.scan()


class MirrorsScans(LayeredBackend):
    """Backend with a planted fault, by which its lidar is mounted upside down, contrary to the robot's file.

    The conformance kit has to find this fault.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def range_sensor_scan(self, sensor: RangeSensor) -> Scan:
        """Return the scan with left and right exchanged."""
        scan = sensor.scan()
        mirrored = np.interp(-scan.angles, scan.angles, np.arange(len(scan.angles)), period=2.0 * math.pi)
        return scan._replace(ranges=scan.ranges[np.round(mirrored).astype(np.int64) % len(scan.ranges)])


class StretchesTravel(LayeredBackend):
    """Mutant backend whose wheels report a quarter more than they roll, as with a wrong radius in the
    driver.
    """

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def base_wheel_travel(self, base: Base) -> WheelTravel:
        """Return the wheels' travel, a quarter longer than the true travel."""
        return WheelTravel(*(TRAVEL_FACTOR * way for way in base.wheel_travel()))


class SwapsWheels(LayeredBackend):
    """Mutant backend that exchanges the travel of the left and the right wheel."""

    def __init__(self, inner: Backend, spec: RobotFile) -> None:
        super().__init__(inner)

    def base_wheel_travel(self, base: Base) -> WheelTravel:
        """Return the wheels' travel with the left and the right wheel exchanged."""
        travel = base.wheel_travel()
        return travel._replace(left=travel.right, right=travel.left)


BACKEND_LIARS: Mapping[str, Callable[[Backend, RobotFile], Backend]] = {
    kind.__name__: kind
    for kind in (
        KeepsDriving,
        QueuesCommands,
        TakesAnything,
        MovesAtOnce,
        WrongUnits,
        EchoesCommands,
        RollsDice,
        HalfPixel,
        Undelayed,
        TurnsOtherWay,
        FixInMillimetres,
        DropsScans,
        DelaysScans,
        MirrorsScans,
        StretchesTravel,
        SwapsWheels,
    )
}
