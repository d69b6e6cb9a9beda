"""People and carts that a drive tracks now for observers and for the localization."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from handcart.robotics.navigation.tracking.moving_tracks import BODY_MARGIN_M, MIN_BODY_M, BodyTrack

if TYPE_CHECKING:
    from .localization.localization import Localization

MAX_PEOPLE_AGE_S = 0.3  # of tracks that are shown


class SeenPeople:
    """Latest tracks of people and carts near the base, for observers and for the localization."""

    def __init__(self) -> None:
        """Start without people."""
        self._at, self._tracks = -np.inf, list[BodyTrack]()

    def show(
        self,
        time: float,
        tracks: Sequence[BodyTrack],
        localization: Localization,
        suspects: Sequence[BodyTrack] = (),
    ) -> None:
        """Store the people and carts tracked in a scan; the readings on them are excluded when the next scan
        is matched with the map.

        Args:
            time: time of the scan, in [s].
            tracks: tracks of all people and carts.
            localization: estimate of the base's pose.
            suspects: bodies that may be people, which are excluded from matching as well.
        """
        self._at, self._tracks = time, list(tracks)
        bodies = [*tracks, *suspects]
        discs = [(*body.position, max(body.radius, MIN_BODY_M) + BODY_MARGIN_M) for body in bodies]
        localization.crowd.put(np.array(discs).reshape(-1, 3))

    def now(self, time: float) -> Sequence[BodyTrack]:
        """Return the latest tracks of people if they are at most 0.3 s old at `time` [s]; otherwise an empty
        sequence.
        """
        return self._tracks if time <= self._at + MAX_PEOPLE_AGE_S else ()
