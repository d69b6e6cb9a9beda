"""Where the base stands for a surface: of the places within reach, the one that leaves most headings."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.knowledge.place import Place
from handcart.primitives.objects.knowledge import surface_places
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.knowledge.surface_places import MAX_COMPARED, standing_place
from handcart.robotics.geometry.pose2 import Pose2

from ..fetching import rig_with

HOME = Place(x_m=1.0, y_m=1.0, heading_deg=0.0)


@pytest.mark.parametrize(
    ("missed", "looked", "number"),
    [([0], 1, 0), ([2, 1, 0], 3, 2), ([3, 1, 2, 1, 3], MAX_COMPARED, 1)],
)
def test_place_with_most_headings_is_taken(
    monkeypatch: pytest.MonkeyPatch, missed: list[int], looked: int, number: int
) -> None:
    rig = rig_with()
    bases: list[Pose2] = []

    def headings(*arguments: object) -> int:
        base = arguments[3]
        assert isinstance(base, Pose2)
        if base not in bases:
            bases.append(base)
        return missed[bases.index(base)]

    monkeypatch.setattr(surface_places, "_reaches", lambda *_: True)
    monkeypatch.setattr(surface_places, "_headings_missed", headings)
    file = rig.model.of(Objects).objects
    place = standing_place(load_robot("librarian"), rig.model.map, file, "table_a", [HOME])
    assert len(bases) == looked
    assert (place.x_m, place.y_m) == tuple(bases[number])[:2]


def test_hand_comes_down_in_every_heading_before_the_tables() -> None:
    """The librarian's wrist turns all around."""
    rig = rig_with()
    stands, file = rig.model.of(Objects).stands, rig.model.of(Objects).objects
    robot = load_robot("librarian")
    for name, stand in stands.items():
        surface = file.surfaces[name]
        point = np.append(
            surface_places._work(file, name)[0], surface.height_m + surface_places.HIGHEST_TIP_M
        )
        assert surface_places._headings_missed(robot, robot.arm_model(), surface, stand.pose, point) == 0
