"""Yaw and tilt of the base when the arm moves, and the resulting poses of hand and block.

Hatano et al., "Construction robot systems using mobile manipulators" (2000), section 4. The paper's pitch
is around the base's x axis (its blocks are in a row along y); here that is roll, as in URDF.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse, transform


def base_motion(yaw: float, roll: float = 0.0, pitch: float = 0.0, pivot: float = 0.0) -> Transform:
    """Return the pose (4, 4) of a turned and tilted base in the frame that it had before: dPsi · dPhi of
    Hatano et al. (2000), eq. 12.

    Args:
        yaw: turn about the vertical, in [rad].
        roll: tilt about the base's x axis, in [rad].
        pitch: tilt about the base's y axis, in [rad].
        pivot: height of the point of the base's z axis around which it tilts, in [m]; 0 in the paper.
    """
    lean = transform((0.0, 0.0, pivot)) @ transform(rpy=(roll, pitch, 0.0)) @ transform((0.0, 0.0, -pivot))
    return np.asarray(transform(rpy=(0.0, 0.0, yaw)) @ lean)


class SuspensionModel(NamedTuple):
    """Model of a base on springs that moves with its arm; it yaws with each swing and tilts towards the arm.

    The yaw is the same for each move of the arm out and back.

    The tilt is in proportion to the hand's distance from the base's z axis: the centre of gravity moves with
    the arm, and the springs are linear.
    """

    yaw_per_swing: float
    """Yaw of the base for each move of the arm out and back, in [rad], positive to the left."""
    roll_per_m: float
    """Roll in [rad/m] for each metre of the hand to the left (+y); negative if the left side sinks."""
    pitch_per_m: float
    """Pitch in [rad/m] for each metre of the hand to the front (+x); positive if the front sinks."""
    pivot: float
    """Height of the tilt axes above the base frame's origin, in [m]."""

    def motion(self, base_T_hand: Transform, reference: Transform, swings: float) -> Transform:
        """Return reference_T_base (4, 4), the motion of the base since the reference posture: the yaw dPsi,
        then the tilt dPhi (Hatano et al., 2000, eq. 12).

        Args:
            base_T_hand: (4, 4) pose of the hand now.
            reference: (4, 4) base_T_hand at the reference posture.
            swings: number of moves of the arm out and back since the reference posture.
        """
        lean = self._lean(base_T_hand) @ inverse(self._lean(reference))
        return np.asarray(base_motion(self.yaw_per_swing * swings) @ lean)

    def displaced(self, base_T_hand: Transform, reference: Transform, swings: float) -> Transform:
        """Return the true pose (4, 4) of the hand in the frame that the base had at the reference posture.

        Args:
            base_T_hand: (4, 4) pose of the hand by the arm's joints.
            reference: (4, 4) base_T_hand at the reference posture.
            swings: number of moves of the arm out and back since the reference posture.
        """
        return self.motion(base_T_hand, reference, swings) @ base_T_hand

    def corrected(self, base_T_goal: Transform, reference: Transform, swings: float) -> Transform:
        """Return the base_T_hand (4, 4) to command so that the hand reaches a goal although its load tilts
        and turns the base.

        Args:
            base_T_goal: (4, 4) pose of the goal in the frame that the base had at the reference posture.
            reference: (4, 4) base_T_hand at the reference posture.
            swings: number of moves of the arm out and back since the reference posture.
        """
        command = base_T_goal
        for _ in range(_REFINEMENTS):
            command = inverse(self.motion(command, reference, swings)) @ base_T_goal
        return command

    def _lean(self, base_T_hand: Transform) -> Transform:
        x, y = base_T_hand[:2, 3].tolist()
        return base_motion(0.0, self.roll_per_m * y, self.pitch_per_m * x, self.pivot)


_REFINEMENTS = 3  # each makes the error a hundred times smaller
