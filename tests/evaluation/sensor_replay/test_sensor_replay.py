"""Replay on recorded readings: the same commands to the last bit, and what makes them differ."""

from __future__ import annotations

import itertools
import shutil
import tracemalloc
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.scan import Scan
from handcart.backends.robot.guarded_base import GuardedBase
from handcart.backends.sensors.all_kinds import all_capabilities
from handcart.evaluation.layers.layered_backend import EXTENDED_KINDS
from handcart.evaluation.sensor_replay.plain_readings import NotRecordable, plain, typed
from handcart.evaluation.sensor_replay.recording_file import SENSORS_FILE, NoRecording
from handcart.evaluation.sensor_replay.sensor_recorder import SensorRecorder
from handcart.evaluation.sensor_replay.sensor_replay import ChangedFiles, SensorReplay, replay_sensors
from handcart.evaluation.trials.rig import build_rig
from handcart.evaluation.trials.running import run_task
from handcart.networks.past_runs.past_run import read_run
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives.driving.move_to import MoveTo
from handcart.robotics.geometry.pose2 import Pose2

TOUR = Path(__file__).resolve().parents[3] / "tasks" / "drive_map" / "task.yaml"
PLACES = """\
format: handcart-places/1
places:
  home: {x_m: 1.0, y_m: 5.2, heading_deg: 0.0}
  near: {x_m: 1.5, y_m: 5.2, heading_deg: 0.0}
"""


@pytest.fixture
def settings(tmp_path: Path) -> Mapping[str, str]:
    """A drive of half a metre."""
    (tmp_path / "places.yaml").write_text(PLACES, encoding="utf-8")
    return {"robot": "cart", "tour": "[near]", "places": str(tmp_path / "places.yaml")}


def recorded(runs: Path, settings: Mapping[str, str], **options: Any) -> Path:
    """A run with its readings; gives its folder."""
    summary, _ = run_task(TOUR, runs, RunOptions(settings=settings, record_sensors=True, **options))
    return Path(summary["run_dir"])


def replayed(folder: Path) -> SensorReplay:
    return replay_sensors(read_run(folder))


@pytest.fixture
def folder(tmp_path: Path, settings: Mapping[str, str]) -> Path:
    return recorded(tmp_path, settings)


def test_the_same_code_commands_the_same(folder: Path) -> None:
    found = replayed(folder)
    assert found.difference == ""
    assert found.actions == len(read_run(folder).actions) == 1
    assert min(found.periods, found.commands) > 20
    assert found.readings > 2 * found.periods


def test_layers_know_every_interface_that_extends_a_kind() -> None:
    def extending(kind: type[Capability]) -> Iterator[type[Capability]]:
        for sub in kind.__subclasses__():
            yield from (sub, *extending(sub))

    kinds = all_capabilities()
    interfaces = {
        sub
        for kind in kinds
        for sub in extending(kind)
        if sub.__module__.startswith("handcart.backends.capabilities.")
    }
    assert len(interfaces) >= 2
    assert interfaces <= {*kinds, *EXTENDED_KINDS}


@pytest.mark.slow
def test_drives_on_the_bench_are_commanded_the_same(tmp_path: Path, settings: Mapping[str, str]) -> None:
    found = replayed(recorded(tmp_path, settings, backend="can", bench="kinematic"))
    assert found.difference == ""
    assert min(found.periods, found.commands) > 20


@pytest.mark.slow
def test_recording_changes_nothing_in_a_run(
    tmp_path: Path, settings: Mapping[str, str], folder: Path
) -> None:
    summary, _ = run_task(TOUR, tmp_path, RunOptions(settings=settings))
    ours, plain_run = read_run(folder), read_run(Path(summary["run_dir"]))
    assert [record["h"] for record in ours.records] == [record["h"] for record in plain_run.records]


def test_one_bit_of_a_command_is_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drive, count = GuardedBase.drive, itertools.count()

    def nudged(self: Any, speed: float, turn_rate: float) -> None:
        drive(self, float(np.nextafter(speed, 1.0)) if next(count) == 15 else speed, turn_rate)

    monkeypatch.setattr(GuardedBase, "drive", nudged)
    found = replayed(folder)
    assert "action 1: it commands Base.drive(" in found.difference
    assert "; the run: Base.drive(" in found.difference


def test_a_primitive_that_knows_the_truth_is_found(
    tmp_path: Path, settings: Mapping[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = MoveTo.watch

    def cheats(self: Any, robot: Any, model: Any) -> None:
        truth = robot.backend.true_base()
        self.found(true_x=truth.x)
        watch(self, robot, model)

    monkeypatch.setattr(MoveTo, "watch", cheats)
    found = replayed(recorded(tmp_path, settings))
    assert ", action 1: it" in found.difference


def test_a_primitive_that_counts_otherwise_is_found(
    tmp_path: Path, settings: Mapping[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    watch, ticks = MoveTo.watch, itertools.count()

    def peeks(self: Any, robot: Any, model: Any) -> None:
        if next(ticks) == 3:  # in the first run alone
            robot.backend.stop()
        watch(self, robot, model)

    monkeypatch.setattr(MoveTo, "watch", peeks)
    found = replayed(recorded(tmp_path, settings))
    assert "it commands" in found.difference or "it does not command robot.stop()" in found.difference


def test_faults_of_the_robot_are_replayed(tmp_path: Path, settings: Mapping[str, str]) -> None:
    from handcart.evaluation.conformance.faults.fault import Fault, FaultKind
    from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend

    def refusing(inner: Any) -> FaultyBackend:
        faulty = FaultyBackend(inner)
        faulty.inject(Fault(FaultKind.NAN, "range"))
        return faulty

    folder = recorded(tmp_path, settings, around=refusing)
    assert replayed(folder).difference == ""


def test_what_cannot_be_replayed_is_said(tmp_path: Path, settings: Mapping[str, str], folder: Path) -> None:
    content = (folder / SENSORS_FILE).read_bytes()
    torn = shutil.copytree(folder, tmp_path / "torn")
    (torn / SENSORS_FILE).write_bytes(content[: len(content) // 2])
    with pytest.raises(NoRecording, match="no whole block"):
        replayed(torn)
    for wrong, said in ((b"x", "not of the format"), (content[:19] + b"\0" * 7 + b"\x05xxxxx", "damaged")):
        (torn / SENSORS_FILE).write_bytes(wrong)
        with pytest.raises(NoRecording, match=said):
            replayed(torn)
    (torn / SENSORS_FILE).unlink()
    with pytest.raises(NoRecording, match="--record-sensors"):
        replayed(torn)
    (tmp_path / "places.yaml").write_text(PLACES.replace("near:", "far:"), encoding="utf-8")
    with pytest.raises(Exception, match="near"):
        replayed(folder)


def test_another_network_is_refused(tmp_path: Path, settings: Mapping[str, str], folder: Path) -> None:
    run = read_run(folder)
    header = {**run.header, "settings": {**settings, "wait_s": "7.0"}}
    with pytest.raises(ChangedFiles, match="action network"):
        replay_sensors(type(run)(run.folder, header, run.records, run.actions, run.network, run.torn_at))


def test_a_full_disk_ends_the_recording_alone(
    tmp_path: Path, settings: Mapping[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("handcart.evaluation.sensor_replay.sensor_recorder.write_block", full)
    folder = recorded(tmp_path, settings)
    assert read_run(folder).actions[0].outcome == "Success"
    assert "No space left" in (folder / "summary.json").read_text("utf-8")


def test_nothing_is_kept_after_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("handcart.evaluation.sensor_replay.sensor_recorder.write_block", full)
    rig = build_rig()
    recorder = SensorRecorder(rig.backend)
    recorder.open(tmp_path)
    base = next(part for part in rig.backend.capabilities() if isinstance(part, Base))
    tracemalloc.start()
    sizes = []
    for _ in range(3):
        for _ in range(300):
            recorder.pass_on(base, Base, "drive", 0.0, 0.0)
            recorder.step()
        sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    recorder.close()
    assert sizes[2] - sizes[1] < 30_000


@pytest.mark.parametrize(
    "value",
    [np.array([np.nan, -np.inf, -0.0]), np.zeros((2, 3), np.uint8), 0.1 + 0.2, True, None],
)
def test_values_come_back_to_the_last_bit(value: Any) -> None:
    kind = np.ndarray if isinstance(value, np.ndarray) else type(value)
    back = typed(plain(value), kind)
    assert type(back) is type(value)
    assert np.asarray(back).tobytes() == np.asarray(value).tobytes()


def test_named_tuples_come_back_as_they_were() -> None:
    scan = Scan(np.arange(3.0), np.array([1.0, np.nan, np.inf]), Pose2(1.0, 2.0, 3.0))
    back = typed(plain(scan), Scan)
    assert isinstance(back, Scan)
    assert isinstance(back.base_T_sensor, Pose2)
    assert np.array_equal(back.ranges, scan.ranges, equal_nan=True)


def test_a_value_of_no_known_type_is_refused() -> None:
    with pytest.raises(NotRecordable, match="set cannot be recorded"):
        plain({1, 2})


def test_recorded_exceptions_are_raised_again(tmp_path: Path) -> None:
    from handcart.evaluation.sensor_replay.replay_backend import ReplayBackend
    from handcart.networks.task.preparing import prepare

    with prepare(TOUR, settings={"robot": "cart"}) as prepared:
        recorder = SensorRecorder(prepared.backend)
        recorder.open(tmp_path)
        base: Any = recorder.capabilities()[0]
        with pytest.raises(ValueError, match="allowed"):
            base.drive(1e9, 0.0)
        recorder.step()
        recorder.close()
    backend = ReplayBackend(tmp_path)
    stand_in: Any = backend.capabilities()[0]
    with pytest.raises(ValueError, match="allowed"):
        stand_in.drive(1e9, 0.0)
    assert not issubclass(RobotFault, ValueError)
