"""Yaw and tilt of the base when the arm moves, and the resulting poses of hand and block.

Hatano et al., "Construction robot systems using mobile manipulators" (2000), section 4. The paper's pitch
is around the base's x axis (its blocks are in a row along y); here that is roll, as in URDF.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse, transform


def base_motion(yaw: float, roll: float = 0.0, pitch: float = 0.0, pivot: float = 0.0) -> Transform:
    """Return the pose (4, 4) of the turned and tilted base in the frame of the base before: dPsi · dPhi of
    eq. 12.

    Args:
        yaw: in [rad].
        roll: in [rad].
        pitch: in [rad].
        pivot: height of the point of the base's z axis around which it tilts, in [m]; the paper omits it.
    """
    lean = transform((0.0, 0.0, pivot)) @ transform(rpy=(roll, pitch, 0.0)) @ transform((0.0, 0.0, -pivot))
    return np.asarray(transform(rpy=(0.0, 0.0, yaw)) @ lean)


class SuspensionModel(NamedTuple):
    """A base that turns by the same angle each time the arm swings out, and sinks on the arm's side.

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
        """Return reference_T_base (4, 4), the motion of the base since the reference: dPsi · dPhi of eq. 12.

        Args:
            base_T_hand: (4, 4) pose of the hand now.
            reference: (4, 4) base_T_hand at the reference.
            swings: number of moves of the arm out and back in between.
        """
        lean = self._lean(base_T_hand) @ inverse(self._lean(reference))
        return np.asarray(base_motion(self.yaw_per_swing * swings) @ lean)

    def displaced(self, base_T_hand: Transform, reference: Transform, swings: float) -> Transform:
        """Return the true pose (4, 4) of the hand in the base frame at a reference (eq. 12).

        Args:
            base_T_hand: (4, 4) pose of the hand by the arm's joints.
            reference: (4, 4) base_T_hand at the reference.
            swings: number of moves of the arm out and back since the reference.
        """
        return self.motion(base_T_hand, reference, swings) @ base_T_hand

    def corrected(self, base_T_goal: Transform, reference: Transform, swings: float) -> Transform:
        """Return the base_T_hand (4, 4) to command so that the hand truly comes to a goal.

        Args:
            base_T_goal: (4, 4) pose of the goal in the base frame at the reference.
            reference: (4, 4) base_T_hand at the reference.
            swings: number of moves of the arm out and back since the reference.
        """
        command = base_T_goal
        for _ in range(_REFINEMENTS):
            command = inverse(self.motion(command, reference, swings)) @ base_T_goal
        return command

    def _lean(self, base_T_hand: Transform) -> Transform:
        x, y = base_T_hand[:2, 3].tolist()
        return base_motion(0.0, self.roll_per_m * y, self.pitch_per_m * x, self.pivot)


_REFINEMENTS = 3  # each makes the error a hundred times smaller
