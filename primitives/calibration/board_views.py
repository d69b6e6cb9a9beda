"""Camera poses for views of a calibration board."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.perception.landmarks.landmark_pose import facing

MAX_VIEW_TILT_RAD = 0.45  # at most between the optical axis and the vertical
VIEW_TURNS_RAD = (0.0, 0.5, -0.5, 0.25, -0.25)  # about the optical axis
VIEW_DISTANCES_M = (0.24, 0.32, 0.27)  # the nearest fills the picture with a board of 180 by 120 mm
VIEW_OFFSET_M = 0.03  # by which it looks past the board's middle, so that the picture's corners see it too
_GOLDEN = math.pi * (3.0 - math.sqrt(5.0))


def board_views(base_T_board: Transform, count: int, scale: float = 1.0) -> Iterator[Transform]:
    """Yield camera poses base_T_camera (4, 4) from which to view a calibration board for calibration.

    They are on all sides above the board, near and far, with the camera also turned about its axis. The
    directions are spread evenly over a spherical cap (Vogel, "A better way to construct the sunflower head",
    1979). The board is assumed to be level; its heading does not matter.

    Args:
        base_T_board: (4, 4) expected pose of the board.
        count: number of views.
        scale: factor on the distances of all views from the board; 1 for a board of 180 by 120 mm.
    """
    above = transform(base_T_board[:3, 3].tolist())
    for n in range(count):
        around, tilt = n * _GOLDEN, MAX_VIEW_TILT_RAD * math.sqrt((n + 0.5) / count)
        leaned = transform(rpy=(tilt * math.cos(around), tilt * math.sin(around), 0.0))
        far = VIEW_OFFSET_M * scale
        aside = transform((far * math.cos(2.0 * around), far * math.sin(2.0 * around), 0.0))
        turned = transform(rpy=(0.0, 0.0, VIEW_TURNS_RAD[n % len(VIEW_TURNS_RAD)]))
        camera_T_above = facing(scale * VIEW_DISTANCES_M[n % len(VIEW_DISTANCES_M)]) @ leaned @ turned @ aside
        yield np.asarray(above @ inverse(camera_T_above))
