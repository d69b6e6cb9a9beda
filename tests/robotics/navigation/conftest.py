"""A small library floor, the real maps, and a range sensor that sees exact walls."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes, from_ros
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

MAPS = Path(__file__).resolve().parents[3] / "../shared/maps"
Boxes = list[tuple[float, float, float, float, float]]
ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)
LIBRARY_SIZE = (12.03, 9.02)


def real_map(picture: str, origin: float, free_thresh: float) -> GridMap:
    image: Any = cv2.imread(str(MAPS / picture), cv2.IMREAD_UNCHANGED)
    if image is None:
        pytest.skip(f"the map {picture} is not there: it lies outside the repository")
    return from_ros(image, 0.05, (origin, origin), 0.65, free_thresh)


@pytest.fixture(scope="session")
def depot() -> GridMap:
    return real_map("depot/depot.pgm", 0.0, 0.25)


@pytest.fixture(scope="session")
def turtlebot3() -> GridMap:
    return real_map("turtlebot3/map.pgm", -10.0, 0.196)


@pytest.fixture(scope="session")
def library_boxes() -> Boxes:
    """Walls, five rows of shelves, two tables, a pillar; nothing aligned to cells of 5 cm."""
    w, h = LIBRARY_SIZE
    walls = [(w / 2, y, 0.0, w, 0.2) for y in (0.07, h - 0.09)] + [
        (x, h / 2, 0.0, 0.2, h) for x in (0.06, w - 0.08)
    ]
    shelves = [(1.93 + 1.97 * k, 5.91, 0.0, 0.52, 3.01) for k in range(5)]
    tables = [(3.02, 2.03, 0.3, 1.2, 0.7), (8.27, 2.21, -0.5, 1.4, 0.8)]
    return [*walls, *shelves, *tables, (5.68, 1.37, 0.8, 0.4, 0.4), (11.33, 3.0, 0.0, 1.0, 0.4)]


@pytest.fixture(scope="session")
def library(library_boxes: Boxes) -> GridMap:
    return from_boxes(library_boxes, 0.05, (0.0, 0.0), LIBRARY_SIZE)


@pytest.fixture(scope="session")
def library_field(library: GridMap) -> LikelihoodField:
    return LikelihoodField(library)


def scan_points(boxes: Boxes, pose: Pose2, rng: np.random.Generator, sigma: float = 0.01) -> np.ndarray:
    """End points (n, 2) in the base frame of a noisy scan, up to 12 m."""
    seen = box_ranges(boxes, pose, ANGLES)
    seen = seen + rng.normal(0.0, sigma, len(seen))
    hit = seen < 12.0
    points: np.ndarray = seen[hit, None] * np.column_stack([np.cos(ANGLES[hit]), np.sin(ANGLES[hit])])
    return points


@pytest.fixture(scope="session")
def scan() -> Callable[..., np.ndarray]:
    return scan_points
