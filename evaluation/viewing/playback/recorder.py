"""Recorder of a run for `handcart view` and `handcart export`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.thing import Thing
from handcart.evaluation.judging.survey import simulated_world
from handcart.files.whole_file import write_whole
from handcart.networks.events.events import Ended, Event, Restoring, Started
from handcart.networks.events.run_end import RunEnd
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.task.preparing import Prepared
from handcart.robotics.navigation.tracking.people import People
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .part import PART_FILE_FORMAT, PLAYBACK_FOLDER, SCENERY_FILE, SHAPES_ADAPTER, millimetres
from .scenery import PosedBox, ThingShape, scenery_of, thing_shapes
from .seven import sevens

ROW_PERIOD_S, SCAN_PERIOD_S, PICTURE_PERIOD_S = (
    0.1,
    0.2,
    0.5,
)  # [s] of the robot's time between rows, scans and clouds, pictures
PART_DURATION_S = 60.0
MAX_CLOUD_PARTICLES = 256  # recorded particles of a cloud
JPEG_QUALITY = 80  # of pictures
ROW_COLUMNS = ("time", "world_time", "pose", "truth", "joints", "width", "covariance", "action", "restoring")
_SOON = 1e-6  # [s]


class PlaybackRecorder(RunObserver):
    """Observer that records a run for playback in the folder `playback` of the run.

    It writes `scenery.json` at the start and parts `00001.npz`, ... during the run. They hold measurements,
    estimates and, in simulation, the true state: see `RecordingPart`. The recorder reads only data that the
    run reads anyway, so it does not change the run. A killed process loses the last part. An error, for
    example a full disk, ends the recording but not the run.
    """

    def __init__(self) -> None:
        self._folder: Path | None = None
        self._scene: Scene | None = None
        self._action, self._restoring = 0, False
        self.lost: str | None = None
        """Reason why the recording ended early; None while it is complete."""
        self._part = self._changes = 0
        self._riding: Sequence[Thing] = ()
        self._due = self._scan_due = self._picture_due = 0.0
        self._begun = 0.0
        self._shown: ByteArray | None = None
        self._at: dict[str, bytes] = {}
        self._clear()

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Write the run's constant data (robot, map, places, solid bodies), and start to record the run.

        If an interrupted run is continued, its recording up to the interruption is kept.
        """
        self._scene = simulated_world(prepared.backend)
        backend = prepared.backend
        self._arm, self._gripper = backend.get(Arm), backend.get(Gripper)  # type: ignore[type-abstract]
        self._range = prepared.robot.lidar
        self._changes = -1
        self._due = self._scan_due = self._picture_due = self._begun = prepared.robot.time
        folder = run_dir / PLAYBACK_FOLDER
        try:
            folder.mkdir(exist_ok=True)
            self._part = len(list(folder.glob("[0-9]*.npz")))
            scenery = scenery_of(prepared, self._scene)
            write_whole(folder / SCENERY_FILE, scenery.model_dump_json(), sync=False)
            self._folder = folder
        except Exception as error:
            self._lose(error)
        self._note(prepared.robot)

    @override
    def period(self, robot: Robot) -> None:
        if robot.time >= self._due - _SOON:
            self._note(robot)

    @override
    def event(self, event: Event) -> None:
        match event:
            case Started(number=number):
                self._action, self._restoring = number, False
            case Restoring():
                self._restoring = True
            case Ended():
                self._restoring = False
            case _:
                pass

    @override
    def end(self) -> None:
        self._write()
        self._folder = None

    def figures(self, end: RunEnd) -> Mapping[str, Any]:
        """Return the run's summary entry `playback_lost`, the reason why the recording is incomplete; empty
        if it is complete.
        """
        return {} if self.lost is None else {"playback_lost": self.lost}

    # One row

    def _note(self, robot: Robot) -> None:
        if self._folder is None or (self._rows["time"] and robot.time <= self._rows["time"][-1]):
            return
        self._due = robot.time + ROW_PERIOD_S
        # A sensor fault is reported by the primitives that need the reading.
        with suppress(Exception):
            self._take(robot)
        if robot.time - self._begun >= PART_DURATION_S:
            self._write()
            self._begun = robot.time

    def _take(self, robot: Robot) -> None:
        joints = np.empty(0) if self._arm is None else self._arm.joints()
        width = 0.0 if self._gripper is None else self._gripper.width()
        scene, localization = self._scene, robot.localization
        row = {
            "time": robot.time,
            "world_time": robot.time if scene is None else scene.time,
            "pose": tuple(robot.pose),
            "truth": np.full((4, 4), np.nan) if scene is None else scene.world_T_base,
            "joints": joints,
            "width": width,
            "covariance": localization.covariance,
            "action": self._action,
            "restoring": self._restoring,
        }
        for name, value in row.items():
            self._rows[name].append(value)
        if robot.time >= self._scan_due - _SOON:
            self._scan_due = robot.time + SCAN_PERIOD_S
            self._take_scan(robot)
        if robot.time >= self._picture_due - _SOON:
            self._take_picture(robot)
        if scene is not None:
            self._take_things(robot.time, scene)

    def _take_scan(self, robot: Robot) -> None:
        if self._range is not None:
            ranges = self._range.scan().rep117()  # may raise: then neither time nor ranges are kept
            self._scan_times.append(robot.time)
            self._scans.append(ranges)
        self._take_people(robot)
        cloud = robot.localization.particles
        if cloud is not None:
            self._cloud_times.append(robot.time)
            self._clouds.append(
                cloud.T[:: max(1, cloud.shape[1] // MAX_CLOUD_PARTICLES)][:MAX_CLOUD_PARTICLES]
            )

    def _take_people(self, robot: Robot) -> None:
        rows = People.of(robot.people.now(robot.time)).rows
        self._people += rows.tolist()
        self._people_times += [robot.time] * len(rows)

    def _take_picture(self, robot: Robot) -> None:
        """Record the picture that a primitive requested last, if it is a new one."""
        picture = robot.seen
        if picture is None or picture is self._shown:
            return
        self._picture_due = robot.time + PICTURE_PERIOD_S
        self._shown, jpeg = picture, jpeg_of(picture)
        self._picture_times.append(robot.time)
        self._pictures.append(jpeg)

    def _take_things(self, time: float, scene: Scene) -> None:
        if scene.changes == self._changes:
            carried = [*self._riding, *([] if scene.held is None else [scene.held])]
        else:
            carried = scene.things()
            self._riding, self._changes = scene.riding(), scene.changes
        new: list[PosedBox] = []
        drawn: list[PosedBox] = [*carried, *scene.passers.shapes()]
        for thing in drawn:
            before, stands = self._at.get(thing.name), thing.pose.tobytes()
            if before is None:
                new.append(thing)
            if before != stands:
                self._at[thing.name] = stands
                self._moved.append((time, thing.name, thing.pose.copy()))
        self._shapes += thing_shapes(new)

    # A part

    def _clear(self) -> None:
        self._rows: dict[str, list[Any]] = {name: [] for name in ROW_COLUMNS}
        self._scan_times: list[float] = []
        self._scans: list[FloatArray] = []
        self._people_times: list[float] = []
        self._people: list[list[float]] = []
        self._cloud_times: list[float] = []
        self._clouds: list[FloatArray] = []
        self._picture_times: list[float] = []
        self._pictures: list[bytes] = []
        self._moved: list[tuple[float, str, FloatArray]] = []
        self._shapes: list[ThingShape] = []

    def _write(self) -> None:
        if self._folder is None or not self._rows["time"]:
            return
        self._part += 1
        try:
            packed = BytesIO()
            np.savez_compressed(packed, **self._arrays())
            write_whole(self._folder / PART_FILE_FORMAT.format(self._part), packed.getvalue(), sync=False)
        except Exception as error:
            self._lose(error)
        self._clear()

    def _lose(self, error: Exception) -> None:
        self._folder = None
        self.lost = (
            error.strerror if isinstance(error, OSError) else None
        ) or f"{type(error).__name__}: {error}"

    def _arrays(self) -> dict[str, Any]:
        """Return the arrays of a part, as `RecordingPart` defines them."""
        rows = {name: np.array(values) for name, values in self._rows.items()}
        truth = rows["truth"]
        known = np.isfinite(truth[:, 0, 0])
        seven = np.full((len(truth), 7), np.nan)
        seven[known] = sevens(truth[known])
        names = sorted({name for _, name, _ in self._moved})
        index = {name: number for number, name in enumerate(names)}
        return {
            **rows,
            "truth": seven,
            "covariance": rows["covariance"].astype(np.float32),
            "action": rows["action"].astype(np.int32),
            "scan_time": np.array(self._scan_times),
            "scan_mm": millimetres(np.array(self._scans)),
            "people_time": np.array(self._people_times),
            "people": np.array(self._people).reshape(-1, 7),
            "cloud_time": np.array(self._cloud_times),
            "cloud": np.array(self._clouds, dtype=np.float32),
            "picture_time": np.array(self._picture_times),
            "picture_end": np.cumsum([len(picture) for picture in self._pictures], dtype=np.int64),
            "picture": np.frombuffer(b"".join(self._pictures), np.uint8),
            "moved_time": np.array([time for time, _, _ in self._moved]),
            "moved_name": np.array([index[name] for _, name, _ in self._moved], dtype=np.int32),
            "moved_pose": sevens(np.array([pose for _, _, pose in self._moved]).reshape(-1, 4, 4)),
            "names": np.array(names, dtype=np.str_),
            "shapes": np.frombuffer(SHAPES_ADAPTER.dump_json(self._shapes), np.uint8),
        }


def jpeg_of(picture: ByteArray) -> bytes:
    """Return a grey picture (h, w) at half its size, as JPEG bytes."""
    half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    _, jpeg = cv2.imencode(".jpg", half, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return jpeg.tobytes()
