"""A base that yields to tracked walkers, in closed loop: it stops before it touches a person."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.tracking.people import People
from handcart.robotics.navigation.tracking.yielding import safe_share

from .test_moving_tracks import CROSSES, GROUP, PAUSES, TURNS_BACK
from .walkers import PERIOD_S, Boxes, scans

RADIUS_M, BODY_M = 0.22, 0.25
ACCELERATION_M_S2 = 1.0
STANDING_M_S = 0.02
BEHIND: dict[str, Any] = {"name": "emil", "waypoints_m": [[-2.5, 0.05], [6.0, 0.05]], "at_end": "stay"}
AROUND_A_CORNER: dict[str, Any] = {
    "name": "fred", "waypoints_m": [[2.0, -2.0], [2.0, 2.5]], "at_end": "stay", "starts_s": 0.8
}  # fmt: skip
CORNER: Boxes = ((1.3, -1.1, 0.6, 0.8),)


class Base:
    """A base that is to drive along x at a speed."""

    def __init__(self, wanted: float) -> None:
        self.x, self.speed, self.was, self._wanted = 0.0, 0.0, 0.0, wanted

    def pose(self) -> Pose2:
        return Pose2(self.x, 0.0, 0.0)

    def drive(self, people: People) -> None:
        """Drive for a period, as fast as it may."""
        wanted = min(self._wanted, self.speed + ACCELERATION_M_S2 * PERIOD_S)
        share = safe_share(self.pose(), (wanted, 0.0), people, RADIUS_M, ACCELERATION_M_S2, PERIOD_S)
        least = max(0.0, self.speed - ACCELERATION_M_S2 * PERIOD_S)
        self.was, self.speed = self.speed, max(least, share * wanted)
        self.x += self.speed * PERIOD_S


@pytest.mark.slow
@pytest.mark.parametrize("wanted", [0.3, 1.0])
@pytest.mark.parametrize(
    ("walks", "boxes"),
    [
        ([PAUSES], ()),
        ([TURNS_BACK], ()),
        ([GROUP], ()),
        ([PAUSES, CROSSES], ()),
        ([BEHIND], ()),
        ([AROUND_A_CORNER], CORNER),
    ],
)
def test_base_stands_before_anybody_touches_it(
    walks: list[dict[str, Any]], boxes: Boxes, wanted: float
) -> None:
    base = Base(wanted)
    for walkers, tracks, _ in scans(walks, 9.0, boxes, base=base.pose):
        away = [np.hypot(*(step.position - (base.x, 0.0))) for _, _, step in walkers.steps()]
        if min(away) < RADIUS_M + BODY_M:  # walkers of this world walk through the base
            assert max(base.speed, base.was) < STANDING_M_S
            break
        base.drive(People.of([*tracks.tracks, *tracks.suspects]))


def test_base_gets_on_after_a_walker_has_crossed() -> None:
    base = Base(1.0)
    for _, tracks, _ in scans([{**CROSSES, "at_end": "stay"}], 9.0, base=base.pose):
        base.drive(People.of([*tracks.tracks, *tracks.suspects]))
    assert base.x > 5.0
