"""The sensors of a real robot beside its drives."""

from __future__ import annotations

import time

from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gps import Gps
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.can_sensor_spec import SensorsSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.live.live_sensor import Clock, LiveSensor
from handcart.backends.live.sensor_errors import NoSensor
from handcart.backends.robot.mounted_camera import known_camera, mount_of
from handcart.robotics.kinematics.urdf_frames import base_T_frame

_FIRST = 3.0  # [s] in which the first reading is to come
_PAUSE = 0.01

_KINDS: dict[str, type[Capability]] = {
    "camera": Camera,
    "range_sensor": RangeSensor,
    "imu": Imu,
    "gps": Gps,
}


def sensor_kinds(sensors: SensorsSpec) -> tuple[type[Capability], ...]:
    """Return the capabilities that the sensors of a robot's file provide, without opening any device."""
    return tuple(kind for key, kind in _KINDS.items() if getattr(sensors, key) is not None)


def open_sensors(robot: RobotFile, sensors: SensorsSpec, clock: Clock = time.monotonic) -> list[LiveSensor]:
    """Open all sensors of a robot; if one fails, close the others again.

    Args:
        robot: robot file, whose sections state what the sensors measure.
        sensors: connections of the sensors, from the key `sensors` of the section `can`.
        clock: gives the time in [s].

    Raises:
        NoSensor: a sensor cannot be opened, or its own section is missing in the robot's file.
    """
    opened: list[LiveSensor] = []
    try:
        for key in _KINDS:
            if getattr(sensors, key) is not None:
                if getattr(robot, key) is None:
                    raise NoSensor(
                        f"can.sensors.{key}: its measured quantity is missing; needed: the section {key!r}"
                    )
                opened.append(_open(key, robot, sensors, clock))
    except BaseException:
        for sensor in opened:
            sensor.close()
        raise
    return opened


def await_first(sensors: list[LiveSensor], seconds: float = _FIRST) -> None:
    """Wait until each sensor has delivered a reading, except satellite receivers.

    Args:
        sensors: all sensors; satellite receivers among them are read as well, but may have their first fix
            later.
        seconds: longest wait, in [s].

    Raises:
        NoSensor: a sensor has not delivered a reading in that time.
    """
    end = time.monotonic() + seconds
    waited = [sensor for sensor in sensors if not isinstance(sensor, Gps)]
    while True:
        for sensor in sensors:
            sensor.advance()
        silent = [sensor for sensor in waited if sensor.age is None]
        if not silent:
            return
        if time.monotonic() > end:
            why = silent[0].trouble or f"{silent[0].rejected} readings were no good"
            raise NoSensor(f"{silent[0].name} gave no reading in {seconds:g} s ({why})")
        time.sleep(_PAUSE)


def _open(key: str, robot: RobotFile, sensors: SensorsSpec, clock: Clock) -> LiveSensor:
    if key == "camera":
        from .video_camera import VideoCamera

        assert sensors.camera is not None
        assert robot.camera is not None
        known = known_camera(robot.camera, mount_of(robot, robot.camera))
        return VideoCamera(sensors.camera, known, clock)
    if key == "range_sensor":
        from .line_range_sensor import LineRangeSensor

        assert sensors.range_sensor is not None
        assert robot.range_sensor is not None
        mount = base_T_frame(robot.urdf_text(), "range_sensor")
        return LineRangeSensor(sensors.range_sensor, robot.range_sensor, mount, clock)
    if key == "imu":
        from .line_imu import LineImu

        assert sensors.imu is not None
        return LineImu(sensors.imu, clock)
    from .nmea_gps import NmeaGps

    assert sensors.gps is not None
    assert robot.gps is not None
    receiver = NmeaGps(sensors.gps, clock)
    receiver.set_period(robot.gps.period_s)
    return receiver
