"""A division is found once for all that ask for the same."""

from __future__ import annotations

import numpy as np

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.driving.standing_room import StandingRoom
from handcart.primitives.seam.kept_divisions import MAX_DIVISIONS, KeptDivisions
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.placement.placements import Placements
from handcart.robotics.navigation.maps.grid_map import from_boxes


class Finder:
    """Counts how often it is asked."""

    def __init__(self) -> None:
        self.asked = 0

    def __call__(self) -> Placements:
        self.asked += 1
        return Placements(np.full((1, 3), float(self.asked)), (), (float(self.asked),))


def test_the_same_is_found_once_and_anything_else_anew() -> None:
    kept, find = KeptDivisions(), Finder()
    first = kept.division((b"robot", b"path"), find)
    assert kept.division((b"robot", b"path"), find) is first
    assert find.asked == 1
    for other in ((b"robot", b"other path"), (b"robotpath",), (b"robo", b"tpath"), (b"robot", b"path", b"")):
        assert kept.division(other, find) is not first
    assert find.asked == 5


def test_only_the_latest_are_kept() -> None:
    kept, find = KeptDivisions(), Finder()
    for number in range(MAX_DIVISIONS + 1):
        kept.division((b"%d" % number,), find)
    kept.division((b"%d" % MAX_DIVISIONS,), find)
    assert find.asked == MAX_DIVISIONS + 1
    kept.division((b"0",), find)
    assert find.asked == MAX_DIVISIONS + 2


def test_a_room_is_another_one_where_anything_in_it_is() -> None:
    spec = load_robot("xarm_cart")
    arm = spec.arm_model()
    wall = [(0.0, 1.5, 0.0, 4.0, 0.1)]
    grid, other = (from_boxes(item, 0.05, (-2.0, -2.0), (4.0, 4.0)) for item in (wall, []))
    here, nothing = Pose2(0.0, -1.0, 0.0), np.empty((0, 2))
    box = Box(transform((0.5, 0.0, 0.5)), (0.1, 0.1, 0.1), "work")
    room = StandingRoom(spec, arm, grid, nothing, here)
    assert StandingRoom(spec, arm, grid, nothing, Pose2(0.003, -1.002, 0.1)).key == room.key
    others = [
        StandingRoom(spec, arm, other, nothing, here),
        StandingRoom(spec, arm, grid, np.array([[1.0, 0.0]]), here),
        StandingRoom(spec, arm, grid, nothing, Pose2(0.0, 1.85, 0.0)),
        StandingRoom(spec, arm, grid, nothing, here, (box,)),
        StandingRoom(spec, arm, grid, nothing, here, avoided=(Pose2(0.5, -0.5, 0.0),)),
    ]
    keys = [item.key for item in (room, *others)]
    assert len(set(keys)) == len(keys)
