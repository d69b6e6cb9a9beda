"""The drive in a robot's file."""

from __future__ import annotations

import math
from typing import Annotated, Literal, get_args

from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.robotics.navigation.following.drive_limits import DriveLimits

Positive = Annotated[float, Field(gt=0.0)]
DriveKind = Literal["differential", "ackermann", "holonomic"]
ALL_DRIVE_KINDS = frozenset(get_args(DriveKind))


class Drive(FileModel):
    """Kind, wheels, and limits of speed and acceleration of a base's drive, as a robot's file states them."""

    kind: DriveKind = "differential"
    """`differential`: two sides that turn at different speeds, with one wheel or several each (skid
    steering). `ackermann`: a car, which steers with the wheels in front. `holonomic`: mecanum, omni or swerve
    wheels.
    """
    sharpest_per_m: Positive = 0.5
    """`ackermann`: the largest curvature that can be steered."""
    steering_per_m_s: Positive = 0.5
    """`ackermann`: largest change of the curvature by the steering in a second."""
    wheel_radius_m: Positive
    tread_m: Positive
    """Distance between the wheels of both sides; with skid steering the effective one, as measured in a turn.

    `holonomic`: twice the lever arm by which the wheels turn the base: track plus wheelbase for mecanum
    wheels, the diameter of the wheels' circle for others.
    """
    left: str | tuple[str, ...] | None = None
    """The joint that drives the left side, or several, where the URDF doesn't call it `left_wheel`."""
    right: str | tuple[str, ...] | None = None
    """The joint that drives the right side, or several, where the URDF doesn't call it `right_wheel`."""
    top_speed_m_s: Positive
    top_sideways_m_s: Positive | None = None
    """`holonomic`: maximum speed sideways. (default: `top_speed_m_s`)"""
    top_turn_deg_s: Positive
    acceleration_m_s2: Positive
    turn_acceleration_deg_s2: Positive
    lateral_acceleration_m_s2: Positive | None = None
    """Maximum of speed times turn rate. (default: `acceleration_m_s2`, but at least 1 and at most 2)"""
    person_distance_m: Annotated[float, Field(ge=0.0, le=5.0)] = 0.5
    """Distance that MOVE_TO keeps from people where there is room."""

    @property
    def lateral_acceleration(self) -> float:
        """Largest allowed lateral acceleration (speed times turn rate), in [m/s²], from the file or by
        default.
        """
        if self.lateral_acceleration_m_s2 is not None:
            return self.lateral_acceleration_m_s2
        return min(max(self.acceleration_m_s2, 1.0), 2.0)

    @property
    def limits(self) -> DriveLimits:
        """Limits of the base's speeds and accelerations, in SI units."""
        return DriveLimits(
            self.top_speed_m_s,
            math.radians(self.top_turn_deg_s),
            self.acceleration_m_s2,
            math.radians(self.turn_acceleration_deg_s2),
            self.lateral_acceleration,
            self.top_sideways,
        )

    @property
    def top_sideways(self) -> float:
        """Maximum speed sideways, in [m/s]; 0 for a base that cannot drive sideways."""
        if self.kind != "holonomic":
            return 0.0
        return self.top_speed_m_s if self.top_sideways_m_s is None else self.top_sideways_m_s
