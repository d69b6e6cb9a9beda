from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.simulation.world.scene import Scene
from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.viewing.playback import recorder as recording
from handcart.evaluation.viewing.playback.part import metres, millimetres
from handcart.evaluation.viewing.playback.playback import Playback
from handcart.evaluation.viewing.playback.recorder import ROW_PERIOD_S, PlaybackRecorder
from handcart.evaluation.viewing.playback.seven import transforms
from handcart.networks.events.run_end import RunEnd
from handcart.networks.journal.journal import Journal
from handcart.networks.run_files.run_folder import NoRun
from handcart.networks.runs.run_header import header, process_facts
from handcart.networks.task.preparing import Prepared, prepare
from handcart.robotics.numerics.arrays import FloatArray

STACK = Path(__file__).parents[4] / "tasks" / "stack_blocks" / "task.yaml"
SECONDS = 3.0


class Run:
    """A run of nothing but periods, of which it is known where everything was."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.prepared: Prepared = prepare(STACK)
        scene = simulated_world(self.prepared.backend)
        assert scene is not None
        self.scene: Scene = scene
        self.joints: dict[float, FloatArray] = {}
        self.ranges: dict[float, FloatArray] = {}
        self.before: list[FloatArray] = []
        folder.mkdir()
        with Journal(folder / "journal.jsonl") as journal:
            journal.append("RUN", 0.0, header(self.prepared), process_facts("always"))

    def record(self, recorder: PlaybackRecorder, until: float) -> None:
        robot = self.prepared.robot
        recorder.begin(self.prepared, self.folder)
        while robot.time < until - 1e-9:
            robot.base.drive(0.1, 0.2)
            robot.step()
            if min(abs(robot.time - 2.0), abs(robot.time - 2.6)) < 1e-9:
                self.moved = self.scene.things()[0]
                self.before.append(self.moved.pose.copy())
                self.moved.pose = (
                    self.moved.pose @ transforms(np.array([[0.0, 0.3, 0.1, 0.8, 0.0, 0.0, 0.6]]))[0]
                )
                self.scene.changes += 1
                robot.picture()
            recorder.period(robot)
            self.joints[round(robot.time, 3)] = robot.get(Arm).joints()  # type: ignore[type-abstract]
            self.ranges[round(robot.time, 3)] = robot.get(RangeSensor).scan().ranges  # type: ignore[type-abstract]
        recorder.end()


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Run]:
    made = Run(tmp_path_factory.mktemp("playback") / "stack-0")
    made.record(PlaybackRecorder(), SECONDS)
    yield made
    made.prepared.backend.close()


@pytest.fixture(scope="module")
def playback(run: Run) -> Playback:
    return Playback.read(run.folder)


def test_playback_rows_at_10_hz_hold_measured_and_true_values(run: Run, playback: Playback) -> None:
    rows = playback.rows
    assert np.diff(rows.time) == pytest.approx(ROW_PERIOD_S)
    assert playback.start == 0.0
    assert playback.end == pytest.approx(SECONDS)
    for time, joints in zip(rows.time[1:], rows.joints[1:], strict=True):
        assert np.array_equal(joints, run.joints[round(float(time), 3)])
    assert transforms(rows.truth[-1:])[0] == pytest.approx(run.scene.world_T_base, abs=1e-9)
    assert tuple(rows.pose[-1]) == tuple(run.prepared.robot.pose)
    assert rows.covariance[-1] == pytest.approx(run.prepared.robot.localization.covariance, rel=1e-5)


def test_between_two_rows_the_way_is_straight(playback: Playback) -> None:
    rows, time = playback.rows, float(playback.rows.time[7]) + 0.3 * ROW_PERIOD_S
    moment = playback.at(time)
    assert moment.truth is not None
    assert moment.truth[:3] == pytest.approx(0.7 * rows.truth[7, :3] + 0.3 * rows.truth[8, :3])
    assert np.linalg.norm(moment.truth[3:]) == pytest.approx(1.0)
    assert moment.joints == pytest.approx(0.7 * rows.joints[7] + 0.3 * rows.joints[8])
    assert playback.at(-1.0).time == playback.start
    assert playback.at(1e9).time == playback.end
    assert np.array_equal(playback.at(1e9).joints, rows.joints[-1])


def test_a_thing_stays_where_it_is_until_it_is_moved(run: Run, playback: Playback) -> None:
    assert playback.things.keys() == {thing.name for thing in run.scene.things()}
    track = playback.things[run.moved.name]
    assert track.at(-0.1) is None
    first, second = run.before
    for time, pose in ((1.9, first), (2.0, second), (2.5, second), (2.6, run.moved.pose)):
        found = track.at(time)
        assert found is not None
        assert transforms(found[None])[0] == pytest.approx(pose, abs=1e-9)
    assert track.shape.size_m == pytest.approx(run.moved.size)
    still = playback.things[run.scene.things()[1].name]
    assert len(still.time) == 1


def test_scans_are_kept_to_the_millimetre(run: Run, playback: Playback) -> None:
    times = playback.rows.scan_time
    assert len(times) == round(SECONDS / recording.SCAN_PERIOD_S) + 1
    read = run.ranges[round(float(times[5]), 3)]
    found = playback.ranges(5)
    assert np.array_equal(np.isinf(found), np.isinf(read))
    assert np.abs(found - read)[np.isfinite(read)].max() <= 0.5e-3 + 1e-9
    assert playback.latest(times, float(times[5]) + 0.05) == 5
    assert playback.latest(times, -1.0) is None


def test_what_is_no_distance_stays_none() -> None:
    read = np.array([1.2344, np.inf, np.nan, 0.0, 200.0, -np.inf])
    found = metres(millimetres(read))
    assert found[:1] == pytest.approx([1.234])
    assert np.isinf(found[1])
    assert np.isnan(found[2])
    assert found[3] == 0.0
    assert np.isfinite(found[4])
    assert np.isnan(found[5])  # too close is not a free way


def test_pictures_are_those_that_were_asked_for(playback: Playback) -> None:
    assert playback.rows.picture_time == pytest.approx([2.0, 2.6])
    assert [jpeg[:2] for jpeg in playback.pictures] == [b"\xff\xd8"] * 2


def test_a_run_that_went_on_from_before_has_each_moment_once(tmp_path: Path) -> None:
    run = Run(tmp_path / "went_on-0")
    with run.prepared:
        run.record(PlaybackRecorder(), SECONDS)
        run.prepared.robot.time = 2.4
        run.record(PlaybackRecorder(), 4.0)
    playback = Playback.read(run.folder)
    assert (np.diff(playback.rows.time) > 0.0).all()
    assert (np.diff(playback.rows.scan_time) > 0.0).all()
    assert playback.end == pytest.approx(4.0)
    assert len(playback.rows.joints) == len(playback.rows.time)
    assert all((np.diff(thing.time) >= 0.0).all() for thing in playback.things.values())


def test_a_folder_without_a_recording_says_so(run: Run, tmp_path: Path) -> None:
    older = tmp_path / "older-0"
    older.mkdir()
    (older / "journal.jsonl").write_bytes((run.folder / "journal.jsonl").read_bytes())
    with pytest.raises(NoRun, match=r"nothing was recorded in it .*; `handcart run` .* records it"):
        Playback.read(older)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("00001.npz", b"PK", "00001.npz in it is damaged"),
        ("scenery.json", b"{}", "scenery.json in it: robot: Field required"),
        ("scenery.json", b"\xff", "scenery.json in it"),
        ("00001.npz", None, "00001.npz in it is damaged .*it has no joints"),
    ],
)
def test_a_damaged_recording_is_told(
    run: Run, tmp_path: Path, name: str, content: bytes | None, said: str
) -> None:
    folder = tmp_path / "damaged-0"
    (folder / "playback").mkdir(parents=True)
    for path in ("journal.jsonl", "playback/scenery.json", "playback/00001.npz"):
        (folder / path).write_bytes((run.folder / path).read_bytes())
    if content is None:
        with np.load(folder / "playback" / name) as arrays:
            kept = {key: arrays[key] for key in arrays.files if key != "joints"}
        np.savez(folder / "playback" / name, **kept)
    else:
        (folder / "playback" / name).write_bytes(content)
    with pytest.raises(NoRun, match=said):
        Playback.read(folder)


def test_a_full_disk_ends_the_recording_not_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    run, recorder = Run(tmp_path / "full-0"), PlaybackRecorder()
    monkeypatch.setattr(recording, "write_whole", full)
    with run.prepared:
        run.record(recorder, 0.5)
    end = RunEnd("Success", "done", "", 0, 0, 0)
    assert recorder.figures(end) == {"playback_lost": "No space left on device"}


def test_scan_that_can_not_be_read_costs_that_scan_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, recorder = Run(tmp_path / "stack-0"), PlaybackRecorder()
    lidar = made.prepared.robot.lidar
    assert lidar is not None
    scan = lidar.scan

    def broken() -> object:
        if 0.9 < made.prepared.robot.time < 1.1:
            raise RuntimeError("the lidar is silent")
        return scan()

    try:
        recorder.begin(made.prepared, made.folder)
        monkeypatch.setattr(recorder, "_range", SimpleNamespace(scan=broken))
        while made.prepared.robot.time < 2.0:
            made.prepared.robot.step()
            recorder.period(made.prepared.robot)
        recorder.end()
        rows = Playback.read(made.folder).rows
        assert len(rows.scan_time) == len(rows.scan_mm)
        assert not any(0.9 < time < 1.1 for time in rows.scan_time)
        assert {round(time, 1) for time in rows.scan_time.tolist()} >= {0.8, 1.2}
        assert recorder.lost is None
    finally:
        made.prepared.backend.close()
