"""Errors of wheels, gyros and GNSS on open ground."""

from __future__ import annotations

import math
from typing import NamedTuple

REFERENCE_CURVATURE = 0.5  # [1/m], the curvature at which `FieldNoise.turn_slip` is stated


class FieldNoise(NamedTuple):
    """Noise model of wheels, gyros and GNSS outdoors; errors are given by their standard deviations."""

    roughness: float = math.radians(2.5)
    """Roll and pitch of the base, in [rad]."""
    roughness_length: float = 0.4
    """Distance over which roll and pitch change, in [m]."""
    scale: float = 0.002 * math.sqrt(2.0)
    """Relative error of the wheels' travel, constant all day: slip and calibration."""
    slip: float = 0.004
    """Relative error of the wheels' travel, new every `slip_length`."""
    slip_length: float = 2.0
    """Distance after which the slip is new, in [m]."""
    turn_slip: float = 0.12
    """Relative error of the wheels' travel in a curve of 0.5 / m, proportional to curvature, new on each
    leg.
    """
    side_slip: float = math.radians(0.8)
    """Angle from the heading to the direction of travel, in [rad], new every `side_slip_length`."""
    side_slip_length: float = 3.0
    """Distance after which the side slip is new, in [m]."""
    side_slip_turning: float = 0.02
    """Side slip by curvature, in [rad m]; known, not an error."""
    gyro_white: float = math.radians(0.02)
    """Angle random walk, in [rad/√s]."""
    gyro_walk: float = math.radians(0.001)
    """Random walk of the gyro's bias, in [rad/s/√s]."""
    gyro_bias: float = math.radians(0.3)
    """Bias of the gyro at the start, in [rad/s]."""
    gyro_warm_up: float = math.radians(0.1)
    """Part of the bias that goes away with warming up, in [rad/s]."""
    gyro_warm_up_time: float = 600.0
    """Time constant of the gyro's warm-up, in [s]."""
    gyro_scale: float = 0.005
    """Relative error of a turn measured by the gyro."""
    accelerometer_white: float = 0.05
    """White noise of one accelerometer reading at rest, in [m/s²]."""
    accelerometer_bias: float = 0.02
    """Bias of the accelerometers, in [m/s²]."""
    vibration: float = 0.4
    """White noise of one accelerometer reading while driving, in [m/s²]."""
    gps_period: float = 1.0
    """Time between fixes, in [s]."""
    gps_white: float = 1.0
    """White noise of each fix, an axis, in [m]."""
    gps_drift: float = 0.0
    """Slow error of the fixes, an axis, in [m] (Gauss-Markov)."""
    gps_drift_time: float = 300.0
    """Time over which the slow error of the fixes changes, in [s]."""
    multipath_every: float = math.inf
    """Mean time from the end of one reflection to the next, in [s]."""
    multipath_time: float = 20.0
    """Mean duration of a reflection, in [s]."""
    multipath: float = 8.0
    """Offset of the fixes caused by a reflection, an axis, in [m]."""
    outage_every: float = math.inf
    """Mean time from the end of one outage to the next, in [s]."""
    outage_time: float = 60.0
    """Mean duration of an outage, in [s]."""
    outliers: float = 0.0
    """Share of single fixes that are `outlier` off."""
    outlier: float = 5.0
    """Error of an outlier, an axis, in [m]."""
    jump_every: float = math.inf
    """Mean time between jumps of the fixes to another error, which stays until the next one, in [s]."""
    jump: float = 3.0
    """Change of the fixes' error at a jump, an axis, in [m]."""
    gps_delay: float = 0.0
    """Delay of a fix beyond its time stamp, in [s]."""
    creep: float = 0.0
    """Speed that the wheels report at rest, in [m/s]; each reading has as much noise again."""
    tyre: float = 0.0
    """Relative error of one wheel's travel after a moment of the drive at which its tyre loses air."""
    antenna: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Position of the antenna in the base frame, in [m]; known, not an error."""
    start_heading: float = math.radians(1.0)
    """Error of the robot's heading at the start, in [rad]."""


REFERENCE_NOISE = FieldNoise()
REALISTIC_NOISE = FieldNoise(gps_white=0.5, gps_drift=0.5, gps_drift_time=600.0)
RTK_NOISE = FieldNoise(gps_white=0.01, gps_drift=0.01, gps_drift_time=100.0)
ANY_VEHICLE = FieldNoise(
    scale=0.03,
    slip=0.1,
    slip_length=30.0,
    side_slip=math.radians(3.0),
    gyro_white=math.radians(0.2),
    gyro_walk=math.radians(0.01),
    gyro_bias=math.radians(1.0),
    gyro_scale=0.02,
    gps_drift=2.0,
    gps_delay=0.5,
)
"""Errors of a vehicle if none are given, of a car's speedometer, a cheap gyro and a phone's receiver."""
