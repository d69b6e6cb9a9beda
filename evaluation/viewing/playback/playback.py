"""Reader of a recorded run: poses, scans and pictures at any time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, Self
from zipfile import BadZipFile

import numpy as np
from pydantic import ValidationError

from handcart.networks.past_runs.past_run import PastAction, PastRun, read_run
from handcart.networks.run_files.run_folder import NoRun, read_file
from handcart.networks.runs.evidence_files import EVIDENCE_FOLDER as EVIDENCE
from handcart.networks.runs.flight_recorder import READINGS_SUFFIX, load_arrays
from handcart.robotics.numerics.arrays import FloatArray

from .part import PLAYBACK_FOLDER, SCENERY_FILE, RecordingPart, metres
from .scenery import Scenery, ThingShape
from .seven import between, on_floor

MAX_SCENERY_BYTES = 64 * 2**20
MAX_ROW_GAP_S = 1.0  # rows farther apart are not interpolated
BUMPED_KEY = "bumped"  # evidence of primitives: where the base hit something that no sensor sees
PLANNED_KEY = "planned"  # evidence of primitives: the path that they plan to drive


class PlaybackMoment(NamedTuple):
    """Recorded state of the robot at one time, with estimated and true pose, joints and running action."""

    time: float
    """Time of the robot, in [s]."""
    world_time: float
    """Time of the world, in [s]; it advances while the run is paused."""
    pose: FloatArray
    """(3,) estimated map_T_base: x, y in [m], heading in [rad]."""
    truth: FloatArray | None
    """(7,) true world_T_base as x, y, z in [m] and unit quaternion w, x, y, z; None where it is unknown."""
    joints: FloatArray
    """(j,) measured joint positions, in [rad] or [m]."""
    width: float
    """Opening of the gripper, in [m]."""
    covariance: FloatArray
    """(3, 3) covariance of the estimated pose, in [m] and [rad]."""
    action: int
    """Number of the running action, from 1; 0 before the first."""
    restoring: bool

    @property
    def base(self) -> FloatArray:
        """Pose world_T_base (7,) of the base, as x, y, z in [m] and a unit quaternion w, x, y, z.

        It is the true pose where this is known, otherwise the estimate.
        """
        return on_floor(self.pose[None])[0] if self.truth is None else self.truth


class ThingTrack(NamedTuple):
    """A movable thing with its poses over time."""

    shape: ThingShape
    time: FloatArray
    """(k,) time of each pose, in [s]; the thing appears at the first."""
    pose: FloatArray
    """(k, 7) world_T_thing as x, y, z in [m] and unit quaternion w, x, y, z, each valid until the next."""

    def at(self, time: float) -> FloatArray | None:
        """Return world_T_thing (7,) at a time in [s]: x, y, z in [m] and a quaternion w, x, y, z.

        None before the thing appears.
        """
        row = int(np.searchsorted(self.time, time, "right")) - 1
        if row < 0:
            return None
        if row + 1 == len(self.time) or self.time[row + 1] - self.time[row] > MAX_ROW_GAP_S:
            return np.asarray(self.pose[row])
        share = (time - self.time[row]) / (self.time[row + 1] - self.time[row])
        return between(self.pose[row], self.pose[row + 1], float(share))


@dataclass(frozen=True)
class Playback:
    """Recorded run, with the robot's state at 10 Hz, scans and particles at 5 Hz, and all camera pictures."""

    run: PastRun
    scenery: Scenery
    rows: RecordingPart
    """All parts joined; their `names` and `shapes` are empty, see `things`."""
    pictures: tuple[bytes, ...]
    """Camera pictures as JPEG, taken at the times `rows.picture_time`."""
    things: Mapping[str, ThingTrack]
    """Movable things by name."""

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read the recording in a run's folder; if the run was killed, its last minute is missing.

        Raises:
            NoRun: the folder holds no run, or no readable recording.
            JournalError: the run's journal is damaged.
        """
        run = read_run(folder)
        content = read_file(folder, f"{PLAYBACK_FOLDER}/{SCENERY_FILE}", MAX_SCENERY_BYTES, missing=True)
        if content is None:
            wrong = "nothing was recorded in it to be played back (an older run, or a campaign's)"
            raise NoRun(folder, f"{wrong}; `handcart run` with the same task and seed records it")
        try:
            scenery = Scenery.model_validate_json(content)
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False)[0]
            where = ".".join(map(str, first["loc"]))
            raise NoRun(folder, f"{PLAYBACK_FOLDER}/{SCENERY_FILE} in it: {where}: {first['msg']}") from None
        parts = _cut([_part(folder, path) for path in sorted((folder / PLAYBACK_FOLDER).glob("[0-9]*.npz"))])
        if not any(len(part.time) for part in parts):
            raise NoRun(folder, "nothing of its motion was recorded: it was killed in its first minute")
        try:
            rows = _joined(parts)
        except ValueError as error:
            raise NoRun(folder, f"the parts in {PLAYBACK_FOLDER} don't belong together: {error}") from None
        pictures = tuple(jpeg for part in parts for jpeg in part.jpegs())
        return cls(run, scenery, rows, pictures, _things(parts, rows.time))

    @property
    def start(self) -> float:
        """Start of the recording, in [s] of the robot's time."""
        return float(self.rows.time[0])

    @property
    def end(self) -> float:
        """End of the recording, in [s] of the robot's time."""
        return float(self.rows.time[-1])

    def at(self, time: float) -> PlaybackMoment:
        """Return the state at a time in [s], interpolated between two recorded rows; a time outside the
        recording gives its start or end.
        """
        rows = self.rows
        a = int(np.clip(np.searchsorted(rows.time, time, "right") - 1, 0, len(rows.time) - 1))
        b = min(a + 1, len(rows.time) - 1)
        span = float(rows.time[b] - rows.time[a])
        share = float(np.clip((time - rows.time[a]) / span, 0.0, 1.0)) if 0.0 < span <= MAX_ROW_GAP_S else 0.0
        turn = (rows.pose[b, 2] - rows.pose[a, 2] + np.pi) % (2.0 * np.pi) - np.pi
        step = np.array([*(rows.pose[b, :2] - rows.pose[a, :2]), turn])
        known = bool(np.isfinite(rows.truth[[a, b]]).all())
        return PlaybackMoment(
            float(np.clip(time, self.start, self.end)),
            float(rows.world_time[a] + share * (rows.world_time[b] - rows.world_time[a])),
            rows.pose[a] + share * step,
            between(rows.truth[a], rows.truth[b], share) if known else None,
            (1.0 - share) * rows.joints[a] + share * rows.joints[b],
            float((1.0 - share) * rows.width[a] + share * rows.width[b]),
            rows.covariance[a],
            int(rows.action[a]),
            bool(rows.restoring[a]),
        )

    def ranges(self, number: int) -> FloatArray:
        """Return the ranges (b,) of a lidar scan, in [m]; infinity without an echo, NaN if invalid.

        Args:
            number: number of the scan in the recording, from 0.
        """
        return metres(self.rows.scan_mm[number])

    def latest(self, times: FloatArray, time: float) -> int | None:
        """Return the index of the last of the times up to `time`; None before the first.

        Args:
            times: (n,) ascending, in [s].
            time: in [s].
        """
        number = int(np.searchsorted(times, time + 1e-9, "right")) - 1
        return None if number < 0 else number

    def action(self, number: int) -> PastAction | None:
        """Return the action with this number; None if the run has no such action."""
        return self._actions.get(number)

    def situation(self, time: float) -> str:
        """Return the situation of the network at a time in [s]; "" before the first situation.

        During an action it is the situation in which the action started.
        """
        times, names = self._situations
        number = self.latest(times, time)
        return "" if number is None else names[number]

    def planned(self, number: int) -> FloatArray:
        """Return the path (n, 2) on the map that an action planned to drive, in [m]; (0, 2) if it planned
        none.
        """
        return self._named(PLANNED_KEY).get(number, np.empty((0, 2)))

    def bumped(self, number: int) -> FloatArray:
        """Return the points (n, 2) on the map, in [m], where the base hit something until the end of an
        action.

        Args:
            number: number of the action, from 1.
        """
        found = [points for n, points in self._named(BUMPED_KEY).items() if n <= number]
        return np.vstack([np.empty((0, 2)), *found])

    @cached_property
    def _actions(self) -> dict[int, PastAction]:
        return {action.number: action for action in self.run.actions}

    @cached_property
    def _situations(self) -> tuple[FloatArray, list[str]]:
        """Start times (n,) of the situations in [s], with the situations' names."""
        times, names = [], []
        for record in self.run.records:
            match record["kind"]:
                case "PLAN" | "END":
                    name = str(record["situation"])
                case "START":
                    name = str(record["action"]["from"])
                case "RESULT" if record["outcome"] == "Success":
                    past = self.action(int(record["n"]))
                    name = "" if past is None else past.target
                case _:
                    continue
            times.append(float(record["t"]))
            names.append(name)
        return np.array(times), names

    def _named(self, name: str) -> dict[int, FloatArray]:
        """Return the points (n, 2) on the map, in [m], with this name, by number of the action that recorded
        them.
        """
        points = {number: arrays.get(name, np.empty(0)) for number, arrays in self._evidence.items()}
        return {n: point for n, point in points.items() if point.ndim == 2 and point.shape[1] == 2}

    @cached_property
    def _evidence(self) -> dict[int, dict[str, FloatArray]]:
        """Planned and bumped points (n, 2) on the map, in [m], of the actions' evidence, by number of the
        action.
        """
        found: dict[int, dict[str, FloatArray]] = {}
        for path in sorted((self.run.folder / EVIDENCE).glob("[0-9]*_*.npz")):
            if path.name.endswith(READINGS_SUFFIX):
                continue
            try:
                arrays = load_arrays(path)
            except (OSError, ValueError, BadZipFile) as error:
                raise NoRun(self.run.folder, f"{EVIDENCE}/{path.name} in it is damaged ({error})") from None
            found[int(path.name.split("_")[0])] = {
                k: arrays[k] for k in (PLANNED_KEY, BUMPED_KEY) if k in arrays
            }
        return found


def _part(folder: Path, path: Path) -> RecordingPart:
    try:
        return RecordingPart.of(load_arrays(path))
    except (OSError, ValueError, BadZipFile) as error:
        raise NoRun(folder, f"{PLAYBACK_FOLDER}/{path.name} in it is damaged ({error})") from None


def _cut(parts: list[RecordingPart]) -> list[RecordingPart]:
    """Return the parts without periods that a continued run repeated: each is cut where a later part
    begins.
    """
    kept, until = [], np.inf
    for part in reversed(parts):
        kept.append(part.before(until))
        if len(part.time):
            until = min(until, float(part.time[0]))
    return kept[::-1]


def _joined(parts: list[RecordingPart]) -> RecordingPart:
    first = parts[0]
    whole = {
        name: np.concatenate([each for part in parts if len(each := getattr(part, name))] or [of_first[:0]])
        for name, of_first in first._asdict().items()
    }
    whole |= {name: getattr(first, name)[:0] for name in ("picture", "picture_end", "names", "shapes")}
    return RecordingPart(**whole)


def _things(parts: list[RecordingPart], times: FloatArray) -> dict[str, ThingTrack]:
    """Return the tracks of all things, given the times (n,) of the rows, in [s]."""
    shapes = {shape.name: shape for part in parts for shape in part.new_shapes()}
    rows: dict[str, list[tuple[FloatArray, FloatArray]]] = {}
    for part in parts:
        order = np.argsort(part.moved_name, kind="stable")
        edges = np.searchsorted(part.moved_name[order], np.arange(len(part.names) + 1))
        for number, name in enumerate(part.names.tolist()):
            chosen = order[edges[number] : edges[number + 1]]
            rows.setdefault(name, []).append((part.moved_time[chosen], part.moved_pose[chosen]))
    return {
        name: _track(
            shapes[name], np.concatenate([t for t, _ in row]), np.concatenate([p for _, p in row]), times
        )
        for name, row in rows.items()
        if name in shapes
    }


def _track(shape: ThingShape, time: FloatArray, pose: FloatArray, times: FloatArray) -> ThingTrack:
    """Return the track of a thing that keeps each pose until the row before the next one.

    Args:
        shape: the thing.
        time: (k,) time of each change of its pose, in [s].
        pose: (k, 7) world_T_thing after each change.
        times: (n,) time of each row, in [s].
    """
    last = times[np.maximum(np.searchsorted(times, time[1:]) - 1, 0)]
    stays = np.flatnonzero(last > time[:-1])
    return ThingTrack(
        shape, np.insert(time, stays + 1, last[stays]), np.insert(pose, stays + 1, pose[stays], axis=0)
    )
