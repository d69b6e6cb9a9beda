"""Decision whether a picture shows a complete landmark."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.perception.landmarks.constellation import Kind
from handcart.robotics.perception.landmarks.landmark import draw_landmark
from handcart.robotics.perception.landmarks.landmark_finder import find_landmarks
from handcart.robotics.perception.landmarks.landmark_in_view import wholly_in_view
from handcart.robotics.perception.landmarks.landmark_pose import facing

from ..conftest import Tabletop

HEIGHT = 0.3
KIND = Kind(0.0, 0.06)


@pytest.mark.parametrize(("direction", "whole"), [((1.0, 0.0), 2), ((-0.3, 0.95), 1)])
def test_landmark_is_found_only_when_well_within_the_picture(
    tabletop: Tabletop, direction: tuple[float, float], whole: int
) -> None:
    camera_T_table, shown, seen = facing(HEIGHT), [], []
    for away in (0.0, 0.055, 0.085, 0.15):
        place = Pose2(away * direction[0], away * direction[1], 0.3)
        table = tabletop.table()
        tabletop.put(table, draw_landmark(), 0.0, 0.0)
        found = find_landmarks(tabletop.photograph(table, camera_T_table @ place.lift(), 1), tabletop.camera)
        shown.append(bool(wholly_in_view(tabletop.camera, inverse(camera_T_table), KIND, [place])[0]))
        seen.append(bool(found))
    assert shown == [True] * whole + [False] * (4 - whole)
    assert seen == [True] * (whole + 1) + [False] * (3 - whole)  # the first that is cut off is found, too


def test_far_beside_and_behind_is_out_of_the_picture(tabletop: Tabletop) -> None:
    places = [Pose2(x, y, 0.0) for x, y in ((0.6, 0.0), (2.0, 1.0), (0.0, -40.0))]
    assert not wholly_in_view(tabletop.camera, inverse(facing(HEIGHT)), KIND, places).any()
    assert not wholly_in_view(tabletop.camera, inverse(facing(-HEIGHT)), KIND, [Pose2(0.0, 0.0, 0.0)]).any()
    assert len(wholly_in_view(tabletop.camera, np.eye(4), KIND, [])) == 0
