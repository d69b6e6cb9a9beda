"""Messages of a simulated robot's sensors."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.depth_camera import DepthCamera
from handcart.backends.capabilities.gps import Fix
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.ros_spec import RosGpsSpec
from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.ros2.wire.messages import NO_FIX, set_stamp
from handcart.backends.ros2.wire.ros_link import Link
from handcart.robotics.geometry.earth_frame import EarthFrame
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.perception.cameras.camera_model import CameraModel


def odometry_message(link: Link, now: float, pose: Pose2, speeds: DriveCommand) -> Any:
    """Return a ROS message `Odometry` with a pose and speeds of the base.

    Args:
        link: connection to the topics, which creates the message.
        now: time of ROS, in [s].
        pose: 2D pose odom_T_base.
        speeds: speeds of the base in its own frame, in [m/s] and [rad/s].
    """
    message = _stamped(link, "nav_msgs/Odometry", now, "odom")
    message.child_frame_id = "base_link"
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    place.x, place.y = float(pose.x), float(pose.y)
    turn.z, turn.w = math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta)
    twist = message.twist.twist
    twist.linear.x, twist.linear.y = float(speeds.speed), float(speeds.sideways)
    twist.angular.z = float(speeds.turn_rate)
    return message


def state_message(
    link: Link, now: float, names: Sequence[str], positions: Sequence[float], efforts: Sequence[float]
) -> Any:
    """Return a `JointState` message.

    Args:
        link: connection to the topics, which creates the message.
        now: time of ROS, in [s].
        names: names of the n joints in ROS.
        positions: (n,) in [rad] or [m].
        efforts: (n,) in [Nm] or [N].
    """
    message = _stamped(link, "sensor_msgs/JointState", now, "")
    message.name, message.position, message.effort = list(names), list(positions), list(efforts)
    return message


def scan_message(
    link: Link,
    now: float,
    spec: RangeSpec,
    robot: Backend,
    factor: float = 1.0,
    mirrored: bool = False,
    is_upside_down: bool = False,
) -> Any:
    """Return the scan of a simulated lidar as a `LaserScan`.

    Args:
        link: connection to the topics, which creates the message.
        now: time of ROS, in [s].
        spec: the lidar's section of the robot's file.
        robot: simulated robot with the lidar.
        factor: factor by which the ranges are multiplied, to simulate a difference from the robot's file.
        mirrored: True for ranges in the wrong order.
        is_upside_down: True for a lidar mounted upside down, whose angles grow clockwise as seen from above.
    """
    lidar = robot.get(RangeSensor)  # type: ignore[type-abstract]
    assert lidar is not None, "its file says so"
    angles = spec.angles()
    message = _stamped(link, "sensor_msgs/LaserScan", now, "range_sensor")
    ends = (-angles[-1], -angles[0]) if is_upside_down else (angles[0], angles[-1])
    message.angle_min, message.angle_max = map(float, ends)
    message.angle_increment = float(angles[1] - angles[0])
    message.range_min, message.range_max = float(spec.range_min_m), float(spec.reach_m)
    ranges = lidar.scan().ranges[:: -1 if mirrored != is_upside_down else 1]
    message.ranges = array("f", (factor * ranges).astype(np.float32).tobytes())
    return message


def imu_message(link: Link, now: float, robot: Backend, factor: float = 1.0) -> Any:
    """Return the readings of a simulated IMU as a message `sensor_msgs/Imu`.

    Args:
        link: connection to the topics, which creates the message.
        now: time of ROS for the message's stamp, in [s].
        robot: simulated robot with the IMU.
        factor: factor by which the accelerations are multiplied, to simulate an IMU with a wrong unit or
            sign.
    """
    unit = robot.get(Imu)  # type: ignore[type-abstract]
    assert unit is not None, "its file says so"
    message = _stamped(link, "sensor_msgs/Imu", now, "imu")
    for vector, values in (
        (message.angular_velocity, unit.rates()),
        (message.linear_acceleration, factor * unit.accelerations()),
    ):
        vector.x, vector.y, vector.z = map(float, values)
    return message


def no_fix_message(link: Link, now: float) -> Any:
    """Return a `NavSatFix` of a receiver without a fix; `now` is the time of ROS for its stamp, in [s]."""
    message = _stamped(link, "sensor_msgs/NavSatFix", now, "gps")
    message.status.status = NO_FIX
    message.latitude = message.longitude = message.altitude = math.nan
    return message


def fix_message(link: Link, now: float, spec: RosGpsSpec, fix: Fix) -> Any:
    """Return a fix of a simulated receiver as a `NavSatFix`.

    Args:
        link: connection to the topics, which creates the message.
        now: time of ROS for its stamp, in [s].
        spec: section with the origin on Earth of the fix's coordinates.
        fix: position east and north of that origin, in [m].
    """
    message = _stamped(link, "sensor_msgs/NavSatFix", now, "gps")
    frame = EarthFrame(spec.origin_lat_deg, spec.origin_lon_deg)
    message.latitude, message.longitude = frame.to_earth(*map(float, fix.position))
    variance = float(fix.sigma) ** 2
    message.position_covariance = [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, 4.0 * variance]
    message.position_covariance_type = 2  # its diagonal is known
    return message


class LatePicture:
    """Pixels of a picture in a message, rendered only when they are read.

    They must be read in the control period in which the message is sent, because later the scene is another
    one.
    """

    def __init__(self, size: int, render: Callable[[], NDArray[Any]]) -> None:
        """Take the number of bytes of the picture, and a function that returns its pixels."""
        self._size, self._render = size, render

    def __len__(self) -> int:
        return self._size

    def __bytes__(self) -> bytes:
        return np.ascontiguousarray(self._render()).tobytes()


def image_message(link: Link, now: float, camera: Camera, late: bool = False, frame: str = "camera") -> Any:
    """Return the picture of a simulated camera as an `Image`.

    Args:
        link: connection to the topics, which creates the message.
        now: time of ROS, in [s].
        camera: takes the picture.
        late: True to render the picture only when the message's data are read, which has to happen before the
            robot's next step.
        frame: name of the camera's frame.
    """
    message = _picture(link, now, camera.model, ("mono8", 1), camera.image, late)
    message.header.frame_id = frame
    return message


def depth_messages(
    link: Link,
    now: float,
    camera: DepthCamera,
    late: bool = False,
    frame: str = "camera",
    factor: float = 1.0,
) -> tuple[Any, Any]:
    """Return the depth and the colour picture of a simulated depth camera, each as a message
    `sensor_msgs/Image`.

    Args:
        link: connection to the topics, which creates the messages.
        now: time of ROS, in [s].
        camera: takes the pictures.
        late: True to render the pictures only when the messages' data are read, which has to happen before
            the robot's next step.
        frame: name of the camera's frame.
        factor: factor by which the depths are multiplied, to simulate a difference from the robot's file.
    """
    model, times = camera.model, np.float32(factor)
    depth = _picture(link, now, model, ("32FC1", 4), lambda: camera.image().depth * times, late)
    colour = _picture(link, now, model, ("rgb8", 3), lambda: camera.image().colour, late)
    depth.header.frame_id = colour.header.frame_id = frame
    return depth, colour


def _picture(
    link: Link,
    now: float,
    model: CameraModel,
    encoding: tuple[str, int],
    render: Callable[[], NDArray[Any]],
    late: bool,
) -> Any:
    message = _stamped(link, "sensor_msgs/Image", now, "camera")
    message.height, message.width = model.height, model.width
    message.encoding, message.step = encoding[0], encoding[1] * model.width
    picture = LatePicture(message.step * model.height, render)
    message.data = picture if late else array("B", bytes(picture))
    return message


def camera_info_message(link: Link, now: float, model: CameraModel) -> Any:
    """Return the calibration of a camera as a `CameraInfo`.

    Args:
        link: connection to the topics, which creates the message.
        now: time of ROS for its stamp, in [s].
        model: intrinsics and distortion.
    """
    message = _stamped(link, "sensor_msgs/CameraInfo", now, "camera")
    message.width, message.height = model.width, model.height
    fisheye = model.lens == "fisheye"
    message.distortion_model = (
        "equidistant" if fisheye else "plumb_bob" if len(model.distortion) <= 5 else "rational_polynomial"
    )
    message.d, message.k = model.distortion.tolist(), model.K.ravel().tolist()
    message.r = np.eye(3).ravel().tolist()
    message.p = np.column_stack([model.K, np.zeros(3)]).ravel().tolist()
    return message


def _stamped(link: Link, kind: str, now: float, frame: str) -> Any:
    message = link.message(kind)
    message.header.frame_id = frame
    set_stamp(message.header, now)
    return message
