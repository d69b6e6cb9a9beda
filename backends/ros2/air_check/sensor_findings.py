"""Findings about the content of readings at rest: units, axes, calibration."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from handcart.backends.robot.mounted_camera import known_camera, mount_of
from handcart.backends.ros2.cameras.ros_depth_camera import DEPTH_TYPES, depth_of
from handcart.backends.ros2.ros_imu import RosImu
from handcart.backends.ros2.ros_lidar import RosLidar
from handcart.backends.ros2.wire.camera_topics import camera_topics, depth_topics
from handcart.backends.ros2.wire.topic_sensor import TopicSensor
from handcart.robotics.numerics.arrays import SingleArray

from .air_finding import AirFinding
from .camera_info_findings import camera_info_findings
from .heard_robot import HeardRobot

GRAVITY_M_S2 = 9.81
MAX_GRAVITY_ERROR_M_S2 = 1.0
MAX_MOTION_M, MAX_TURN_DEG = 0.05, 3.0
"""Motion of the base during a check, in [m] and in [deg], from which the base counts as moving."""
MAX_SHARE_BEYOND_REACH = 0.5
MIN_NEARNESS = 0.5
"""Share of a depth camera's minimum range below which no reading can be true."""


def sensor_findings(heard: HeardRobot) -> Iterator[AirFinding]:
    """Yield a finding for each sensor whose readings are implausible or contradict the robot's file."""
    moved = _motion(heard)
    if moved and not heard.may_drive:
        yield AirFinding(("ros2", "odometry"), moved)
    for key, sensor in heard.sensors():
        last = heard.last(sensor.source.topic)
        words = "" if sensor.age is None or last is None else _wrong_content(heard, sensor, last, not moved)
        if words:
            yield AirFinding(("ros2", key), f"{sensor.name}: {words}")
        if isinstance(sensor, RosLidar) and last is not None and not np.isfinite(last.ranges).any():
            silent = (
                f"{sensor.name}: no beam of its last scan returns; is something before it, or all far away?"
            )
            yield AirFinding(("ros2", key), silent, is_fault=False)
    yield from _depths(heard)
    yield from _lenses(heard)


def _depths(heard: HeardRobot) -> Iterator[AirFinding]:
    """Yield the findings about the units of all depth cameras."""
    for name, (deep, topics) in depth_topics(heard.robot, heard.spec).items():
        last = heard.last(topics.topic)
        if last is None or last.encoding not in DEPTH_TYPES:
            continue  # another finding says so
        _, unit = DEPTH_TYPES[last.encoding]
        depth = depth_of(last, 0.0, math.inf)
        seen = depth[np.isfinite(depth)]
        place, sensor = ("ros2", "depth"), f"the depth camera {name!r} ({topics.topic})"
        if not seen.size:
            words = f"{sensor}: no pixel of its last picture has a reading; is something before it?"
            yield AirFinding(place, words, is_fault=False)
        elif words := _wrong_unit(seen, deep.range_min_m, deep.reach_m, unit):
            means = f"{last.encoding} means {'mm' if unit < 1.0 else 'm'}"
            yield AirFinding(place, f"{sensor}: {words} ({means})")


def _wrong_unit(seen: SingleArray, nearest: float, farthest: float, unit: float) -> str:
    """Return the reason why depths are in another unit than the assumed one, as text; "" if they are not.

    Args:
        seen: (n,) depths in [m], by the assumed unit.
        nearest: minimum depth of the camera, in [m].
        farthest: maximum depth of the camera, in [m].
        unit: assumed length of a step of the depth, in [m].
    """
    for beyond, limit, other in (
        (seen > farthest, f"beyond {farthest:g} m (reach_m)", "mm" if unit == 1.0 else "steps below 1 mm"),
        (seen < MIN_NEARNESS * nearest, f"nearer than half of {nearest:g} m (range_min_m)", "m or cm"),
    ):
        share = float(np.mean(beyond))
        if share > MAX_SHARE_BEYOND_REACH:
            middle = float(np.median(seen))
            return (
                f"{share:.0%} of its readings are {limit}, the median at {middle:.3g} m; are they in {other}?"
            )
    return ""


def _lenses(heard: HeardRobot) -> Iterator[AirFinding]:
    """Yield the findings about the calibrations of all cameras that have topics."""
    robot, spec = heard.robot, heard.spec
    for name, (camera, topic) in camera_topics(robot, spec).items():
        ours = known_camera(camera, mount_of(robot, camera)).model
        yield from camera_info_findings((name,), topic, ours, heard.last(topic.info_topic))
    for name, (deep, topics) in depth_topics(robot, spec).items():
        yield from camera_info_findings((name,), topics, deep.model, heard.last(topics.info_topic))


def _motion(heard: HeardRobot) -> str:
    """Return by how much the base moved, as text; "" at rest."""
    first, last = heard.first_pose, heard.topics.odometry.pose
    if first is None or last is None:
        return ""
    step = last.relative_to(first)
    way, turn = math.hypot(step.x, step.y), math.degrees(step.theta)
    if not (way > MAX_MOTION_M or abs(turn) > MAX_TURN_DEG):
        return ""
    return (
        f"the odometry ({heard.spec.odometry.topic}): the base moved by {way:.3g} m and {turn:.1f} deg"
        " during the check; needed: at rest"
    )


def _wrong_content(heard: HeardRobot, sensor: TopicSensor, last: Any, at_rest: bool) -> str:
    """Return what is wrong with the last reading; "" if nothing is."""
    if isinstance(sensor, RosLidar):
        return _wrong_ranges(heard, np.asarray(last.ranges, np.float64))
    if isinstance(sensor, RosImu) and at_rest:
        gravity = last.linear_acceleration
        return _wrong_gravity(float(gravity.x), float(gravity.y), float(gravity.z))
    return ""


def _wrong_ranges(heard: HeardRobot, ranges: np.ndarray[Any, np.dtype[np.float64]]) -> str:
    spec = heard.robot.range_sensor
    assert spec is not None, "its file says so"
    finite = ranges[np.isfinite(ranges) & (ranges > 0.0)]
    beyond = float(np.mean(finite > spec.reach_m)) if len(finite) else 0.0
    if beyond <= MAX_SHARE_BEYOND_REACH:
        return ""
    middle = float(np.median(finite))
    return (
        f"{100 * beyond:.0f} % of its returns are beyond {spec.reach_m:g} m (reach_m), the median at"
        f" {middle:.4g}; are they in mm?"
    )


def _wrong_gravity(x: float, y: float, z: float) -> str:
    size = math.sqrt(x * x + y * y + z * z)
    if abs(z - GRAVITY_M_S2) <= MAX_GRAVITY_ERROR_M_S2:
        return ""
    reading = f"it reads ({x:.2f}, {y:.2f}, {z:.2f}) m/s^2 at rest; needed: (0, 0, +9.81)"
    if abs(size - 1.0) < 0.1:
        return f"{reading}: is it in g?"
    if size < MAX_GRAVITY_ERROR_M_S2:
        return f"{reading}: gravity is taken out"
    return f"{reading}: its axes are not those of the base"
