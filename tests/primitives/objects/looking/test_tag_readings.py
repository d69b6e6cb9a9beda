"""Poses of objects by a single tag: of two that look alike, the upright one, as far as the corners allow."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.description.things.printed_tag import UNIT_TAG_CORNERS
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.looking import tag_readings
from handcart.primitives.objects.looking.tag_readings import (
    Located,
    NotUpright,
    ReadTag,
    locate,
    read_objects,
)
from handcart.robotics.geometry.transform import Transform, apply, inverse, transform
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.tag_reader import Tag

FILE = ObjectsFile.model_validate(
    {
        "format": "handcart-objects/1",
        "kinds": {"can": {"size_mm": [60, 60, 100]}},
        "surfaces": {"table": {"x_m": 0, "y_m": 0, "height_m": 0, "size_m": [2, 2]}},
        "objects": {"can": {"kind": "can", "on": "table", "tags": [{"id": 5, "side_mm": 32}]}},
    }
)
CAMERA = CameraModel(np.array([[550.0, 0, 319.5], [0, 550.0, 239.5], [0, 0, 1]]), np.zeros(5), 640, 480)
KIND, SURFACE = FILE.kinds["can"], FILE.surfaces["table"]
NO_PICTURE = np.zeros((480, 640), np.uint8)


def looking_down(slant: float, away: float) -> Transform:
    """The camera's pose `away` from the top of the can, `slant` off the vertical, in the object's frame."""
    middle = np.array([0.0, 0.0, 0.1])
    pose = transform((0.0, 0.0, 0.0), (math.pi - slant, 0.0, 0.0))
    pose[:3, 3] = middle - away * pose[:3, 2]
    return pose


def looks(monkeypatch: pytest.MonkeyPatch, noise_px: float, lies: bool) -> list[ReadTag]:
    """Readings of the can, upright or on its side, in 200 pictures from 0.7 m with errors of its corners."""
    rng, (tag,), found = np.random.default_rng(5), FILE.tags_of("can"), []
    for _ in range(200):
        base_T_camera, heading = looking_down(rng.uniform(0.35, 0.8), 0.7), rng.uniform(-math.pi, math.pi)
        base_T_object = transform((0.0, 0.0, 0.0), (0.0, 0.0, heading))
        if lies:
            base_T_object = base_T_object @ transform((0.0, 0.0, 0.03), (math.pi / 2, 0.0, 0.0))
        corners = apply(tag.on_box((0.06, 0.06, 0.1)), UNIT_TAG_CORNERS * tag.side)
        seen = apply(inverse(base_T_camera) @ base_T_object, corners)
        if lies and (base_T_object[:3, 2] @ (base_T_camera[:3, 3] - base_T_object[:3, 3])) < 0.25:
            continue  # from behind, or so flat that it can't be read
        read = Tag(5, CAMERA.project(seen) + rng.normal(0.0, noise_px, (4, 2)))
        monkeypatch.setattr(tag_readings, "read_tags", lambda *_, read=read, **__: [read])
        found += read_objects(NO_PICTURE, CAMERA, base_T_camera, FILE)
    return found


@pytest.mark.parametrize("noise_px", [0.1, 0.3, 0.5])
def test_upright_object_is_not_taken_for_a_fallen_one(
    monkeypatch: pytest.MonkeyPatch, noise_px: float
) -> None:
    found = [locate([read], KIND, SURFACE) for read in looks(monkeypatch, noise_px, lies=False)]
    assert sum(isinstance(item, Located) for item in found) >= 0.98 * len(found)


@pytest.mark.parametrize("noise_px", [0.1, 0.3, 0.5])
def test_fallen_object_is_not_taken_for_an_upright_one(
    monkeypatch: pytest.MonkeyPatch, noise_px: float
) -> None:
    """Its pose that looks alike would be upright, but nearer to the camera than the surface."""
    found = [locate([read], KIND, SURFACE) for read in looks(monkeypatch, noise_px, lies=True)]
    assert len(found) > 40
    assert all(isinstance(item, NotUpright) for item in found)
