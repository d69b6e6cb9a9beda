"""Standard deviations of the sensors whose measurements are compared with the ground truth.

Every claim has two limits, and both must hold: a tolerance plus `LIMIT_SIGMAS` times the claimed
uncertainty, and a fixed limit that does not grow with the claim. The values here describe sensors, not
claims: limits made of them are fixed.
"""

from __future__ import annotations

LIMIT_SIGMAS = 5.0  # allowed measurement error beyond a tolerance
BASE_SIGMA_MM, BASE_SIGMA_DEG = 4.0, 0.09  # of a base pose measured by matching scans with the map
JOINT_SIGMA_DEG = 0.01  # encoders and repeatability
SLIDE_SIGMA_MM = 0.2  # encoders and repeatability of prismatic joints
OBJECT_SIGMA_MM = 1.5  # of an object seen by the camera
