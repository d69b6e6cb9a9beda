"""Identification of the base's yaw and tilt from the measurements of a calibration run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from handcart.robotics.clustered_sigmas import clustered_sigmas
from handcart.robotics.geometry.transform import Transform, apply, inverse, transform
from handcart.robotics.manipulation.suspension.suspension_model import SuspensionModel
from handcart.robotics.numerics.arrays import FloatArray

LARGEST_SIGMAS = SuspensionModel(0.5e-3, 2e-3, 2e-3, 0.2)
"""Largest standard deviation with which each parameter counts as measured."""
_START = SuspensionModel(0.0, -5e-3, 5e-3, 0.0)
_STEPS = np.array([1e-3, 1e-2, 1e-2, 0.1])
_BEST = 1e-5  # no measurement is believed to be better [m], [rad]
_BEST_SHARE = 0.1  # nor than a tenth of what is expected of it
_RAY_NOISE = 6e-5  # [rad] of a corner: 0.05 px of a lens of 800 px


class Swing(NamedTuple):
    """Motion of the arm from a reference posture: hand poses before and after, and number of swings
    between.
    """

    base_T_hand: Transform
    """Pose of the hand by the joints, (4, 4)."""
    reference: Transform
    """base_T_hand at the reference posture, (4, 4)."""
    swings: float
    """Number of moves of the arm out and back since the reference posture."""


class Sighting(NamedTuple):
    """Pose of a landmark as measured by the camera after a motion of the arm from the reference posture."""

    swing: Swing
    corners: FloatArray
    """Printed positions of its corners in the frame of the sheet, (4, 3) in [m]."""
    rays: FloatArray
    """Rays (4, 2) to the same corners, x/z and y/z in the camera frame, without lens distortion."""


class SuspensionFit(NamedTuple):
    """Suspension model fitted to sightings of landmarks, with the accuracy of its parameters."""

    model: SuspensionModel
    sigmas: SuspensionModel
    """Standard deviation of each parameter; 0 for those that were given."""
    rms: float
    """Root mean square of the residuals, each in its expected standard deviation; 1 if these are right."""


def fit_sightings(
    sightings: Sequence[Sighting],
    hand_T_camera: Transform,
    base_T_sheet: Transform,
    known: Mapping[str, float] | None = None,
    arm_error: float = 3e-4,
) -> SuspensionFit:
    """Fit a `SuspensionModel` to sightings of the landmarks on one sheet, seen from many postures of the arm.

    The arm's error shifts all four corners of a landmark in the picture together, and hardly changes the
    landmark's size. Sightings are weighted accordingly: without weights, the arm's sideways error would hide
    the measured heights, by which tilt and pivot are distinguished. The pose of the sheet is fitted too, with
    height and tilt, because at the reference posture the base is already tilted by an unknown angle.

    Args:
        sightings: sightings of landmarks, each with the motion of the arm before it.
        hand_T_camera: (4, 4) pose of the camera.
        base_T_sheet: (4, 4) estimated pose of the sheet, accurate to a few centimetres.
        known: parameters that are not fitted, by name, in SI units; None: all are fitted.
        arm_error: standard deviation of the arm's error along each axis, in [m].

    Raises:
        ValueError: the sightings don't determine a parameter.
    """
    seen = np.array([sighting.rays for sighting in sightings])
    weights = np.array([_weight(sighting, hand_T_camera, base_T_sheet, arm_error) for sighting in sightings])

    def residuals(model: SuspensionModel, placed: FloatArray) -> FloatArray:
        sheet = base_T_sheet @ transform(placed[:3].tolist(), placed[3:].tolist())
        rays = [
            _rays(model.displaced(*sighting.swing) @ hand_T_camera, apply(sheet, sighting.corners))
            for sighting in sightings
        ]
        return np.ravel(weights @ (np.array(rays) - seen).reshape(-1, 8, 1))

    return _fit(residuals, len(sightings), np.zeros(6), known or {}, _BEST_SHARE)


def _weight(
    sighting: Sighting, hand_T_camera: Transform, base_T_sheet: Transform, arm_error: float
) -> FloatArray:
    """Return the matrix (8, 8) that makes a sighting's residuals uncorrelated and of unit variance."""
    camera_T_base = inverse(sighting.swing.base_T_hand @ hand_T_camera)
    x, y, z = apply(camera_T_base @ base_T_sheet, sighting.corners).T
    zero = np.zeros(4)
    by_shift = np.stack([np.stack([1 / z, zero, -x / z**2], -1), np.stack([zero, 1 / z, -y / z**2], -1)], 1)
    J = arm_error * by_shift.reshape(8, 3)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(J @ J.T + _RAY_NOISE**2 * np.eye(8))))


def _rays(base_T_camera: Transform, points: FloatArray) -> FloatArray:
    """Return the rays (n, 2), x/z and y/z in the camera frame, to points (n, 3) of the base frame."""
    inside = apply(inverse(base_T_camera), points)
    return np.asarray(inside[:, :2] / inside[:, 2:3])


def _fit(
    residuals: Callable[[SuspensionModel, FloatArray], FloatArray],
    count: int,
    others: FloatArray,
    known: Mapping[str, float],
    best: float = _BEST,
) -> SuspensionFit:
    """Fit the unknown parameters of the model, and some `others`, to `count` measurements by least squares.

    No residual is believed to be smaller than `best`.
    """
    free = [i for i, name in enumerate(SuspensionModel._fields) if name not in known]
    fixed = np.array(_START._replace(**known))

    def model_of(values: FloatArray) -> SuspensionModel:
        full = fixed.copy()
        full[free] = values[: len(free)] * _STEPS[free]
        return SuspensionModel(*full.tolist())

    start = np.concatenate([fixed[free] / _STEPS[free], others])
    if count == 0:
        raise ValueError("no measurements")
    found = least_squares(
        lambda values: residuals(model_of(values), values[len(free) :]),
        start,
        x_scale="jac",
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-14,
    )
    sigmas = np.zeros(4)
    groups = np.repeat(np.arange(count), len(found.fun) // count)
    sigmas[free] = clustered_sigmas(found.jac, found.fun, groups, best)[: len(free)] * _STEPS[free]
    _check(sigmas)
    rms = float(np.sqrt(np.mean(found.fun**2)))
    return SuspensionFit(model_of(found.x), SuspensionModel(*sigmas.tolist()), rms)


def _check(sigmas: FloatArray) -> None:
    vague = [
        name
        for name, sigma, largest in zip(SuspensionModel._fields, sigmas, LARGEST_SIGMAS, strict=True)
        if not sigma <= largest
    ]
    if vague:
        raise ValueError(
            f"the measurements can't determine {', '.join(vague)}: reach further out, in x and y, at several "
            "heights and after several swings, or give what is known"
        )
