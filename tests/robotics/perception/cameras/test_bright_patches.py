"""Patches by runs of rows are those that OpenCV numbers."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from handcart.robotics.perception.cameras.bright_patches import BrightPatches


@pytest.mark.parametrize("seed", range(40))
def test_patches_are_those_of_opencv_in_its_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    height, width = rng.integers(1, 50, 2).tolist()
    picture = rng.integers(0, 256, (height, width)).astype(np.uint8)
    if seed % 2:
        picture = np.asarray(cv2.GaussianBlur(picture, (5, 5), 1.0), dtype=np.uint8)
    level = int(rng.integers(90, 160))
    bright = (picture >= level).astype(np.uint8)
    count, numbers, stats, _ = cv2.connectedComponentsWithStats(bright, connectivity=4)
    patches = BrightPatches(picture, level)
    assert patches.boxes.tolist() == stats[1:].tolist()
    for number in range(count - 1):
        x, y, across, down, _ = patches.boxes[number].tolist()
        expected = numbers[y : y + down, x : x + across] == number + 1
        assert np.array_equal(patches.mask(number), expected)


def test_rows_that_meet_below_are_one_patch() -> None:
    picture = np.array([[9, 0, 9, 0, 9], [9, 0, 9, 0, 9], [9, 9, 9, 9, 9]], dtype=np.uint8)
    assert BrightPatches(picture, 5).boxes.tolist() == [[0, 0, 5, 3, 11]]
    assert len(BrightPatches(picture[:2], 5).boxes) == 3
    assert len(BrightPatches(picture, 10).boxes) == 0
