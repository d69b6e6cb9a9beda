from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import orjson
import pytest

pytest.importorskip("viser", reason="the extra view isn't installed")

from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.running import run_task
from handcart.evaluation.viewing.view import live_view
from handcart.evaluation.viewing.view.live_view import LiveView
from handcart.evaluation.viewing.view.serving.server import open_server
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.operator.view_address import view_address
from handcart.networks.runs.run_options import RunOptions

from .conftest import SETTINGS, TOUR


def records(folder: Path) -> list[dict[str, object]]:
    """Return the records of a journal without their wall-clock times."""
    found = [orjson.loads(line) for line in (folder / "journal.jsonl").read_bytes().splitlines()]
    return [{key: value for key, value in item.items() if key != "wall"} for item in found]


class Clock:
    """Wall clock that passes only while something sleeps."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


def test_a_run_goes_on_at_its_speed_after_a_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    wall, robot = Clock(), SimpleNamespace(time=0.0)
    monkeypatch.setattr(live_view, "clock", wall)
    view = LiveView(None, "")  # type: ignore[arg-type]
    view._since = (wall.now, robot.time)
    seconds = []
    for _ in range(2):
        before = wall.now
        for _ in range(100):
            robot.time += 0.05
            view.period(robot)  # type: ignore[arg-type]
        seconds.append(wall.now - before)
        wall.now += 60.0  # a pause, in which the robot's time stands
    assert seconds == pytest.approx([5.0, 5.0], abs=0.1)


class Hurry(RunObserver):
    """Has the view draw in every period, and wait for nothing."""

    def __init__(self, view: LiveView) -> None:
        self.view, self.drawn = view, 0

    def period(self, robot: Robot) -> None:
        assert self.view._folder is not None
        assert (view_address(self.view._folder) or "").startswith("http://127.0.0.1:")
        self.view._factor = None
        if self.view._wanted.is_set():
            self.drawn += 1


@pytest.mark.slow
def test_a_run_that_is_recorded_and_watched_is_the_same_to_the_bit(toured: Path, tmp_path: Path) -> None:
    bare, _ = run_task(TOUR, tmp_path, RunOptions(settings=SETTINGS))
    with open_server(0, "test") as opened:
        view = LiveView(*opened)
        hurry = Hurry(view)
        watched, _ = run_task(
            TOUR, tmp_path, RunOptions(settings=SETTINGS, playback=True, observers=(hurry, view))
        )
    assert view_address(Path(watched["run_dir"])) is None
    alone = records(Path(bare["run_dir"]))
    assert alone == records(toured)
    assert alone == records(Path(watched["run_dir"]))
    assert hurry.drawn > 0
    assert bare["metrics"] == watched["metrics"]
