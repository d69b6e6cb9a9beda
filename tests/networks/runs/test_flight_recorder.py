"""The last seconds of readings and commands."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.scan import Scan, Validity
from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.events.events import Ended, Restoring, Started
from handcart.networks.graph.network import Action, ActionNetwork, Situation
from handcart.networks.runs.flight_recorder import MAX_ARRAYS, FlightRecorder, load_arrays, load_readings
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.pose2 import Pose2
from tests.networks import conftest
from tests.networks.conftest import Stand

PERIOD = 0.05


@pytest.fixture
def drive(stand: Stand, tmp_path: Path) -> Callable[..., dict[str, Any]]:
    """Return a function that drives until `fails` periods have passed, and returns the recorded files by
    name.
    """

    def driven(
        fails: int, error: Discrepancy | None = None, seconds: float = 10.0, pauses: int = 0
    ) -> dict[str, Any]:
        class Drive(conftest.Drive):
            def motion(self, robot: Robot, model: ModelView) -> Periods:
                for _ in range(fails):
                    robot.base.drive(0.2, 0.0)
                    yield
                if error is not None:
                    raise error

        from handcart.networks.graph.network import Binding

        network = ActionNetwork.build(
            [Situation("a"), Situation("z")], [Action("a", "z", Binding.of(Drive()), attempts=1)], "a", "z"
        )
        recorder = FlightRecorder(tmp_path, stand.robot, seconds)
        coordinator = Coordinator(network, stand.robot, stand.model, observers=[recorder.event])
        run = coordinator.run()
        for _ in range(10_000):
            try:
                next(run)
            except StopIteration:
                break
            stand.robot.step(paused=pauses > 0)
            pauses -= 1
            recorder.period(stand.robot)
        recorder.end()
        return {path.name: load_readings(path) for path in sorted((tmp_path / "evidence").iterdir())}

    return driven


def test_a_fail_keeps_what_came_before_it_and_the_way_back(drive: Callable[..., dict[str, Any]]) -> None:
    kept = drive(120, Discrepancy("enough"), seconds=2.0)
    assert list(kept) == ["001_DRIVE_Fail_readings.npz"]  # nothing has happened since
    readings = kept["001_DRIVE_Fail_readings.npz"]
    times, restoring = readings["time_s"], readings["restoring"]
    decided = times[~restoring][-1]
    assert decided - times[0] == pytest.approx(2.0 - PERIOD)
    assert np.all(np.diff(times) > 0.0)
    assert np.allclose(readings["speed_command_m_s"][~restoring][:-1], 0.2)
    assert readings["speed_command_m_s"][restoring].min() < 0.0
    assert readings["x_m"][~restoring][-1] == pytest.approx(1.2, abs=0.02)
    assert set(readings["action"].tolist()) == {1}


def test_a_success_leaves_the_end_of_the_run_alone(drive: Callable[..., dict[str, Any]]) -> None:
    kept = drive(30)
    assert list(kept) == ["end_readings.npz"]
    assert len(kept["end_readings.npz"]["time_s"]) < 60


def test_no_more_than_the_last_seconds_are_held(drive: Callable[..., dict[str, Any]]) -> None:
    assert len(drive(100, seconds=1.0)["end_readings.npz"]["time_s"]) == 20


def test_a_pause_is_not_recorded(drive: Callable[..., dict[str, Any]]) -> None:
    times = drive(30, pauses=10)["end_readings.npz"]["time_s"]
    assert np.allclose(np.diff(times), PERIOD)


def test_before_the_first_action_there_is_none(stand: Stand, tmp_path: Path) -> None:
    recorder = FlightRecorder(tmp_path, stand.robot)
    for _ in range(3):
        stand.robot.step()
        recorder.period(stand.robot)
        recorder.period(stand.robot)  # nothing new
    recorder.end()
    recorder.end()  # nothing has happened since
    readings = load_readings(tmp_path / "evidence" / "end_readings.npz")
    assert readings["action"].tolist() == [0, 0, 0]
    assert readings["restoring"].tolist() == [False] * 3
    assert readings["time_s"] == pytest.approx([PERIOD, 2 * PERIOD, 3 * PERIOD])
    assert readings["footprint_m"] == stand.robot.spec.footprint_radius_m


def test_a_second_action_begins_its_own_evidence(stand: Stand, tmp_path: Path) -> None:
    """Its file holds nothing of the way back of the one before; readings have its number."""
    recorder = FlightRecorder(tmp_path, stand.robot, seconds=0.5)
    action = stand.network("a z go 1").actions[0]
    drive: Any = stand.Drive()
    fail: Any = SimpleNamespace()
    for number in (1, 2):
        recorder.event(Started(stand.robot.time, number, action, drive, 0))
        for period in range(12):
            if period == 8:
                recorder.event(Restoring(stand.robot.time, action, "enough"))
            stand.robot.step()
            recorder.period(stand.robot)
        recorder.event(Ended(stand.robot.time, number, action, drive, fail, {}))
    for number in (1, 2):
        path = tmp_path / "evidence" / f"00{number}_THINK_SimpleNamespace_readings.npz"
        readings = load_readings(path)
        assert set(readings["action"][-10:].tolist()) == {number}
        assert readings["restoring"].tolist()[-4:] == [True] * 4
        assert readings["restoring"].sum() == (4 if number == 1 else 4 + 2)
        assert len(readings["time_s"]) == (12 if number == 1 else 14)
    before = sorted((tmp_path / "evidence").iterdir())
    recorder.end()
    assert sorted((tmp_path / "evidence").iterdir()) == before


def test_arrays_larger_than_any_run_keeps_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "arrays.npz"
    np.savez_compressed(path, x_m=np.zeros(100))
    with pytest.raises(ValueError, match="the column time_s is missing"):
        load_readings(path)
    unpacked = 928  # a header of 128 bytes
    monkeypatch.setattr("handcart.networks.runs.flight_recorder.MAX_ARRAYS", unpacked)
    assert load_arrays(path)["x_m"].shape == (100,)
    monkeypatch.setattr("handcart.networks.runs.flight_recorder.MAX_ARRAYS", unpacked - 1)
    with pytest.raises(ValueError, match="928 bytes when unpacked, more than 927"):
        load_arrays(path)
    assert MAX_ARRAYS == 268_435_456
    np.savez(path, time_s=np.array([{}], dtype=object))
    with pytest.raises(ValueError, match="allow_pickle"):
        load_arrays(path)


def test_a_full_disk_ends_the_evidence_not_the_run(stand: Stand, tmp_path: Path) -> None:
    (tmp_path / "evidence").write_text("a file where a folder is to be")
    recorder = FlightRecorder(tmp_path, stand.robot)
    stand.robot.step()
    recorder.period(stand.robot)
    recorder.end()
    assert recorder.lost == "File exists"


def test_recorded_ranges_say_why_a_beam_is_no_return(
    drive: Callable[..., dict[str, Any]], stand: Stand, monkeypatch: pytest.MonkeyPatch
) -> None:
    validity = np.array([Validity.NO_RETURN, Validity.TOO_CLOSE, Validity.INVALID, Validity.RETURN], np.uint8)
    ranges = np.where(validity == Validity.RETURN, 2.0, np.inf)
    read = Scan(np.radians([-90.0, 0.0, 90.0, 180.0]), ranges, Pose2(0.0, 0.0, 0.0), validity)
    lidar = SimpleNamespace(scan=lambda: read, scan_later=lambda: lambda: read)
    monkeypatch.setattr(stand.robot, "lidar", lidar)
    (readings,) = drive(5).values()
    np.testing.assert_array_equal(readings["ranges_m"][-1], [np.inf, -np.inf, np.nan, 2.0])
