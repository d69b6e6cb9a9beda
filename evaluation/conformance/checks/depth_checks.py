"""Checks of depth cameras."""

from __future__ import annotations

import numpy as np

from handcart.backends.capabilities.depth_camera import DepthCamera
from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import steps

from .check import Check, CheckResult

POSE_TOLERANCE = 0.02
"""Maximum difference of any element of (4, 4) between a picture's pose and the pose by measured joints."""


def depth(bench: KitBench, finding: CheckResult) -> None:
    """Check size, depths, focal length, pose and rate of a depth camera's pictures by the robot's file."""
    with bench.rig() as rig:
        camera, spec = needed(rig.backend, DepthCamera), rig.robot.spec.first(DepthCameraSpec)
        assert spec is not None, "the check of capabilities reports it"
        steps(rig.backend, 2)
        image, size = camera.image(), (spec.height_px, spec.width_px)
        finding.expect(image.colour.shape == (*size, 3), f"the colour picture is {image.colour.shape}")
        finding.expect(image.depth.shape == size, f"the depth picture is {image.depth.shape}")
        read = image.depth[np.isfinite(image.depth)]
        finding.expect(len(read) > 0, "no pixel has a reading")
        if len(read):
            finding.expect(float(read.min()) >= spec.range_min_m - 1e-6, f"a depth of {read.min():.3f} m")
            finding.at_most("greatest depth", float(read.max()), spec.reach_m + 1e-6, "m")
        finding.expect(abs(camera.model.K[0, 0] - spec.focal_px) < 1e-6, "another focal length")
        expected = rig.robot.base_T(rig.robot.spec.link_of(spec))
        off = float(np.abs(image.base_T_camera - expected).max())
        finding.at_most("pose in the picture, off", off, POSE_TOLERANCE)
        steps(rig.backend, 1)
        later = camera.image().time - image.time
        finding.at_most("time between two pictures, off", abs(later - rig.backend.period), 1e-6, "s")


CHECKS = (Check("depth camera", "depth within its limits, with the pose and time of the picture", depth),)
