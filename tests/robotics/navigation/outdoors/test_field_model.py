"""The outdoor error model: its steps by hand, its derivatives by differences, each noise by its variance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.robotics.geometry.transform import transform
from handcart.robotics.navigation.outdoors import field_model as states
from handcart.robotics.navigation.outdoors.field_model import (
    STATE_SIZE,
    TILT_SIGMA_RAD,
    FieldModel,
    carried,
    corrected,
    fix_forecast,
    level_lever,
)
from handcart.robotics.navigation.outdoors.field_noise import ANY_VEHICLE, REFERENCE_NOISE, FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance

NOISE = FieldNoise(
    scale=0.01,
    slip=0.02,
    slip_length=4.0,
    turn_slip=0.3,
    side_slip=0.05,
    side_slip_length=5.0,
    side_slip_turning=0.0,
    gyro_white=0.06,
    gyro_walk=0.07,
    gyro_bias=0.08,
    gyro_warm_up=0.09,
    gyro_warm_up_time=40.0,
    gyro_scale=0.11,
    gps_drift=0.12,
    gps_drift_time=50.0,
    gps_delay=0.14,
    antenna=(0.0, 0.0, 0.0),
    start_heading=0.15,
)
MODEL = FieldModel(NOISE)
SMALL = st.floats(-0.1, 0.1)


def step_of(
    advance: Advance, given: dict[str, float], new_leg: bool = False, noise: FieldNoise = NOISE
) -> np.ndarray:
    """Mean after a step from the origin, with some states other than zero."""
    mean = np.zeros(STATE_SIZE)
    for name, value in given.items():
        mean[getattr(states, name)] = value
    return FieldModel(noise).step(mean, advance, new_leg)[0]


def drive(forward: float, turn: float = 0.0, drift: float = 0.0, time: float = 1.0) -> Advance:
    return Advance(forward, turn, drift, time, 0.0, 0.0)


def test_start_each_figure_is_its_own_variance() -> None:
    mean, covariance = FieldModel(NOISE._replace(antenna=(0.0, 0.0, 2.0))).start(
        np.array([1.0, 2.0, 3.0]), 0.3
    )
    assert mean.tolist() == [1.0, 2.0, 3.0, *[0.0] * 10]
    drift = math.hypot(0.12, 2.0 * math.radians(0.17))
    sigmas = [0.3, 0.3, 0.15, 0.01, 0.3, 0.02, 0.05, 0.08, 0.09, 0.11, drift, drift, 0.14]
    assert covariance == pytest.approx(np.diag(np.square(sigmas)))


@pytest.mark.parametrize(
    ("advance", "given_states", "way", "course", "heading"),
    [
        (drive(1.0), {"SCALE": 0.25}, 0.8, 0.0, 0.0),
        (drive(-1.0), {"SLIP": 0.25}, -0.8, 0.0, 0.0),
        (drive(1.0), {"SCALE": 0.15, "SLIP": 0.1, "TURN_SLIP": 3.0}, 0.8, 0.0, 0.0),
        (drive(1.0, 0.5), {"TURN_SLIP": 0.25}, 0.8, 0.25, 0.5),
        (drive(1.0, -0.25), {"TURN_SLIP": 0.5}, 0.8, -0.125, -0.25),
        (drive(1.0, 1.2), {"TURN_SLIP": 0.5}, 1.0 / 1.6, 0.6, 1.2),
        (drive(1.0, -1.2), {"TURN_SLIP": 0.5}, 1.0 / 1.6, -0.6, -1.2),
        (drive(9e-4, 0.4), {"TURN_SLIP": 5.0}, 9e-4, 0.2, 0.4),
        (drive(2e-3, 0.4), {"TURN_SLIP": 0.5}, 2e-3 / 1.6, 0.2, 0.4),
        (drive(1.0), {"SCALE": -0.9}, 5.0, 0.0, 0.0),
        (drive(1.0), {"SIDE": 0.1}, 1.0, 0.1, 0.0),
        (drive(1.0, time=2.0), {"BIAS": 0.1}, 1.0, -0.1, -0.2),
        (drive(1.0, time=2.0), {"WARM_UP": -0.1}, 1.0, 0.1, 0.2),
        (drive(1.0, drift=0.3), {}, 1.0, 0.15, 0.3),
        (drive(1.0, 0.5), {"GYRO_SCALE": 0.2}, 1.0, 0.2, 0.4),
        (Advance(1.0, 0.0, 0.0, 3.0, 1.0, 0.0), {"BIAS": 0.1}, 1.0, -0.1, -0.2),
        (Advance(0.2, 0.0, 0.0, 1.0, 1.0, 0.0), {"BIAS": 0.1}, 0.2, 0.0, 0.0),
        (drive(0.0, 0.3), {}, 0.0, 0.15, 0.3),
        (drive(1.0), {"HEADING": 0.7}, 1.0, 0.7, 0.7),
    ],
)
def test_step_each_error_moves_the_pose_as_it_says(
    advance: Advance, given_states: dict[str, float], way: float, course: float, heading: float
) -> None:
    after = step_of(advance, given_states)
    assert after[:3] == pytest.approx([way * math.cos(course), way * math.sin(course), heading], abs=1e-12)


def test_step_in_a_curve_slips_sideways_by_curvature() -> None:
    after = step_of(drive(1.0, 0.5), {}, noise=NOISE._replace(side_slip_turning=0.2))
    assert after[:3] == pytest.approx([math.cos(0.35), math.sin(0.35), 0.5])
    back = step_of(drive(-1.0, 0.5), {}, noise=NOISE._replace(side_slip_turning=0.2))
    assert back[:3] == pytest.approx([-math.cos(0.15), -math.sin(0.15), 0.5])


def test_step_what_changes_with_way_and_time_decays() -> None:
    wrong = dict.fromkeys(("SCALE", "TURN_SLIP", "SLIP", "SIDE", "BIAS", "WARM_UP", "GYRO_SCALE"), 0.1)
    wrong |= {"GPS_X": 0.1, "GPS_Y": 0.1, "DELAY": 0.1}
    after = step_of(drive(-2.0, time=5.0), wrong)[3:]
    kept = [1.0, 1.0, math.exp(-0.5), math.exp(-0.4), 1.0, math.exp(-0.125), 1.0, *[math.exp(-0.1)] * 2, 1.0]
    assert after == pytest.approx(0.1 * np.array(kept))
    assert step_of(drive(-2.0, time=5.0), wrong, new_leg=True)[states.TURN_SLIP] == 0.0


@pytest.mark.parametrize("new_leg", [False, True])
def test_step_adds_the_variance_of_each_figure(new_leg: bool) -> None:
    added = MODEL.step(np.zeros(STATE_SIZE), Advance(-2.0, 0.0, 0.0, 5.0, 1.0, 0.0), new_leg)[2]
    expected = np.zeros(STATE_SIZE)
    expected[states.HEADING] = 0.06**2 * 4.0
    expected[states.TURN_SLIP] = 0.3**2 if new_leg else 0.0
    expected[states.SLIP] = 0.02**2 * (1.0 - math.exp(-1.0))
    expected[states.SIDE] = 0.05**2 * (1.0 - math.exp(-0.8))
    expected[states.BIAS] = 0.07**2 * 5.0
    expected[[states.GPS_X, states.GPS_Y]] = 0.12**2 * (1.0 - math.exp(-0.2))
    assert added == pytest.approx(expected)


def test_step_at_rest_only_what_changes_with_time_does() -> None:
    mean, transition, added = MODEL.step(
        np.full(STATE_SIZE, 0.1), Advance(0.0, 0.0, 0.0, 5.0, 5.0, 0.2), False
    )
    assert mean[:8] == pytest.approx([0.1] * 8)
    kept = np.ones(STATE_SIZE)
    kept[states.WARM_UP], kept[[states.GPS_X, states.GPS_Y]] = math.exp(-0.125), math.exp(-0.1)
    assert transition == pytest.approx(np.diag(kept))
    assert np.flatnonzero(added).tolist() == [states.BIAS, states.GPS_X, states.GPS_Y]


@given(
    st.floats(-1.0, 1.0).filter(lambda way: abs(way) > 0.05),
    st.floats(-0.5, 0.5),
    st.floats(0.0, 0.9),
    st.lists(SMALL, min_size=STATE_SIZE, max_size=STATE_SIZE),
    st.booleans(),
)
def test_transition_is_the_derivative_of_the_step(
    forward: float, bend: float, rest: float, values: list[float], new_leg: bool
) -> None:
    mean = np.array(values)
    mean[states.HEADING] *= 30.0
    mean[[states.TURN_SLIP, states.GYRO_SCALE]] = 0.0  # elsewhere the curve's own derivative is not needed
    advance = Advance(forward, bend * forward, 0.01, 1.0, rest, 0.0)
    transition = MODEL.step(mean, advance, new_leg)[1]
    for state in range(STATE_SIZE):
        aside = np.zeros(STATE_SIZE)
        aside[state] = 1e-6
        change = MODEL.step(mean + aside, advance, new_leg)[0] - MODEL.step(mean - aside, advance, new_leg)[0]
        assert transition[:, state] == pytest.approx(change / 2e-6, abs=1e-6)


@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3), SMALL, SMALL, st.floats(-3.0, 3.0))
def test_lever_is_the_antenna_turned_in_space(
    antenna: list[float], roll: float, pitch: float, heading: float
) -> None:
    turned = transform((0.0, 0.0, 0.0), (roll, pitch, heading))[:3, :3] @ np.array(antenna)
    x, y, z = antenna
    assert level_lever((x, y, z), (roll, pitch), heading) == pytest.approx(turned[:2], abs=1e-12)


@given(st.lists(SMALL, min_size=STATE_SIZE, max_size=STATE_SIZE), st.floats(-3.0, 3.0), st.floats(-2.0, 2.0))
def test_fix_rows_are_the_derivative_of_its_forecast(
    values: list[float], heading: float, speed: float
) -> None:
    def forecast(mean: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        lever = level_lever((0.4, -0.3, 1.0), (0.05, -0.02), float(mean[states.HEADING]))
        return fix_forecast(mean, lever, speed)

    mean = np.array(values)
    mean[states.HEADING], mean[states.DELAY] = heading, 0.0
    rows, expected = forecast(mean)
    lever = level_lever((0.4, -0.3, 1.0), (0.05, -0.02), heading)
    assert expected == pytest.approx(mean[:2] + mean[[states.GPS_X, states.GPS_Y]] + lever)
    for state in range(STATE_SIZE):
        aside = np.zeros(STATE_SIZE)
        aside[state] = 1e-6
        change = forecast(mean + aside)[1] - forecast(mean - aside)[1]
        assert rows[:, state] == pytest.approx(change / 2e-6, abs=1e-6)
    mean[states.DELAY] = 0.5
    late = forecast(mean)[1] - expected
    assert late == pytest.approx([-0.5 * speed * math.cos(heading), -0.5 * speed * math.sin(heading)])


@given(st.integers(0, 50), st.integers(1, 2), st.floats(0.01, 2.0))
def test_a_correction_is_what_information_adds_up_to(seed: int, count: int, variance: float) -> None:
    rng = np.random.default_rng(seed)
    root, rows = rng.normal(size=(5, 5)) + 3.0 * np.eye(5), rng.normal(size=(count, 5))
    mean, residual, covariance = rng.normal(size=5), rng.normal(size=count), root @ root.T
    after = np.linalg.inv(np.linalg.inv(covariance) + rows.T @ rows / variance)
    found, spread = corrected(mean, covariance, rows, residual, variance)
    assert spread == pytest.approx(after, abs=1e-9)
    assert found == pytest.approx(mean + after @ rows.T @ residual / variance, abs=1e-9)
    added = np.arange(5.0)
    assert carried(covariance, root, added) == pytest.approx(root @ covariance @ root.T + np.diag(added))


def test_a_vehicle_of_which_nothing_is_given_is_believed_little() -> None:
    """By what each figure does to what is claimed: a change of one changes tracks of such logs."""
    sigmas = np.sqrt(np.diag(FieldModel(ANY_VEHICLE).start(np.zeros(3), 1.0)[1]))
    degree = math.pi / 180.0
    drift = math.hypot(2.0, TILT_SIGMA_RAD)
    expected = [
        1.0,
        1.0,
        degree,
        0.03,
        0.12,
        0.1,
        3.0 * degree,
        degree,
        0.1 * degree,
        0.02,
        drift,
        drift,
        0.5,
    ]
    assert sigmas == pytest.approx(expected)
    added = FieldModel(ANY_VEHICLE).step(np.zeros(STATE_SIZE), drive(30.0), False)[2]
    assert added[states.HEADING] == pytest.approx((0.2 * degree) ** 2)
    assert added[states.BIAS] == pytest.approx((0.01 * degree) ** 2)
    assert added[states.SLIP] == pytest.approx(0.1**2 * (1.0 - math.exp(-2.0)))
    assert added[states.SIDE] == pytest.approx((3.0 * degree) ** 2 * (1.0 - math.exp(-20.0)))


def test_the_papers_vehicle_errs_as_its_field_test_says() -> None:
    sigmas = np.sqrt(np.diag(FieldModel(REFERENCE_NOISE).start(np.zeros(3), 1.0)[1]))
    degree = math.pi / 180.0
    wheels = [0.002 * math.sqrt(2.0), 0.12, 0.004, 0.8 * degree]
    assert sigmas == pytest.approx(
        [1.0, 1.0, degree, *wheels, 0.3 * degree, 0.1 * degree, 0.005, TILT_SIGMA_RAD, TILT_SIGMA_RAD, 0.0]
    )
    mean, _, added = FieldModel(REFERENCE_NOISE).step(np.zeros(STATE_SIZE), drive(2.0, 1.0), False)
    assert added[states.HEADING] == pytest.approx((0.02 * degree) ** 2)
    assert added[states.BIAS] == pytest.approx((0.001 * degree) ** 2)
    assert added[states.SLIP] == pytest.approx(0.004**2 * (1.0 - math.exp(-2.0)))
    assert added[states.SIDE] == pytest.approx((0.8 * degree) ** 2 * (1.0 - math.exp(-4.0 / 3.0)))
    assert math.atan2(mean[1], mean[0]) == pytest.approx(0.5 + 0.02 * 0.5)
    assert added[states.GPS_X] == pytest.approx(TILT_SIGMA_RAD**2 * (1.0 - math.exp(-2.0 / 300.0)))
