"""The parts of the kinematic robot: wheels, arm, gripper, camera, range sensor."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.capabilities.range_sensor import Scan
from handcart.backends.description.robot_file import GripperSpec, RobotFile
from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.simulation.body.fingers import Fingers
from handcart.backends.simulation.body.hand import SimulatedHand
from handcart.backends.simulation.body.simulated_parts import CommandedBase, SimulatedArm, SimulatedGripper
from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.backends.simulation.sensors.disc_ranges import cast_at_discs
from handcart.backends.simulation.sensors.range_faults import RangeFaults
from handcart.backends.simulation.sensors.ranges import cast_rays
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.solids import FloorPlan
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.numerics.arrays import FloatArray

_PRESSES = 2e-4  # [m] of command beyond their position from which the fingers press


class KinematicBase(CommandedBase):
    """Simulated base with two driven wheels, without dynamics.

    Its wheels turn as commanded; their true radii, tread and slip differ from those in the robot's file.
    """

    def __init__(self, robot: RobotFile, seed: int) -> None:
        super().__init__(robot)
        self._rolling = Rolling(robot, seed)

    def advance(self, period: int) -> Pose2:
        """Turn the wheels for a period, and return the motion of the base as if there were no obstacles.

        Args:
            period: number of the period.

        Returns:
            Pose of the base at the end of the period in the base frame at its start.
        """
        speed, turn_rate, _ = self._take_command()
        half = turn_rate * self._drive.tread_m / 2
        left, right = (speed - half) * self._period, (speed + half) * self._period
        self._travel = WheelTravel(self._travel.left + left, self._travel.right + right)
        return self._rolling.motion(left, right, period)


class Rolling:
    """Model of the true motion of a base with two wheels, by the wheels' travel.

    True radii, tread and slip are drawn about the values of the robot's file, with the sigmas of its section
    `errors`.
    """

    def __init__(self, robot: RobotFile, seed: int) -> None:
        """Draw the errors that stay the same for a run."""
        self._seed, errors = seed, robot.errors
        left, right, tread = keyed(seed, "wheels").standard_normal(3)
        self._left_scale = 1.0 + errors.wheel_radius_percent / 100 * left
        self._right_scale = 1.0 + errors.wheel_radius_percent / 100 * right
        self._true_tread = robot.drive.tread_m * (1.0 + errors.tread_percent / 100 * tread)
        self._slip, self._scrub = errors.slip_percent / 100, errors.scrub_percent / 100

    def motion(self, left: float, right: float, period: int) -> Pose2:
        """Return the base's pose at the end of a period in the base frame at its start, without obstacles.

        Args:
            left: travel of the left wheel by its encoder, in [m].
            right: travel of the right wheel by its encoder, in [m].
            period: number of the period, which decides the slip.
        """
        if left == 0.0 and right == 0.0:
            return Pose2(0.0, 0.0, 0.0)
        slips = self._slip * keyed_normal(self._seed, "slip", period, 2)
        left, right = left * self._left_scale * (1.0 - slips[0]), right * self._right_scale * (1.0 - slips[1])
        turn = float((right - left) / self._true_tread)
        if self._scrub > 0.0:
            turn *= 1.0 - self._scrub * float(keyed_normal(self._seed, "scrub", period, 1)[0])
        return _arc(float(left + right) / 2, turn)


def _arc(length: float, turn: float) -> Pose2:
    if abs(turn) < 1e-9:
        return Pose2(length, 0.0, turn)
    return Pose2(length / turn * math.sin(turn), length / turn * (1.0 - math.cos(turn)), turn)


class KinematicArm(SimulatedArm):
    """Simulated arm without dynamics.

    Its joints reach their command within the period, except for contacts and the positioning error
    (`ArmError`).
    """

    STATE: ClassVar = {**SimulatedArm.STATE, "_settled": bool, "_touching": frozenset[tuple[str, str]]}

    def __init__(self, robot: RobotFile, hand: SimulatedHand, seed: int) -> None:
        super().__init__(robot, hand.arm, hand.scene.joints, seed)
        self._hand, self._settled = hand, False
        hand.scene.joints = self._command + self._offset
        self._touching: frozenset[tuple[str, str]] = frozenset()

    @override
    def true_joints(self) -> FloatArray:
        return self._hand.scene.joints

    def _true_force(self) -> FloatArray:
        return self._hand.scene.felt_force()

    def advance(self, period: int, disturbed: bool) -> frozenset[tuple[str, str]]:
        """Move the arm for a period.

        Args:
            period: number of the period.
            disturbed: True if the fingers have moved, or the held thing has changed.

        Returns:
            Pairs of bodies that touch: the name of a part of the robot, and the name of the other body.
        """
        changed = self._begin(period, loaded=self._hand.scene.held is not None)
        self._from = self._command.copy()
        if not changed and not disturbed and self._settled:
            return self._touching
        self._settled = not changed
        self._touching = self._hand.move(self._command + self._offset)
        return self._touching


class KinematicGripper(SimulatedGripper):
    """Simulated gripper whose fingers move at constant speed, and in which a held thing never slips."""

    def __init__(self, spec: GripperSpec, hand: SimulatedHand, period: float, seed: int) -> None:
        super().__init__(spec, hand.scene.robot.errors, hand.scene.width, seed)
        self._step = spec.speed_mm_s / 1e3 * period
        self._scene, self._hand = hand.scene, hand

    @cached_property
    def _fingers(self) -> Fingers:
        return Fingers(self._hand)

    @override
    def true_width(self) -> float:
        return self._scene.width

    def advance(self, period: int) -> bool:
        """Move the fingers in period number `period`; return True if they moved or the held thing changed."""
        self._now = period
        before, held = self._scene.width, self._scene.held
        way = max(-self._step, min(self._step, self._command - before))
        if way != 0.0:
            self._fingers.set_width(before + way)
        after = self._scene.width
        stands = abs(after - before) < 1e-9
        self._pressing = stands and (self._command < after - _PRESSES or self._command <= 0.0)
        return not stands or held is not self._scene.held


class KinematicRangeSensor(SimulatedRangeSensor):
    """Simulated lidar that casts rays in a horizontal section of the world at the lidar's height."""

    def __init__(self, spec: RangeSpec, base_T_sensor: Transform, scene: Scene, seed: int) -> None:
        super().__init__(spec, base_T_sensor, seed, RangeFaults.of(scene.robot.errors))
        self._scene = scene
        height = float(base_T_sensor[2, 3])
        self._plan, self._height = FloorPlan(scene.solids, height, height), height
        self._seen_from: tuple[Pose2, bytes] | None = None
        self._seen = np.empty(0)

    @classmethod
    @override
    def build(cls, site: SensorSite[RangeSpec]) -> Self:
        mount = base_T_frame(site.robot.urdf_text(), site.link)
        return cls(site.spec, mount, site.scene, site.seed)

    def scan_later(self) -> Callable[[], Scan]:
        """Return a function that casts the rays of this period's scan when it is called, and returns the
        scan.
        """
        period, base, time = self._now, self._scene.base, self._scene.time
        if self._last is not None and self._last[0] == period:
            return super().scan_later()
        discs = self._scene.passers.discs(self._height)
        return lambda: self._noisy(self._cast_from(base, time, discs), period)

    def _cast(self) -> FloatArray:
        discs = self._scene.passers.discs(self._height)
        return self._cast_from(self._scene.base, self._scene.time, discs)

    def _cast_from(self, base: Pose2, time: float, discs: FloatArray) -> FloatArray:
        """Return the true ranges (n,) of the beams to solids and passers, in [m].

        Args:
            base: world_T_base.
            time: simulated time, in [s].
            discs: (k, 3) parts of passers: x, y in the world and radius, in [m].
        """
        ranges = self._cast_at_solids(base, time)
        if not len(discs):
            return ranges
        sensor = base.compose(self._mount)
        return np.minimum(ranges, cast_at_discs(discs, sensor, self._angles, self._spec.reach_m))

    def _cast_at_solids(self, base: Pose2, time: float) -> FloatArray:
        """Return the true ranges (n,) to solids in [m], cast again only if the base moved or an obstacle
        appeared or left.
        """
        here = base, self._plan.there(time).tobytes()
        if here != self._seen_from:
            sensor = base.compose(self._mount)
            self._seen = cast_rays(self._plan, sensor, self._angles, time, self._spec.reach_m)
            self._seen_from = here
        return self._seen
