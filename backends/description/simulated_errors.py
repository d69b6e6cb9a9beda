"""What a robot's file says of how its simulation errs."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field

from handcart.files.models.model import FileModel

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Percent = Annotated[float, Field(ge=0.0, le=100.0)]


class Errors(FileModel):
    """How a simulated backend errs: sigmas; of the systematic ones, sigmas of what a seed draws once."""

    none: bool = False
    """Nothing errs: whatever else stands here counts as 0, and so do the errors of range sensor and IMU."""
    wheel_radius_percent: NotNegative = 0.2
    tread_percent: NotNegative = 0.5
    slip_percent: NotNegative = 1.0
    joint_repeatability_mrad: NotNegative = 0.15
    encoder_mrad: NotNegative = 0.02
    """Of a joint's reading."""
    opening_mm: NotNegative = 0.05
    """Of the reading of the fingers' opening."""
    image_noise_grey: NotNegative = 3.0
    image_blur_px: NotNegative = 0.7
    camera_mount_mm: NotNegative = 0.0
    """How far the camera sits from the URDF's frame `camera`, along each axis."""
    camera_mount_mrad: NotNegative = 0.0
    """How far it is turned, about each axis."""
    focal_percent: NotNegative = 0.0
    """How far its focal length is off `focal_px`; `calibrated` doesn't change what the camera is."""
    light_gradient: NotNegative = 0.25
    """Share by which the picture's light changes from one side to the other."""
    range_zero_percent: Percent = 0.0
    """Share of a lidar's beams that read 0, each beam and period for itself, as many drivers deliver it."""
    range_nan_percent: Percent = 0.0
    """Share that reads NaN."""
    range_too_close_percent: Percent = 0.0
    """Share that reads -infinity: something is too close (REP 117)."""
    range_own_body_percent: Percent = 0.0
    """Share that returns from the robot's own body, 0.12 m from the lidar."""
    start_mm: NotNegative = 20.0
    start_deg: NotNegative = 1.0
    book_place_mm: NotNegative = 2.0
    """How a person sets a thing onto the tray."""
    book_turn_deg: NotNegative = 1.0
    book_lean_deg: NotNegative = 1.0
    """How far what is let go between neighbours leans aside; on `pybullet` physics tells."""
    hand_force_n: NotNegative = 0.3
    block_place_mm: NotNegative = 0.0
    """How a person sets a thing down elsewhere."""
    block_turn_deg: NotNegative = 0.0
    hand_systematic_mm: NotNegative = 0.0
    """How far off the hand is at most, smoothly from place to place; drawn once."""
    hand_systematic_wave_m: Positive = 1.0
    """From crest to crest of it: about the arm's reach."""
    hand_repeat_mm: NotNegative = 0.0
    """How far off it is from motion to motion, along each axis: sigma."""
    hand_uniform_mm: NotNegative = 0.0
    """The same, spread evenly up to that."""
    swing_yaw_mrad: float = 0.0
    """By which the standing base is turned each time that the arm has swung: casters and tyres give."""
    swing_yaw_sigma_mrad: NotNegative = 0.0
    swing_from_mm: NotNegative = 0.0
    """0: any motion is a swing. Else one that carries something at least that far across the floor."""
    lean_mrad_per_m: NotNegative = 0.0
    """By which the base leans to where the hand is, for each metre that this is off the base's centre."""
    lean_pivot_m: NotNegative = 0.0
    """Height of the point about which it leans."""

    @classmethod
    def nowhere(cls) -> Self:
        """Of a simulation that doesn't err."""
        sizes = set(cls.model_fields) - {"none", "hand_systematic_wave_m"}
        return cls(none=True, **dict.fromkeys(sizes, 0.0))
