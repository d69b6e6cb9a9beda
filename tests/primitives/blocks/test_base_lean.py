"""What accelerometers feel beside the suspension's model."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.primitives.blocks.base_lean import felt_tilt, unmodelled_lean

from .stacking import at_the_wall

REACH = (0.1, 0.5)


def leans(pose: np.ndarray) -> tuple[float, float]:
    return math.atan2(pose[2, 1], pose[2, 2]), -math.asin(pose[2, 0])


def test_what_is_felt_far_beside_the_model_is_taken_and_noise_hardly() -> None:
    with at_the_wall() as rig:
        known, imu = rig.robot.spec.suspension.model, rig.robot.spec.imu
        assert imu is not None
        modelled = np.array([known.roll_per_m * REACH[1], known.pitch_per_m * REACH[0]])

        def beside(off: np.ndarray) -> np.ndarray:
            roll, pitch = (modelled + off).tolist()
            return unmodelled_lean(rig.robot, (roll, pitch), REACH)

        sigma = imu.accelerometer_sigma_m_s2 / 9.81 / math.sqrt(20)
        far = beside(np.array([1e-3, -2e-3]))
        assert leans(far) == pytest.approx((1e-3, -2e-3), rel=sigma**2 / 1e-6 + 1e-6)
        assert beside(np.full(2, 0.9 * sigma)) == pytest.approx(np.eye(4))
        rng = np.random.default_rng(0)
        left = np.array([leans(beside(each)) for each in sigma * rng.standard_normal((500, 2))])
        assert np.sqrt((left**2).mean()) < 0.7 * sigma


def test_it_leans_about_the_pivot() -> None:
    with at_the_wall() as rig:
        pivot = rig.robot.spec.suspension.model.pivot
        moved = unmodelled_lean(rig.robot, (0.02, 0.01), REACH)
        assert (moved @ (0.0, 0.0, pivot, 1.0))[:3] == pytest.approx((0.0, 0.0, pivot))
        assert np.linalg.norm((moved @ (0.0, 0.0, pivot + 1.0, 1.0))[:2]) > 0.01


def test_tilt_is_averaged_over_a_second() -> None:
    with at_the_wall() as rig:
        robot, noise = rig.robot, 0.005 / 9.81
        felt = []
        for _ in range(8):
            periods, count = felt_tilt(robot), 0
            try:
                while True:
                    next(periods)
                    robot.step()
                    count += 1
            except StopIteration as end:
                felt.append(end.value)
            assert count * robot.period == pytest.approx(1.0)
        assert np.std(np.array(felt), axis=0).max() < 0.5 * noise
