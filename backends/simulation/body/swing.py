"""A standing base that turns a little on its tyres when its loaded arm has moved far (a swing)."""

from __future__ import annotations

import numpy as np

from handcart.backends.description.simulated_errors import Errors
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.numerics.arrays import FloatArray


def is_swing(errors: Errors, loaded: bool, start: FloatArray, end: FloatArray) -> bool:
    """Return True if a finished motion of the arm was a swing.

    A swing is a motion of the loaded arm by at least `errors.swing_from_mm`, in which casters and tyres
    yield, so that the base turns. If that key is 0, every motion is a swing.

    Args:
        errors: errors of the robot's file.
        loaded: True if the hand holds an object.
        start: (2,) x and y of the hand at the start of the motion, in the base frame, in [m].
        end: (2,) x and y of the hand now, in the base frame, in [m].
    """
    least = errors.swing_from_mm / 1e3
    return least == 0.0 or (loaded and float(np.linalg.norm(end - start)) >= least)


def swing_yaw(errors: Errors, seed: int, motion: int) -> float:
    """Return the random angle, in [rad], by which a swing of the arm turns the base to the left.

    A swing is a large motion of the loaded arm, in which casters and tyres yield.

    Args:
        errors: errors of the robot's file.
        seed: seed of the errors.
        motion: number of the arm's motion, which selects the random number.
    """
    spread = keyed(seed, "swing yaw", motion).standard_normal()
    return float(errors.swing_yaw_mrad + errors.swing_yaw_sigma_mrad * spread) / 1e3
