from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.transform import Transform, apply, difference, inverse, transform
from handcart.robotics.manipulation.suspension.laser_spot import SpotShift, fit_spots, spot_on_wall
from handcart.robotics.manipulation.suspension.suspension_identification import (
    Sighting,
    Swing,
    fit_sightings,
)
from handcart.robotics.manipulation.suspension.suspension_model import (
    SuspensionModel,
    base_motion,
)

DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
TRUE = SuspensionModel(-0.8e-3, -8e-3, 6e-3, 0.12)
REFERENCE = transform((0.25, 0.30, 0.55)) @ DOWN
HAND_T_CAMERA = transform((0.0, 0.06, 0.02))


def hand(x: float, y: float, z: float) -> Transform:
    return transform((x, y, z)) @ DOWN


def spread(rng: np.random.Generator, count: int) -> list[Swing]:
    """Swings all over where the arm reaches."""
    places = rng.uniform((-0.1, 0.3, 0.2), (0.5, 0.7, 0.7), (count, 3))
    return [Swing(hand(*place.tolist()), REFERENCE, n + 1.0) for n, place in enumerate(places)]


def test_small_turns_are_the_papers_first_order() -> None:
    x, y, z, psi, phi = 0.15, 0.69, 0.25, -8e-4, -3e-3
    moved = base_motion(psi, roll=phi) @ hand(x, y, z)
    first_order = (-psi * y, psi * x - phi * z, phi * y)  # eq. 12
    assert moved[:3, 3] - (x, y, z) == pytest.approx(first_order, abs=1e-5)


def test_the_pivots_height_matters() -> None:
    lower, higher = (base_motion(0.0, roll=4e-3, pivot=h) @ hand(0.15, 0.5, 0.25) for h in (0.0, 0.2))
    assert difference(lower, higher)[0] == pytest.approx(0.0008, rel=1e-3)


def test_nothing_moves_at_the_reference() -> None:
    assert TRUE.motion(REFERENCE, REFERENCE, 0) == pytest.approx(np.eye(4), abs=1e-15)


@pytest.mark.parametrize("y", [0.33, 0.42, 0.51, 0.60, 0.69])
def test_a_corrected_posture_arrives(y: float) -> None:
    goal = hand(0.15, y, 0.3)
    assert difference(TRUE.displaced(goal, REFERENCE, 3), goal)[0] > 5e-4
    command = TRUE.corrected(goal, REFERENCE, 3)
    distance, turn = difference(TRUE.displaced(command, REFERENCE, 3), goal)
    assert distance < 1e-8
    assert turn < 1e-8


def sightings_of(rng: np.random.Generator, arm_error: float) -> tuple[list[Sighting], Transform]:
    """Six landmarks of a sheet, each seen from three postures at two heights; and the sheet as guessed."""
    base_T_sheet = transform((0.21, 0.52, 0.25), (0.0, 0.0, 0.05))
    half = 0.03
    square = np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])
    found = []
    for n, (x, y) in enumerate([(x, y) for x in (-0.18, 0.18) for y in (-0.18, 0.0, 0.18)] * 3):
        corners = square + np.array([x, y, 0.0])
        centre = apply(base_T_sheet, corners).mean(axis=0)
        at = centre + np.array([*rng.uniform(-0.03, 0.03, 2), 0.27 + 0.08 * (n % 2)])
        place = hand(*at.tolist()) @ inverse(HAND_T_CAMERA)
        swing = Swing(place, REFERENCE, n + 1.0)
        true = TRUE.displaced(*swing) @ transform(rng.normal(0.0, arm_error, 3).tolist())
        seen = apply(inverse(true @ HAND_T_CAMERA), apply(base_T_sheet, corners))
        rays = seen[:, :2] / seen[:, 2:] + rng.normal(0.0, 0.02 / 800, (4, 2))
        found.append(Sighting(swing, corners, rays))
    guess = base_T_sheet @ transform((0.01, -0.01, 0.005), (0.004, -0.003, 0.02))
    return found, guess


@pytest.mark.parametrize("seed", range(5))
def test_identified_from_landmarks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sightings, guess = sightings_of(rng, 6e-5)
    fit = fit_sightings(sightings, HAND_T_CAMERA, guess, arm_error=6e-5)
    assert (np.abs(np.subtract(fit.model, TRUE)) / np.array(fit.sigmas)).max() < 4.0
    assert fit.model.yaw_per_swing == pytest.approx(TRUE.yaw_per_swing, abs=5e-5)
    assert fit.model.roll_per_m == pytest.approx(TRUE.roll_per_m, abs=1.5e-3)
    assert fit.model.pitch_per_m == pytest.approx(TRUE.pitch_per_m, abs=1.5e-3)
    goal = hand(0.15, 0.69, 0.3)
    corrected = fit.model.corrected(goal, REFERENCE, 5)
    assert difference(TRUE.displaced(goal, REFERENCE, 5), goal)[0] > 0.003
    assert difference(TRUE.displaced(corrected, REFERENCE, 5), goal)[0] < 3e-4


def test_one_landmark_is_not_enough() -> None:
    sightings, guess = sightings_of(np.random.default_rng(1), 0.0)
    with pytest.raises(ValueError, match="can't determine"):
        fit_sightings(sightings[:1], HAND_T_CAMERA, guess)


def shifts(
    rng: np.random.Generator, heading: float, distance: float, world_T_base: Transform
) -> list[SpotShift]:
    """Return the shifts of a laser that points along `heading` at a wall at right angles to it, after 20
    swings.
    """
    start = transform((0.1, 0.05, 0.4), (0.0, 0.0, heading))
    facing = np.eye(4)  # the wall's x to the left, its y up
    facing[:3, 0], facing[:3, 1], facing[:3, 2] = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
    world_T_wall = world_T_base @ start @ transform((distance, 0.0, 0.0)) @ facing
    zero = spot_on_wall(world_T_base, start, world_T_wall)
    found = []
    for swing in spread(rng, 20):
        motion = TRUE.motion(*swing)
        left, up = spot_on_wall(world_T_base @ motion, start, world_T_wall) - zero + rng.normal(0, 5e-4, 2)
        reach = (swing.base_T_hand - REFERENCE)[:2, 3]
        found.append(SpotShift((float(reach[0]), float(reach[1])), swing.swings, float(left), float(up)))
    return found


@pytest.mark.parametrize("seed", range(5))
def test_identified_from_laser_spots(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world_T_base = transform((3.0, -1.0, 0.0), (0.0, 0.0, 0.6))
    ahead, left = (shifts(rng, heading, 2.0, world_T_base) for heading in (0.0, np.pi / 2))
    rates = fit_spots(ahead, left, 2.0)
    assert rates.yaw_per_swing == pytest.approx(TRUE.yaw_per_swing, abs=3e-5)
    assert rates.roll_per_m == pytest.approx(TRUE.roll_per_m, abs=8e-4)
    assert rates.pitch_per_m == pytest.approx(TRUE.pitch_per_m, abs=8e-4)
    only = fit_spots([], left, 2.0)
    assert only.pitch_per_m == 0.0 and only.roll_per_m == rates.roll_per_m


def test_spots_that_tell_nothing() -> None:
    with pytest.raises(ValueError, match="roll_per_m"):
        fit_spots([], [SpotShift((0.1, 0.0), 3.0, 0.01, 0.0)], 2.0)
    with pytest.raises(ValueError, match="meet the wall"):
        spot_on_wall(np.eye(4), np.eye(4), transform((0.0, 0.0, 1.0)))
