"""Objects that detectors of other packages find, as what may stand on a surface."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.capabilities.depth_camera import DepthImage
from handcart.primitives.detectors.detector import Detection, Detector, checked_detections
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.objects.known_solids import SolidCandidate

from .depth_readings import Standing

MAX_TILT_RAD = math.radians(15.0)
"""Tilt beyond which a detected object has fallen over."""
AROUND_M = 0.02  # of the points of a thing, within which a detection is of it
PLANE = [0, 1, 5]  # x, y and the turn about z among six


class DetectedObject(NamedTuple):
    """Object that a detector found in a picture, with its pose in the base frame and the pose's accuracy."""

    kind: str
    base_T_object: Transform
    """Pose (4, 4) of the object in the base frame."""
    covariance: FloatArray
    """(3, 3) of x, y in [m] and heading in [rad]."""


def detect_all(
    detectors: Mapping[str, Detector], image: DepthImage, camera: CameraModel
) -> list[DetectedObject]:
    """Return the objects that all detectors find in a picture, with their poses in the base frame.

    Raises:
        BrokenDetector: a detector raises, or returns something other than detections.
    """
    return [
        _in_base(found, image.base_T_camera)
        for name, detector in detectors.items()
        for found in checked_detections(name, detector, image, camera)
    ]


def explained(
    found: Sequence[Standing], detected: Sequence[DetectedObject], base_T_surface: Transform
) -> list[Standing]:
    """Return the things on a surface, each with kind and pose from the detections at the thing's place.

    A thing without a detection keeps the kinds that fit its size. Detections of one kind in several pictures
    are fused.

    Args:
        found: things that were seen in the depth pictures.
        detected: detections of all pictures, in the base frame.
        base_T_surface: (4, 4) of the middle of the surface's top.
    """
    surface_T_base = inverse(base_T_surface)
    there = [
        detected_object._replace(base_T_object=surface_T_base @ detected_object.base_T_object)
        for detected_object in detected
    ]
    turn = surface_T_base[:2, :2]
    there = [item._replace(covariance=_turned(item.covariance, turn)) for item in there]
    return [
        standing._replace(may_be=tuple(_candidates(standing, there)) or standing.may_be) for standing in found
    ]


def _in_base(found: Detection, base_T_camera: Transform) -> DetectedObject:
    turn = np.kron(np.eye(2), base_T_camera[:3, :3])
    covariance = turn @ found.covariance @ turn.T
    return DetectedObject(
        found.kind, np.asarray(base_T_camera @ found.camera_T_object), covariance[np.ix_(PLANE, PLANE)]
    )


def _turned(covariance: FloatArray, turn: FloatArray) -> FloatArray:
    by = np.eye(3)
    by[:2, :2] = turn
    return np.asarray(by @ covariance @ by.T)


def _candidates(standing: Standing, detected: Sequence[DetectedObject]) -> Iterator[SolidCandidate]:
    """Yield one candidate of each kind that was detected where a thing stands."""
    flat = standing.cluster.points[:, :2]
    low, high = flat.min(axis=0) - AROUND_M, flat.max(axis=0) + AROUND_M
    here = [
        detected_object
        for detected_object in detected
        if bool(
            (
                (low <= detected_object.base_T_object[:2, 3]) & (detected_object.base_T_object[:2, 3] <= high)
            ).all()
        )
    ]
    for kind in dict.fromkeys(detected_object.kind for detected_object in here):
        yield _fused([detected_object for detected_object in here if detected_object.kind == kind])


def _fused(same: Sequence[DetectedObject]) -> SolidCandidate:
    """Return the mean of detections by their covariances, widened where they disagree by more than those."""
    heading = _heading(same[0])
    values = np.array(
        [
            [*detected_object.base_T_object[:2, 3], heading + _turn(heading, _heading(detected_object))]
            for detected_object in same
        ]
    )
    weights = np.array([np.linalg.inv(detected_object.covariance) for detected_object in same])
    covariance = np.linalg.inv(weights.sum(axis=0))
    mean = covariance @ np.einsum("nij,nj->i", weights, values)
    off = values - mean
    misfit = float(np.einsum("ni,nij,nj->", off, weights, off)) / max(3 * (len(same) - 1), 1)
    upright = all(detected_object.base_T_object[2, 2] > math.cos(MAX_TILT_RAD) for detected_object in same)
    x, y, yaw = mean.tolist()
    pose = np.asarray(transform((x, y, 0.0), (0.0, 0.0, yaw)))
    return SolidCandidate(same[0].kind, pose, covariance * max(1.0, misfit), upright, 0.0)


def _heading(found: DetectedObject) -> float:
    return math.atan2(found.base_T_object[1, 0], found.base_T_object[0, 0])


def _turn(begin: float, end: float) -> float:
    return math.remainder(end - begin, 2.0 * math.pi)
