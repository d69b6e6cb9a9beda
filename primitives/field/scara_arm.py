"""The robot's SCARA arm, by its URDF and its file."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.manipulation.arms.scara import Scara

UPRIGHT_TOLERANCE = 1e-6


def scara_of(robot: Robot) -> Scara:
    """Return lengths, limits and postures of the robot's SCARA arm, whose tip is the frame `hand`.

    Raises:
        Discrepancy: the arm does not have two upright axes and then a slide straight down.
    """
    model, spec = robot.arm_model, robot.spec.arm
    if spec is None or model.dof != 3:
        raise Discrepancy(
            "the arm isn't a SCARA arm; needed: two upright axes and a slide",
            permanent=True,
            cause=causes.UNSUITABLE,
        )
    straight = np.zeros(3)
    shoulder, elbow = (_axis(robot, straight, joint) for joint in (0, 1))
    hand = model.forward(straight)[:3, 3]
    lowered = model.forward(np.array([0.0, 0.0, 0.1]))[:3, 3] - hand
    if np.abs(lowered - np.array([0.0, 0.0, -0.1])).max() > UPRIGHT_TOLERANCE:
        raise Discrepancy(
            "the arm isn't a SCARA arm: its slide doesn't go straight down",
            permanent=True,
            cause=causes.UNSUITABLE,
        )
    along = hand[:2] - shoulder
    low, high = (limit.tolist() for limit in (model.lower, model.upper))
    working = spec.working_deg.get(spec.joints[0])
    narrow = (math.radians(working[0]), math.radians(working[1])) if working else (low[0], high[0])
    home, middle = (robot.spec.posture(name) for name in ("home", "middle"))
    return Scara(
        upper=float(np.hypot(*(elbow - shoulder))),
        fore=float(np.hypot(*(hand[:2] - elbow))),
        mount=(float(shoulder[0]), float(shoulder[1]), float(hand[2]), math.atan2(along[1], along[0])),
        theta1=(low[0], high[0]),
        theta1_working=narrow,
        theta2=(low[1], high[1]),
        slide=(low[2], high[2]),
        stowed=(home[0], home[1]),
        middle=(middle[0], middle[1]),
    )


def _axis(robot: Robot, joints: np.ndarray[tuple[int], np.dtype[np.float64]], joint: int) -> np.ndarray:
    """Return x and y of a joint's upright axis in the base frame, (2,) in [m], in a posture `joints` (n,)."""
    J = robot.arm_model.jacobian(joints)
    hand = robot.arm_model.forward(joints)[:3, 3]
    if np.abs(J[3:, joint] - (0.0, 0.0, 1.0)).max() > UPRIGHT_TOLERANCE:
        raise Discrepancy(
            "the arm isn't a SCARA arm: its joints aren't upright", permanent=True, cause=causes.UNSUITABLE
        )
    # The hand's velocity is z x (hand - axis).
    return np.array([hand[0] - J[1, joint], hand[1] + J[0, joint]])
