"""Frames of a recorded run."""

from __future__ import annotations

import numpy as np

from handcart.evaluation.viewing.playback.playback import Playback
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .frame import Frame
from .rays import height_of, rays_of

PATH_STEP_M = 0.05  # between two points of the drawn path
PEOPLE_AGE_S = 0.25  # of a scan whose people are drawn
PATH_PERIOD_S = 0.5  # after which the driven path is drawn again


class RecordedFrames:
    """Source of frames (states to draw) of a recorded run at any requested times.

    Each frame contains only the differences to the frame returned before it.
    """

    def __init__(self, playback: Playback) -> None:
        self._playback = playback
        self._height = height_of(playback.scenery.robot.urdf)
        self._begun = False
        self._moving = {
            n: t for n, t in playback.things.items() if len(t.time) > 1 or t.time[0] > playback.start
        }
        self._scan = self._cloud = self._picture = self._action = -1
        self._driven_at = -np.inf
        self._way = _thinned(playback)

    def at(self, time: float) -> Frame:
        """Return the state of the run at a time in [s], as differences to the previous call's frame."""
        playback = self._playback
        moment = playback.at(time)
        driven, restored = self._driven(moment.time)
        changed, self._action = moment.action != self._action, moment.action
        return Frame(
            moment,
            playback.situation(moment.time),
            self._moved(moment.time),
            rays=self._rays(moment.time),
            cloud=self._new_cloud(moment.time),
            picture=self._new_picture(moment.time),
            planned=self._playback.planned(moment.action) if changed else None,
            bumped=self._playback.bumped(moment.action) if changed else None,
            driven=driven,
            restored=restored,
            people=self._people(moment.time),
        )

    def _moved(self, time: float) -> dict[str, FloatArray | None]:
        """Return world_T_thing (7,) of all things at the first call, later only of those that move; None for
        absent ones.
        """
        tracks = self._moving if self._begun else self._playback.things
        self._begun = True
        return {name: track.at(time) for name, track in tracks.items()}

    def _rays(self, time: float) -> FloatArray | None:
        rows = self._playback.rows
        number = self._playback.latest(rows.scan_time, time)
        if number is None or number == self._scan:
            return None
        self._scan = number
        stood = self._playback.at(float(rows.scan_time[number]))
        return rays_of(self._playback.scenery.robot, self._playback.ranges(number), stood.base, self._height)

    def _new_cloud(self, time: float) -> FloatArray | None:
        number = self._playback.latest(self._playback.rows.cloud_time, time)
        if number is None or number == self._cloud:
            return None
        self._cloud = number
        return np.asarray(self._playback.rows.cloud[number], dtype=np.float64)

    def _people(self, time: float) -> FloatArray:
        """Return the rows (p, 7) of the people whom the latest scan showed, as `RecordingPart.people` has
        them.
        """
        times = self._playback.rows.people_time
        end = int(np.searchsorted(times, time + 1e-6))
        if not end or times[end - 1] < time - PEOPLE_AGE_S:
            return np.empty((0, 7))
        begin = int(np.searchsorted(times, times[end - 1]))
        return np.asarray(self._playback.rows.people[begin:end])

    def _new_picture(self, time: float) -> bytes | None:
        """Return the latest picture if it is new; before the first picture was taken, the first."""
        if not self._playback.pictures:
            return None
        number = self._playback.latest(self._playback.rows.picture_time, time) or 0
        if number == self._picture:
            return None
        self._picture = number
        return self._playback.pictures[number]

    def _driven(self, time: float) -> tuple[FloatArray | None, BoolArray]:
        if abs(time - self._driven_at) < PATH_PERIOD_S:
            return None, np.zeros(0, dtype=np.bool_)
        self._driven_at = time
        times, points, back = self._way
        count = int(np.searchsorted(times, time, "right"))
        return points[:count], back[:count]


def _thinned(playback: Playback) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return the driven path at a regular spacing: times (n,) in [s], points (n, 2) in [m], whether restoring
    (n,).
    """
    rows = playback.rows
    known = np.isfinite(rows.truth[:, 0])
    points = np.where(known[:, None], rows.truth[:, :2], rows.pose[:, :2])
    length = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    _, chosen = np.unique(np.floor(length / PATH_STEP_M), return_index=True)
    chosen = np.append(chosen, len(points) - 1)
    return rows.time[chosen], points[chosen], rows.restoring[chosen]
