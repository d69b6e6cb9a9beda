"""How exactly a robot's sensors measure what is compared with the ground truth.

Every claim has two limits, and both hold: a tolerance and `SIGMAS` of the claimed uncertainty; a fixed limit
that doesn't grow with that. These sigmas are of the sensors, not of a claim: limits made of them are fixed.
"""

from __future__ import annotations

SIGMAS = 5.0  # that a measurement may be off beyond a tolerance
BASE_SIGMA_MM, BASE_SIGMA_DEG = 4.0, 0.09  # of a base pose measured by matching scans with the map
JOINT_SIGMA_DEG = 0.01  # encoders and repeatability
SLIDE_SIGMA_MM = 0.2  # the same of joints that slide
OBJECT_SIGMA_MM = 1.5  # of an object seen by the camera
