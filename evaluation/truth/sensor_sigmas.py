"""How exactly a robot's sensors measure what is held against the truth."""

from __future__ import annotations

SIGMAS = 5.0  # that a measurement may be off beyond a tolerance
BASE_SIGMA_MM, BASE_SIGMA_DEG = 4.0, 0.09  # of a base pose measured by matching scans with the map
JOINT_SIGMA_DEG = 0.01  # encoders and repeatability
SLIDE_SIGMA_MM = 0.2  # the same of joints that slide
OBJECT_SIGMA_MM = 1.5  # of an object seen by the camera
