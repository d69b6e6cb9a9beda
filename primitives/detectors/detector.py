"""Detectors of objects that other packages add by entry points of the group `handcart.detectors`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from handcart.backends.capabilities.depth_camera import DepthImage
from handcart.files.errors import InputError
from handcart.files.plugins import entry_points_of
from handcart.files.suggest import suggest
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.objects.known_solids import KnownSolid

DETECTORS_GROUP = "handcart.detectors"
ROTATION_TOLERANCE = 1e-3
MAX_SHOWN = 200  # characters of a detector's own message


class Detection(NamedTuple):
    """Object that a detector found in a picture: its kind, and its pose in the camera's frame with
    covariance.
    """

    kind: str
    """Name of the kind in the file of objects."""
    camera_T_object: Transform
    """Pose (4, 4) in the optical frame; the object's origin is in the middle of its foot, z up."""
    covariance: FloatArray
    """(6, 6) of the position in [m] and the rotation vector in [rad], both in the optical frame."""


class Detector(ABC):
    """Base class of detectors that find objects in colour and depth pictures.

    A subclass is made available by an entry point. One instance is created for a run, with the options that
    the file of objects has under the entry point's name, and called with each depth picture.
    """

    def __init__(self, kinds: Mapping[str, KnownSolid], options: Mapping[str, Any], folder: Path) -> None:
        """Create a detector of the known kinds.

        Args:
            kinds: kinds of the file of objects, by their names.
            options: values under the detector's name in that file.
            folder: folder of that file; relative paths in options are below it.

        Raises:
            ValueError: an option is missing or wrong; the message says what is allowed.
        """
        self.kinds, self.options, self.folder = kinds, options, folder

    @abstractmethod
    def detect(self, image: DepthImage, camera: CameraModel) -> Sequence[Detection]:
        """Return the objects that the detector finds in a picture; empty if it finds none.

        Args:
            image: colour and depth picture.
            camera: model of the camera that took the picture.
        """


class BrokenDetector(InputError):
    """Error of a detector that can't be built, raises, or returns something other than detections."""


def make_detector(
    name: str, kinds: Mapping[str, KnownSolid], options: Mapping[str, Any], folder: Path
) -> Detector:
    """Return an installed detector by the name of its entry point.

    Args:
        name: name of the entry point.
        kinds: shapes of the kinds of objects to find, by name.
        options: options of the detector in the file of objects.
        folder: folder of that file.

    Raises:
        BrokenDetector: the detector is not installed, can't be imported, or refuses its options.
    """
    points = {point.name: point for point in entry_points_of(DETECTORS_GROUP)}
    if name not in points:
        allowed = suggest(name, points) if points else "; allowed: none, no package with one is installed"
        raise BrokenDetector(f"unknown detector {name!r}{allowed}")
    try:
        kind = points[name].load()
        made = kind(kinds, options, folder)
    except Exception as error:  # a package of others may raise anything
        raise BrokenDetector(f"detector {name!r} can't be used: {_words(error)}") from error
    if not isinstance(made, Detector):
        raise BrokenDetector(f"detector {name!r} is a {type(made).__name__}; allowed: a subclass of Detector")
    return made


def checked_detections(
    name: str, detector: Detector, image: DepthImage, camera: CameraModel
) -> tuple[Detection, ...]:
    """Return the objects that a detector finds in a picture, after checking its answer.

    Raises:
        BrokenDetector: the detector raises an error, or its answer has a wrong type, shape or value.
    """
    try:
        found = tuple(detector.detect(image, camera))
    except Exception as error:
        raise BrokenDetector(f"detector {name!r} failed: {_words(error)}") from error
    for number, detection in enumerate(found):
        wrong = _wrong(detection, detector.kinds)
        if wrong:
            raise BrokenDetector(f"detector {name!r}, detection {number + 1}: {wrong}")
    return tuple(
        Detection(
            detection.kind,
            np.asarray(detection.camera_T_object, float),
            np.asarray(detection.covariance, float),
        )
        for detection in found
    )


def _wrong(found: object, kinds: Mapping[str, KnownSolid]) -> str:
    """Return what is wrong with a detection, and what is allowed; "" for nothing."""
    if not isinstance(found, Detection):
        return f"it is a {type(found).__name__}; allowed: Detection"
    if not isinstance(found.kind, str) or found.kind not in kinds:
        return f"unknown kind {found.kind!r}{suggest(str(found.kind), kinds)}"
    for what, value, shape in (
        ("camera_T_object", found.camera_T_object, (4, 4)),
        ("covariance", found.covariance, (6, 6)),
    ):
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            return f"{what} is not an array of numbers; allowed: {shape}"
        if array.shape != shape:
            return f"{what} has the shape {array.shape}; allowed: {shape}"
        if not np.isfinite(array).all():
            return f"{what} has NaN or infinite values; allowed: finite numbers"
    return _wrong_pose(np.asarray(found.camera_T_object)) or _wrong_covariance(np.asarray(found.covariance))


def _wrong_pose(pose: Transform) -> str:
    turn = pose[:3, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(turn) < 0.0:
        return "camera_T_object has no rotation in its upper left; allowed: an orthonormal right-handed one"
    if np.abs(pose[3] - (0.0, 0.0, 0.0, 1.0)).max() > ROTATION_TOLERANCE:
        return "camera_T_object has another last row than 0 0 0 1; allowed: a transform"
    return "" if pose[2, 3] > 0.0 else "it is behind the camera; allowed: a positive depth"


def _wrong_covariance(covariance: FloatArray) -> str:
    if not np.allclose(covariance, covariance.T, rtol=1e-6, atol=1e-12):
        return "covariance is not symmetric; allowed: a symmetric matrix"
    least = float(np.linalg.eigvalsh(covariance).min())
    return "" if least > 0.0 else f"covariance has the eigenvalue {least:.3g}; allowed: all above 0"


def _words(error: Exception) -> str:
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return text if len(text) <= MAX_SHOWN else f"{text[:MAX_SHOWN]}..."
