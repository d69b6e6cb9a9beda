"""Fixation: turn the hand until the landmark is seen as planned, and derive the base's error from it.

Hatano et al., "Construction robot systems using mobile manipulators" (2000), sections 2 and 5.2, with the
errors in its equations corrected. The paper's frames here: M0 and M are the base as `planned` and the
actual base, 6 the hand, C the camera, P0 the landmark, B0 the block's goal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse


class StopRule(NamedTuple):
    """Tolerances within which a landmark counts as seen where planned (Hatano et al., 2000, eq. 13)."""

    position: float = 0.0005
    """Tolerance eps1 of x and of y in the camera frame, in [m]."""
    angle: float = 0.0035
    """Tolerance eps2 of the turn about the camera's z, in [rad]."""

    def met(self, planned: Transform, seen: Transform) -> bool:
        """Return True if a landmark is seen within the tolerances of its planned pose in the camera frame.

        Args:
            planned: (4, 4) camera_T_landmark of the plan.
            seen: (4, 4) camera_T_landmark as measured in a picture.
        """
        x, y = (seen[:2, 3] - planned[:2, 3]).tolist()
        return (
            abs(x) <= self.position and abs(y) <= self.position and self.turned(planned, seen) <= self.angle
        )

    def turned(self, planned: Transform, seen: Transform) -> float:
        """Return the size of the turn about the camera's z from the planned to the seen landmark, in [rad].

        Args:
            planned: (4, 4) camera_T_landmark of the plan.
            seen: (4, 4) camera_T_landmark as seen.
        """
        turn = seen[:3, :3] @ planned[:3, :3].T
        return abs(math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]))


PAPER_RULE = StopRule(0.0005, 0.2)
"""Tolerances of the paper; they leave a turn that `PlannedView.travelling_error` takes into account."""


class PlannedView(NamedTuple):
    """Planned poses of hand, camera and landmark for one base pose (relation A of Hatano et al., 2000).

    The landmark's measured pose in the camera then gives the errors of the camera and of the base.

    Frames of the paper: M0 is the planned base and M the actual base, 6 the hand, C the camera, P0 the
    landmark, W the world; 60 and C0 are hand and camera as planned, M~_T_60 is `next_hand`. The equations,
    numbered as in the paper and with its errors corrected, do not depend on the pose in the world:

        (4)   dT_C = C0_T_P0 · C_T_P0⁻¹                                     `camera_error`
        (9)   W_T_M0 · M0_T_60 · 60_T_C0 · dT_C = W_T_M · M_T_60 · 60_T_C0  follows from (1), (2) and (4)
        (11)  dT_M = M0_T_60 · M~_T_60⁻¹                                    `travelling_error`
    """

    base_T_hand: Transform
    """M0_T_60, (4, 4)."""
    hand_T_camera: Transform
    """60_T_C0, (4, 4), by hand-eye calibration."""
    camera_T_landmark: Transform
    """C0_T_P0, (4, 4)."""

    def camera_error(self, camera_T_landmark: Transform) -> Transform:
        """Return planned_T_camera (4, 4), the actual camera pose in the frame of the planned camera.

        This is dT_C of Hatano et al. (2000), eq. 4.

        Args:
            camera_T_landmark: (4, 4) pose of the landmark as seen.
        """
        return self.camera_T_landmark @ inverse(camera_T_landmark)

    def next_hand(self, base_T_hand: Transform, camera_T_landmark: Transform) -> Transform:
        """Return the pose base_T_hand (4, 4) to which the hand moves next, so that the landmark is seen as
        planned.

        M_T_6^(k+1) = M_T_6^k · 60_T_C0 · (dT_C^k)⁻¹ · 60_T_C0⁻¹, with the base M, the hand 6, its planned
        pose 60, the planned camera C0, and the camera's error dT_C (`camera_error`). Errors of the motion
        remain.

        Args:
            base_T_hand: (4, 4) pose of the hand now.
            camera_T_landmark: (4, 4) pose of the landmark as seen from this pose of the hand.
        """
        back = inverse(self.camera_error(camera_T_landmark))
        return base_T_hand @ self.hand_T_camera @ back @ inverse(self.hand_T_camera)

    def travelling_error(self, base_T_hand: Transform, camera_T_landmark: Transform) -> Transform:
        """Return planned_T_base (4, 4), the actual base pose in the frame of the planned base: dT_M of
        eq. 11 (Hatano et al., 2000).

        Eq. 11 is evaluated at the pose to which the hand would move next (`next_hand`). The result therefore
        includes the error that is left after the hand was turned to the landmark.

        Args:
            base_T_hand: (4, 4) pose of the hand now.
            camera_T_landmark: (4, 4) pose of the landmark as seen from this pose of the hand.
        """
        return self.travelling_error_by_posture(self.next_hand(base_T_hand, camera_T_landmark))

    def travelling_error_by_posture(self, base_T_hand: Transform) -> Transform:
        """Return planned_T_base (4, 4), the actual base pose in the frame of the planned base, by the final
        pose of the hand.

        Eq. 11 of Hatano et al. (2000) is used as in their paper, which assumes that no error is left after
        the hand was turned until the landmark appeared as planned. A turn of the base by less than the angle
        tolerance of the `StopRule` is therefore missed; 0.1 rad would displace a placed block by 20 mm.

        Args:
            base_T_hand: (4, 4) final pose of the hand in the base frame.
        """
        return self.base_T_hand @ inverse(base_T_hand)


def placing_posture(planned_T_base: Transform, planned_T_goal: Transform) -> Transform:
    """Return base_T_goal (4, 4), the pose that the arm must reach from the actual base.

    This is eq. 7 of Hatano et al. (2000); for a pose of the hand, it is their eq. 6.

    Args:
        planned_T_base: (4, 4) actual pose of the base in the frame of the planned base, their dT_M.
        planned_T_goal: (4, 4) pose to reach, in the frame of the planned base, their M0_T_B0.
    """
    return inverse(planned_T_base) @ planned_T_goal


def split_goal(world_T_goal: Transform, world_T_base: Transform) -> Transform:
    """Return base_T_goal (4, 4), the pose of a goal in the frame of the base at its planned pose.

    This is M0_T_B0 of Hatano et al. (2000), section 3.

    Args:
        world_T_goal: (4, 4) pose of the goal.
        world_T_base: (4, 4) planned pose of the base.
    """
    return inverse(world_T_base) @ world_T_goal


def on_floor(planned_T_base: Transform) -> Pose2:
    """Return the part of a base's pose error that driving can correct: x, y in [m] and heading in [rad].

    The result is in the frame of the planned base.

    Args:
        planned_T_base: (4, 4) actual pose of the base in the frame of the planned base.
    """
    turn = planned_T_base[:3, :3]
    heading = math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])
    return Pose2(float(planned_T_base[0, 3]), float(planned_T_base[1, 3]), heading)
