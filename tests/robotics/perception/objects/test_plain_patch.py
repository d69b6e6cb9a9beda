"""Things on a plain surface in noisy pictures, and plain pictures in which there are none."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.objects.plain_patch import PictureEdges, is_plain

CAMERA = CameraModel(
    np.array([[400.0, 0.0, 160.0], [0.0, 400.0, 120.0], [0.0, 0.0, 1.0]]), np.zeros(5), 320, 240
)
PART = np.array([[-0.1, -0.1, 1.0], [0.1, -0.1, 1.0], [0.1, 0.1, 1.0], [-0.1, 0.1, 1.0]])  # 80 x 80 px


def picture(noise: float, contrast: float = 0.0, alike_px: float = 0.0, seed: int = 0) -> ByteArray:
    """Return a picture of a thing of 30 x 30 px on a surface, with noise that may be alike in neighbours."""
    grain = np.random.default_rng(seed).standard_normal((240, 320))
    if alike_px:
        grain = np.asarray(cv2.GaussianBlur(grain, (0, 0), alike_px), dtype=np.float64)
        grain /= grain.std()
    levels = np.full((240, 320), 110.0) + np.linspace(0.0, 40.0, 320)  # light from one side
    levels[105:135, 145:175] += contrast
    return np.clip(np.rint(cv2.GaussianBlur(levels, (0, 0), 0.7) + noise * grain), 0, 255).astype(np.uint8)


def looks_plain(image: ByteArray) -> bool:
    return is_plain(PictureEdges.of_picture(image).share(CAMERA, np.eye(4), PART))


@pytest.mark.parametrize(
    ("noise", "contrast"), [(0.0, 10.0), (3.0, 10.0), (3.0, -10.0), (5.0, 20.0), (8.0, 20.0), (12.0, 30.0)]
)
def test_thing_fainter_with_less_noise_is_seen(noise: float, contrast: float) -> None:
    assert not any(looks_plain(picture(noise, contrast, seed=seed)) for seed in range(10))


@pytest.mark.parametrize("alike_px", [0.0, 1.0])
@pytest.mark.parametrize("noise", [0.0, 1.0, 3.0, 5.0, 8.0])
def test_noise_alone_is_no_thing(noise: float, alike_px: float) -> None:
    """The noise of compressed pictures is alike in neighbouring pixels."""
    assert all(looks_plain(picture(noise, alike_px=alike_px, seed=seed)) for seed in range(20))


def test_noise_is_that_of_the_calm_parts_of_a_picture() -> None:
    image = picture(3.0)
    plain = PictureEdges.of_picture(image).noise
    image[:, 160:] = np.where(np.indices((240, 160)).sum(axis=0) // 8 % 2, 40, 220)  # half of it is a pattern
    assert PictureEdges.of_picture(image).noise == pytest.approx(plain, rel=0.15)


def test_part_beyond_the_picture_is_not_plain() -> None:
    assert (
        PictureEdges.of_picture(picture(0.0)).share(CAMERA, np.eye(4), PART + np.array([0.4, 0.0, 0.0]))
        is None
    )
    assert not is_plain(None)
