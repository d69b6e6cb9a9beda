"""Detectors of other packages: what they find, and what is said about broken ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from handcart.backends.capabilities.depth_camera import DepthImage
from handcart.primitives.detectors.detector import (
    BrokenDetector,
    Detection,
    Detector,
    checked_detections,
    make_detector,
)
from handcart.robotics.geometry.transform import transform
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.objects.known_solids import KnownSolid

KINDS = {"parcel": KnownSolid("parcel", (0.06, 0.09, 0.08))}
CAMERA = CameraModel(np.array([[100.0, 0, 9.5], [0, 100.0, 7.5], [0, 0, 1]]), np.zeros(5), 20, 16)
IMAGE = DepthImage(np.zeros((16, 20, 3), np.uint8), np.ones((16, 20), np.float32), np.eye(4), 0.0)
GOOD = Detection("parcel", transform((0.0, 0.0, 0.5)), np.eye(6) * 1e-6)


class Saying(Detector):
    """Returns, or raises, what its options say."""

    def detect(self, image: DepthImage, camera: CameraModel) -> Sequence[Detection]:
        answer = self.options["says"]
        if isinstance(answer, Exception):
            raise answer
        return answer  # type: ignore[no-any-return]


def asked(says: Any) -> tuple[Detection, ...]:
    return checked_detections("mine", Saying(KINDS, {"says": says}, Path()), IMAGE, CAMERA)


def with_covariance(covariance: Any) -> list[Detection]:
    return [GOOD._replace(covariance=covariance)]


def test_good_detection_is_passed_on() -> None:
    assert asked([GOOD])[0].kind == "parcel"
    assert asked([]) == ()


@pytest.mark.parametrize(
    ("says", "words"),
    [
        (ValueError("no weights"), "failed: ValueError: no weights"),
        (None, "failed: TypeError"),
        ([(1, 2)], "detection 1: it is a tuple; allowed: Detection"),
        ([GOOD, GOOD._replace(kind="parcle")], "detection 2: unknown kind 'parcle'; did you mean 'parcel'?"),
        ([GOOD._replace(kind=cast(Any, ["parcel"]))], r"unknown kind \['parcel'\]"),
        (
            [GOOD._replace(camera_T_object=np.eye(3))],
            r"camera_T_object has the shape \(3, 3\); allowed: \(4, 4\)",
        ),
        ([GOOD._replace(camera_T_object=2 * np.eye(4))], "has no rotation in its upper left"),
        ([GOOD._replace(camera_T_object=transform((0.0, 0.0, -0.5)))], "it is behind the camera"),
        ([GOOD._replace(camera_T_object=cast(Any, "there"))], "camera_T_object is not an array of numbers"),
        (with_covariance(np.full((6, 6), np.nan)), "covariance has NaN or infinite values"),
        (with_covariance(np.eye(3)), r"covariance has the shape \(3, 3\); allowed: \(6, 6\)"),
        (with_covariance(np.eye(6) + np.eye(6, k=1)), "covariance is not symmetric"),
        (with_covariance(np.zeros((6, 6))), "covariance has the eigenvalue 0; allowed: all above 0"),
    ],
)
def test_broken_answer_is_reported_with_what_is_allowed(says: Any, words: str) -> None:
    with pytest.raises(BrokenDetector, match=f"detector 'mine'.*{words}"):
        asked(says)


def test_unknown_detector_is_reported() -> None:
    with pytest.raises(BrokenDetector, match="unknown detector 'mine'; allowed: none"):
        make_detector("mine", KINDS, {}, Path())
