"""Objects found by detectors of other packages: fused, told apart, and used by LOOK_FOR."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from handcart.backends.capabilities.depth_camera import DepthImage
from handcart.files.errors import FileError
from handcart.primitives.detectors import detector as detector_module
from handcart.primitives.detectors.detector import Detection, Detector
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.looking.detected_objects import DetectedObject, explained
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.geometry.transform import inverse, transform
from handcart.robotics.perception.cameras.camera_model import CameraModel
from tests.primitives.objects.fetching import changed, rig_with
from tests.primitives.objects.looking.test_depth_readings import seen_at, thing, without_tag

OTHER_SIZE = ("size_mm: [60, 90, 80]\n    sigma", "size_mm: [60, 75, 95]\n    sigma")
TOP_M = 0.66  # over which only parcels are
TALL_M = 0.685  # only the one of the other size


class Highest(Detector):
    """Finds the highest thing, by its depths, and calls it by the kind in its options."""

    def detect(self, image: DepthImage, camera: CameraModel) -> Sequence[Detection]:
        points = image.points(camera)
        tops = points[points[:, 2] > TALL_M]
        if self.options.get("breaks") or len(tops) < 30:
            return [None] if self.options.get("breaks") else []  # type: ignore[list-item]
        (x, y), _, _ = outline = cv2.minAreaRect((1e3 * tops[:, :2]).astype(np.float32))
        sides = np.diff(cv2.boxPoints(outline)[:3], axis=0)
        along = sides[np.linalg.norm(sides, axis=1).argmax()]  # its y, of which it has 75 mm
        yaw = math.remainder(math.atan2(along[1], along[0]) - math.pi / 2 - self.options["near"], math.pi)
        pose = transform((x / 1e3, y / 1e3, 0.6), (0.0, 0.0, yaw + self.options["near"]))
        camera_T_object = inverse(image.base_T_camera) @ pose
        return [Detection(self.options["kind"], camera_T_object, np.diag([9e-6, 9e-6, 9e-6, *3 * [1e-4]]))]


def install(monkeypatch: pytest.MonkeyPatch) -> None:
    points = [SimpleNamespace(name="highest", load=lambda: Highest)]
    monkeypatch.setattr(detector_module, "entry_points_of", lambda group: points)


def detected(kind: str, x: float, y: float, sigma: float = 0.003, tilt: float = 0.0) -> DetectedObject:
    return DetectedObject(kind, transform((x, y, 0.0), (tilt, 0.0, 0.0)), sigma**2 * np.eye(3))


def test_detections_of_two_views_are_fused_by_their_covariances() -> None:
    found = [detected("mug", 0.500, 0.0, 0.001), detected("mug", 0.506, 0.0, 0.002)]
    (fused,) = explained([seen_at(0.5, 0.0)], found, np.eye(4))[0].may_be
    assert fused.surface_T_solid[0, 3] == pytest.approx(0.5012)
    assert fused.covariance[0, 0] > 0.8e-6  # as of both, and widened where they disagree
    assert fused.is_upright


def test_two_kinds_at_one_place_stay_two_candidates() -> None:
    found = [detected("mug", 0.5, 0.0), detected("tin", 0.5, 0.0)]
    names = [candidate.name for candidate in explained([seen_at(0.5, 0.0)], found, np.eye(4))[0].may_be]
    assert names == ["mug", "tin"]


def test_detection_elsewhere_leaves_the_decision_to_the_size() -> None:
    (standing,) = explained([seen_at(0.5, 0.0, "parcel")], [detected("mug", 0.7, 0.0)], np.eye(4))
    assert [candidate.name for candidate in standing.may_be] == ["parcel"]


def test_tilted_detection_has_fallen_over() -> None:
    (standing,) = explained([seen_at(0.5, 0.0)], [detected("mug", 0.5, 0.0, tilt=1.0)], np.eye(4))
    assert not standing.may_be[0].is_upright


def test_unknown_detector_is_refused_at_its_line(tmp_path: Path) -> None:
    objects = changed(
        tmp_path, "objects.yaml", ("objects:", "detectors: {highest: {kind: parcel}}\nobjects:")
    )
    with pytest.raises(FileError, match=r"objects\.yaml:\d+:\d+: unknown detector 'highest'"):
        rig_with(objects)


@pytest.mark.slow
def test_look_for_finds_what_a_detector_of_another_package_finds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(monkeypatch)
    rig = without_tag(tmp_path, OTHER_SIZE)  # its size fits no kind
    objects = rig.model.of(Objects)
    options = {"kind": "parcel", "near": math.radians(20.0) - rig.robot.pose.theta}
    objects.detectors = {"highest": Highest(objects.objects.solids(), options, tmp_path)}
    outcome = rig.do(LookFor(object="parcel_1", max_views=2))
    assert isinstance(outcome, Success), outcome
    seen = rig.model.of(Objects).seen("parcel_1")
    assert seen is not None
    assert (seen.pose.x, seen.pose.y) == pytest.approx(thing(rig).pose[:2, 3], abs=0.02)
    objects.detectors = {"highest": Highest({}, {"breaks": True}, tmp_path)}
    outcome = rig.do(LookFor(object="parcel_1", max_views=2))
    assert isinstance(outcome, Fail)
    assert "detector 'highest', detection 1: it is a NoneType" in outcome.reason
