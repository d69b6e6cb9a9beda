"""The world that simulated wheels drive through."""

from __future__ import annotations

from backends.kinematic.kinematic_range_sensor import KinematicRangeSensor
from backends.robot_file import RobotFile
from backends.scene.base_contact import move_base
from backends.scene.mounts import base_T_frame
from backends.scene.rolling import Rolling
from backends.scene.scene import build_scene
from backends.scene.world_file import WorldFile
from robotics.geometry.pose2 import Pose2


class DrivenScene:
    """A scene whose base goes where wheels on a test stand would take it, seen by the range sensor.

    It errs as on the kinematic backend: radius of each wheel, tread, slip, ranges. Arms, and persons who
    hand books over, are not simulated.
    """

    def __init__(self, robot: RobotFile, world: WorldFile, seed: int) -> None:
        """Set robot and world up."""
        self.scene = build_scene(robot, world, seed)
        self.range_sensor: KinematicRangeSensor | None = None
        """None where the robot has none."""
        if robot.range_sensor is not None:
            mount = base_T_frame(robot.urdf_text(), "range_sensor")
            self.range_sensor = KinematicRangeSensor(robot.range_sensor, mount, self.scene, seed)
        self._period = robot.period_s
        self._rolling = Rolling(robot, seed)

    def advance(self, left: float, right: float, period: int) -> None:
        """Let a period pass in which the wheels rolled so far, in [m]."""
        self.scene.time = period * self._period
        motion = self._rolling.motion(left, right, period)
        still = motion == Pose2(0.0, 0.0, 0.0)
        touching = frozenset[tuple[str, str]]() if still else move_base(self.scene, motion, None)
        if self.range_sensor is not None:
            self.range_sensor.advance(period)
        self.scene.touch(touching)
