"""Simulated errors in a robot's file."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field

from handcart.files.models.model import FileModel

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Percent = Annotated[float, Field(ge=0.0, le=100.0)]


class Errors(FileModel):
    """Standard deviations (sigmas) of the errors of a simulated robot.

    Systematic errors are drawn once in a run, from the seed.
    """

    none: bool = False
    """True for a simulation without errors: all other values count as 0, as do the errors of lidar and
    IMU.
    """
    wheel_radius_percent: NotNegative = 0.2
    tread_percent: NotNegative = 0.5
    slip_percent: NotNegative = 1.0
    scrub_percent: NotNegative = 0.0
    """Slip of each turn, new in each period, of a base that is steered by its sides (skid steering), because
    its wheels slide sideways. With physics the engine computes it.
    """
    sideways_percent: NotNegative = 1.0
    """Relative error of the distance that a `holonomic` base drives sideways, beyond that of its wheels'
    radii.
    """
    joint_repeatability_mrad: NotNegative = 0.15
    encoder_mrad: NotNegative = 0.02
    """Sigma of a joint's reading."""
    opening_mm: NotNegative = 0.05
    """Sigma of the reading of the fingers' opening."""
    image_noise_grey: NotNegative = 3.0
    image_blur_px: NotNegative = 0.7
    camera_mount_mm: NotNegative = 0.0
    """Sigma of the camera's offset from the frame that the URDF states, along each axis."""
    camera_mount_mrad: NotNegative = 0.0
    """Sigma of the camera's rotation from the frame that the URDF states, about each axis."""
    focal_percent: NotNegative = 0.0
    """Sigma of the focal length, relative to `focal_px`; `calibrated` doesn't change the simulated camera."""
    light_gradient: NotNegative = 0.25
    """Share by which the picture's light changes from one side to the other."""
    range_zero_percent: Percent = 0.0
    """Share of a lidar's beams that read 0, each beam and period for itself, as many drivers deliver it."""
    range_nan_percent: Percent = 0.0
    """Share of a lidar's beams that read NaN."""
    range_too_close_percent: Percent = 0.0
    """Share of a lidar's beams that read -infinity, as if something were too close (REP 117)."""
    range_own_body_percent: Percent = 0.0
    """Share of a lidar's beams that return from the robot's own body, 0.12 m from the lidar."""
    start_mm: NotNegative = 20.0
    start_deg: NotNegative = 1.0
    book_place_mm: NotNegative = 2.0
    """Sigma of the place at which a person puts a thing onto the tray."""
    book_turn_deg: NotNegative = 1.0
    book_lean_deg: NotNegative = 1.0
    """Tilt of a thing released between neighbours; with physics the engine computes it."""
    hand_force_n: NotNegative = 0.3
    block_place_mm: NotNegative = 0.0
    """Sigma of the place at which a person puts a thing down elsewhere."""
    block_turn_deg: NotNegative = 0.0
    hand_systematic_mm: NotNegative = 0.0
    """Maximum systematic error of the hand, smooth from place to place; drawn once."""
    hand_systematic_wave_m: Positive = 1.0
    """Wavelength of the systematic error: about the arm's reach."""
    hand_repeat_mm: NotNegative = 0.0
    """Repeatability of the hand from motion to motion, along each axis: sigma."""
    hand_uniform_mm: NotNegative = 0.0
    """Uniform error of the hand from motion to motion: maximum."""
    swing_yaw_mrad: float = 0.0
    """Turn of the resting base to the left with each swing of the arm, caused by casters and tyres."""
    swing_yaw_sigma_mrad: NotNegative = 0.0
    swing_from_mm: NotNegative = 0.0
    """Least distance by which the hand carries a load in a motion that counts as a swing; 0 if any motion of
    the arm does.
    """
    lean_mrad_per_m: NotNegative = 0.0
    """Tilt of the base towards the hand, for each metre of the hand's horizontal distance from its centre."""
    lean_pivot_m: NotNegative = 0.0
    """Height of the point about which the base tilts."""

    @classmethod
    def nowhere(cls) -> Self:
        """Return a description of simulated errors in which the size of each error is zero."""
        sizes = set(cls.model_fields) - {"none", "hand_systematic_wave_m"}
        return cls(none=True, **dict.fromkeys(sizes, 0.0))
