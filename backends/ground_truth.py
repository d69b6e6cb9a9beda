"""The true state of a simulated robot and its world, with which outcomes are compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class Body:
    """A movable body with its true pose and the name of the body that it lies on, for evaluation."""

    support: str
    """Supporting body: "hand", "tray", or the name of another one; "floor" if the body fell."""
    pose: Transform
    """Pose (4, 4) in the frame of its support: the hand frame in the hand, the base frame on the tray,
    otherwise the world frame.
    """


@dataclass(frozen=True)
class GroundTruth:
    """True state of robot and world at one instant; only for evaluation."""

    base: Pose2
    """2D pose world_T_base."""
    joints: FloatArray
    """Joints (n,) of the arm, in [rad] or, if they slide, in [m]."""
    slides: BoolArray
    """Mask (n,), True for joints that slide."""
    width: float
    """Opening between the finger pads, in [m]."""
    bodies: Mapping[str, Body]
    bumps: int
    """Number of the base's collisions so far."""
