"""A SCARA arm on a base that may be tilted: two turning joints, then a slide straight down.

Ohki et al. (2012), section V, with a Jacobian that is the derivative of the tip: in the printed one, J11
has a cosine where a sine belongs, and J21 the second link's length where the first one's belongs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import rotations
from handcart.robotics.numerics.arrays import FloatArray

OFFSET_DIRECTIONS = 36  # of the base from the arm that are tried
ROOM_STEP = 0.005  # [m]: resolution of the reported distance


class Scara(NamedTuple):
    """Model of a SCARA arm with a lowerable slide, by its lengths, joint limits and named postures.

    Joints are theta1 from the arm's x axis to the first link, theta2 from the first link to the second, and
    the distance by which the slide is lowered. Angles are positive anticlockwise, seen from above. The elbow
    is bent to the right, so theta2 is negative.
    """

    upper: float = 0.395
    """Length of the first link, in [m]."""
    fore: float = 0.610
    """Length of the second link, in [m]."""
    mount: tuple[float, float, float, float] = (0.0, 0.0, 0.6, -math.pi / 2.0)
    """Pose base_T_arm, x, y of the shoulder and z of the tip with the slide raised, in [m], and yaw in [rad].

    By default the arm's x axis points to the right of the base.
    """
    theta1: tuple[float, float] = (0.0, math.radians(150.0))
    """Limits of theta1 on the way to a target, in [rad]."""
    theta1_working: tuple[float, float] = (0.0, math.radians(90.0))
    """Limits of theta1 at a target, in [rad]; beyond, the first link reaches the sensor on the body's top."""
    theta2: tuple[float, float] = (math.radians(-160.0), math.radians(-8.0))
    """Limits of theta2, in [rad], because a straight arm cannot move its tip along itself."""
    slide: tuple[float, float] = (0.0, 0.6)
    """Limits of the distance by which the slide is lowered, in [m]."""
    stowed: tuple[float, float] = (math.radians(150.0), math.radians(-15.0))
    """theta1 and theta2 of the stowed arm, in [rad]."""
    middle: tuple[float, float] = (math.radians(120.0), math.radians(-60.0))
    """theta1 and theta2 between stowed and any target that keep the tip away from the wheels, in [rad]."""

    def tip(self, q: FloatArray) -> FloatArray:
        """Return the position of the tip.

        Args:
            q: joints, (2,) angles in [rad], or (3,) with the slide in [m].

        Returns:
            (2,) in the arm's plane, from the first joint, in [m].
        """
        one, both = float(q[0]), float(q[0] + q[1])
        return np.array(
            [
                self.upper * math.cos(one) + self.fore * math.cos(both),
                self.upper * math.sin(one) + self.fore * math.sin(both),
            ]
        )

    def jacobian(self, q: FloatArray) -> FloatArray:
        """Return the Jacobian of the tip by theta1 and theta2: eq. 5 of Ohki et al. (2012), corrected.

        Args:
            q: (2,) joint angles in [rad].

        Returns:
            (2, 2) in [m/rad], in the arm's plane.
        """
        one, both = float(q[0]), float(q[0] + q[1])
        across, along = self.fore * math.sin(both), self.fore * math.cos(both)
        return np.array(
            [
                [-self.upper * math.sin(one) - across, -across],
                [self.upper * math.cos(one) + along, along],
            ]
        )

    def inverse(self, target: FloatArray) -> FloatArray | None:
        """Return the angles theta1 and theta2 that hold the tip at a position.

        Args:
            target: (2,) in the arm's plane, from the first joint, in [m].

        Returns:
            (2,) in [rad]; None if the position is out of reach or needs angles beyond the joint limits.
        """
        x, y = float(target[0]), float(target[1])
        cos = (x * x + y * y - self.upper**2 - self.fore**2) / (2.0 * self.upper * self.fore)
        if abs(cos) > 1.0:
            return None
        bend = -math.acos(cos)
        one = math.atan2(y, x) - math.atan2(
            self.fore * math.sin(bend), self.upper + self.fore * math.cos(bend)
        )
        q = np.array([math.remainder(one, 2.0 * math.pi), bend])
        return q if self.within(q, working=True) else None

    def within(self, q: FloatArray, working: bool = False) -> bool:
        """Return True if joint angles keep the limits.

        Args:
            q: (2,) in [rad].
            working: True for positions where the arm works: theta1 has to keep the narrower `theta1_working`.
        """
        low, high = self.theta1_working if working else self.theta1
        inside = low - 1e-9 <= q[0] <= high + 1e-9
        return bool(inside and self.theta2[0] - 1e-9 <= q[1] <= self.theta2[1] + 1e-9)

    def base_tip(self, q: FloatArray) -> FloatArray:
        """Return the position (3,) of the tip in the base frame, in [m].

        Args:
            q: (3,) angles of the two arm joints in [rad], and travel of the slide in [m].
        """
        x, y, z, yaw = self.mount
        plane = Pose2(x, y, yaw).apply(self.tip(q)[None]).reshape(2)
        return np.array([plane[0], plane[1], z - float(q[2])])

    def room_beside(self, point: FloatArray, turn: float) -> float:
        """Return the largest distance of the base from its planned pose at which the tip still reaches a
        point, in [m].

        The base may be displaced in any direction and turned by up to `turn`. The distance is found in steps
        of `ROOM_STEP`.

        Args:
            point: (2,) in the frame of the planned base, in [m].
            turn: largest turn of the base to either side, in [rad].
        """
        x, y, _, yaw = self.mount
        arm_T_base = Pose2(x, y, yaw).inverse()
        turned = np.vstack([Pose2(0.0, 0.0, angle).apply(point[None]) for angle in (-turn, 0.0, turn)])
        angles = np.linspace(0.0, 2.0 * math.pi, OFFSET_DIRECTIONS, endpoint=False)
        ways = np.column_stack([np.cos(angles), np.sin(angles)])
        room = 0.0
        while all(
            self.inverse(place) is not None
            for seen in turned
            for place in arm_T_base.apply(seen + (room + ROOM_STEP) * ways)
        ):
            room += ROOM_STEP
        return room


def world_to_base(pose: Pose2, tilt: tuple[float, float], point: FloatArray) -> FloatArray:
    """Transform a point (3,) from the world into the frame of a tilted base on the ground, in [m].

    The tilt matters: on a base that is tilted by 2.5 degrees, a slide that is lowered by 0.4 m ends 17 mm
    away from the point that is vertically below its upper end.

    Args:
        pose: world_T_base on the ground.
        tilt: roll and pitch of the base, in [rad].
        point: (3,) in the world, in [m].
    """
    away = np.asarray(point, dtype=np.float64) - (pose.x, pose.y, 0.0)
    seen: FloatArray = _world_R_base(pose, tilt).T @ away
    return seen


def base_to_world(pose: Pose2, tilt: tuple[float, float], point: FloatArray) -> FloatArray:
    """Transform a point (3,) from the frame of a tilted base on the ground into the world, in [m].

    Args:
        pose: world_T_base on the ground.
        tilt: roll and pitch of the base, in [rad].
        point: (3,) in the base frame, in [m].
    """
    out: FloatArray = _world_R_base(pose, tilt) @ np.asarray(point, dtype=np.float64) + (pose.x, pose.y, 0.0)
    return out


def _world_R_base(pose: Pose2, tilt: tuple[float, float]) -> FloatArray:
    roll, pitch, yaw = (np.array([angle]) for angle in (*tilt, pose.theta))
    return np.asarray(rotations(roll, pitch, yaw)[0])
