"""Comparison of the sensors' frames in `tf` with the robot's file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from handcart.backends.robot.mounted_camera import camera_mount, known_camera, mount_of
from handcart.backends.ros2.wire.camera_topics import camera_topics, depth_topics
from handcart.backends.ros2.wire.frame_tree import UPRIGHT_T_FLIPPED, lidar_pose
from handcart.files.suggest import suggest
from handcart.robotics.geometry.transform import Transform, difference
from handcart.robotics.kinematics.urdf_frames import base_T_frame

from .air_finding import AirFinding
from .heard_robot import HeardRobot

MAX_FRAME_ERROR_M, MAX_FRAME_ERROR_DEG = 0.03, 2.0
"""Largest allowed distance in [m], and angle in [deg], between a sensor's frame by `tf` and by the robot's
file.
"""


class _Placed(NamedTuple):
    """A sensor that has a frame on the robot."""

    name: str
    topic: str
    base_T_sensor: Transform
    """Pose (4, 4) of the sensor's frame in the base frame by the robot's file, with the joints as they are
    measured.
    """
    can_flip: bool = False
    """True for a lidar, for which the robot's file can say that it is mounted upside down."""


def frame_findings(heard: HeardRobot) -> Iterator[AirFinding]:
    """Yield a finding for each sensor whose pose on the base differs between `tf` and the robot's file."""
    odometry = heard.last(heard.spec.odometry.topic)
    base = getattr(odometry, "child_frame_id", "") or heard.spec.odometry.child_frame
    if not heard.frames.frames:
        if heard.has_frames:
            words = "tf_static, tf: no frames arrive; not compared with the file"
            yield AirFinding(("ros2",), words, is_fault=False)
        return
    for item in _placed(heard):
        message = heard.last(item.topic)
        if message is None:
            continue
        frame = message.header.frame_id
        for words in heard.frames.conflicts(frame):
            yield AirFinding((item.name,), f"tf: {words}; allowed: one. Do two nodes publish it?")
        pose = heard.frames.pose(base, frame)
        if pose is None:
            hint = suggest(frame, sorted(heard.frames.frames))
            words = f"tf: nothing connects {base!r} with the frame {frame!r} of {item.topic}{hint}"
            yield AirFinding((item.name,), words, is_fault=False)
            continue
        off, angle = difference(item.base_T_sensor, pose)
        if off > MAX_FRAME_ERROR_M or math.degrees(angle) > MAX_FRAME_ERROR_DEG:
            x, y, z = pose[:3, 3]
            hint = "; upside down: see `upside_down`" if _is_flipped(item, pose) else ""
            yield AirFinding(
                (item.name,),
                f"tf: the frame {frame!r} of {item.topic} is at ({x:.3f}, {y:.3f}, {z:.3f}) m in {base!r},"
                f" {off:.3f} m and {math.degrees(angle):.1f} deg from where the robot's file has it; allowed:"
                f" {MAX_FRAME_ERROR_M:g} m, {MAX_FRAME_ERROR_DEG:g} deg{hint}",
            )


def _is_flipped(item: _Placed, pose: Transform) -> bool:
    """Return whether a lidar's frame is where the robot's file has it, but the other way up.

    Args:
        item: lidar or another sensor, as the robot's file has it.
        pose: base_T_sensor (4, 4) by `tf`.
    """
    if not item.can_flip:
        return False
    off, angle = difference(item.base_T_sensor @ UPRIGHT_T_FLIPPED, pose)
    return off <= MAX_FRAME_ERROR_M and math.degrees(angle) <= MAX_FRAME_ERROR_DEG


def _placed(heard: HeardRobot) -> Iterator[_Placed]:
    """Yield all sensors with their topics and places."""
    robot, spec = heard.robot, heard.spec
    fixed = (
        (robot.range_sensor, spec.lidar.topic),
        (robot.imu, spec.imu.topic),
        (robot.gps, "" if spec.gps is None else spec.gps.topic),
    )
    for sensor, topic in fixed:
        if sensor is not None and topic:
            pose = base_T_frame(robot.urdf_text(), robot.link_of(sensor))
            is_lidar = sensor is robot.range_sensor
            pose = lidar_pose(pose, spec.lidar.upside_down) if is_lidar else pose
            yield _Placed(robot.name_of(sensor), topic, pose, is_lidar)
    for name, (camera, source) in camera_topics(robot, spec).items():
        known = known_camera(camera, mount_of(robot, camera))
        if (carrier := _carrier(heard, known.carrier)) is not None:
            yield _Placed(name, source.topic, carrier @ known.carrier_T_camera)
    arm = None if robot.arm is None else robot.arm_model()
    for name, (deep, topics) in depth_topics(robot, spec).items():
        mount = camera_mount(robot, robot.link_of(deep), arm)
        if (carrier := _carrier(heard, mount.carrier)) is not None:
            yield _Placed(name, topics.topic, carrier @ mount.carrier_T_frame)


def _carrier(heard: HeardRobot, link: str) -> Transform | None:
    """Return base_T_link (4, 4) of a link by the measured joints; None without a reading of the joints."""
    robot, states = heard.robot, heard.topics.states
    if robot.arm is None:
        return base_T_frame(robot.urdf_text(), link)
    if states is None or states.missing or not states.is_fresh:
        return None
    names = [heard.spec.name_of(joint) for joint in robot.arm.joints]
    return robot.arm_model().forward(states.positions(names), link)
