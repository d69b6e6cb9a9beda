"""Checks of geometry: ranges and frames agree with the world."""

from __future__ import annotations

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.localization.lidar import Lidar
from handcart.backends.simulation.sensors.ranges import cast_rays
from handcart.backends.simulation.world.solids import FloorPlan
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import move_joints, steps
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.trials.rig import Rig
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .check import Check, CheckResult

SCAN_COUNT = 30
RANGE_MM, OUTLIERS = 10.0, 0.05  # beams further off may be a share of all: those that graze an edge
MIN_RETURN_RATIO = 0.5  # of the scans in which a beam returns, at least, to be compared
POSE_TOLERANCE = 1e-6  # [m] and of matrix elements


def ranges(bench: KitBench, finding: CheckResult) -> None:
    """Check that the lidar's ranges agree with the simulated world around the sensor's true pose."""
    with bench.rig() as rig:
        backend, spec = rig.backend, rig.robot.spec.range_sensor
        scene, lidar = simulated_world(backend), Lidar(needed(backend, RangeSensor), rig.robot.spec)
        if scene is None or spec is None:
            raise Skipped("no world's true shape is known")
        taken = []
        for _ in range(SCAN_COUNT):
            steps(backend, 1)
            taken.append(lidar.scan().ranges)
        read = np.array(taken)
        true = _true_ranges(rig, spec.reach_m)
        read[~np.isfinite(read)] = np.nan
        met = np.isfinite(true) & (np.isfinite(read).mean(axis=0) >= MIN_RETURN_RATIO)
        off = 1e3 * np.abs(np.nanmean(read[:, met], axis=0) - true[met])
        grazing = float((off > RANGE_MM).mean())
        finding.at_most("median of beams off", float(np.median(off)), 0.5 * RANGE_MM, "mm")
        finding.at_most(f"beams more than {RANGE_MM:g} mm off", grazing, OUTLIERS)
        enough = met.sum() > 0.3 * np.isfinite(true).sum()
        finding.expect(enough, f"only {met.sum()} of {len(true)} beams meet anything")
        spread = 1e3 * float(np.median(np.nanstd(read[:, met], axis=0)))
        finding.at_most("noise", spread, 1.5 * spec.sigma_mm + 1.0, "mm")


def _true_ranges(rig: Rig, reach: float) -> FloatArray:
    scene, scan = simulated_world(rig.backend), rig.robot.range_sensor.scan()
    assert scene is not None, "the check has asked for it"
    height = rig.robot.range_sensor_height
    plan = FloorPlan(scene.solids, height, height)
    return cast_rays(plan, scene.base.compose(scan.base_T_sensor), scan.angles, scene.time, reach)


def frames(bench: KitBench, finding: CheckResult) -> None:
    """Check that the hand is where the URDF's kinematics put it."""
    with bench.rig() as rig:
        backend, spec = rig.backend, rig.robot.spec
        scene, arm = simulated_world(backend), needed(backend, Arm)
        if scene is None or spec.arm is None:
            raise Skipped("nothing is simulated")
        model = ArmModel(spec.urdf_text(), spec.arm.joints)
        link_pose = getattr(backend, "link_pose", scene.world_T)
        worst = 0.0
        for bend in (0.0, 0.1, -0.2):
            goal = np.clip(np.array(spec.posture("home")) + bend, model.lower, model.upper)
            move_joints(backend, arm, goal)
            expected = scene.world_T_base @ model.forward(scene.joints)
            worst = max(worst, float(np.abs(link_pose("hand") - expected).max()))
        finding.at_most("hand off", worst, POSE_TOLERANCE)


CHECKS = (
    Check("ranges", "ranges agree with the world", ranges),
    Check("frames", "the hand is where the URDF's kinematics put it", frames),
)
