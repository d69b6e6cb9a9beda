"""When a run's raw traffic is held and written."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typing_extensions import override

from handcart.backends.recording import Recording
from handcart.networks.events.events import Ended, Restoring
from handcart.networks.graph.network import Action
from handcart.networks.runs.recording_keeper import RecordingKeeper
from handcart.primitives.outcomes.outcome import GiveUp, Outcome, Success


class Calls(Recording):
    """A recording that notes what is asked of it."""

    suffix = ".log"

    def __init__(self) -> None:
        self.calls = list[Any]()

    @override
    def open(self, folder: Path) -> None:
        self.calls.append(("open", folder.name))

    @override
    def look(self, time: float) -> None:
        self.calls.append(("look", time))

    @override
    def mark(self) -> None:
        self.calls.append("mark")

    @override
    def keep(self, stem: Path) -> None:
        self.calls.append(("keep", f"{stem.parent.name}/{stem.name}"))

    @override
    def close(self) -> None:
        self.calls.append("close")


@pytest.fixture
def recording() -> Calls:
    return Calls()


def ended(outcome: Outcome) -> Ended:
    primitive: Any = SimpleNamespace()
    return Ended(1.0, 3, Action("a", "b", None), primitive, outcome, {})


def test_recording_of_a_failure_is_marked_as_restoring_begins(tmp_path: Path, recording: Calls) -> None:
    keeper, robot = RecordingKeeper(recording), SimpleNamespace(time=2.5)
    prepared: Any = SimpleNamespace()
    keeper.begin(prepared, tmp_path)
    keeper.period(robot)  # type: ignore[arg-type]
    keeper.event(Restoring(1.0, Action("a", "b", None), "it stalled"))
    keeper.event(ended(GiveUp("it jams")))
    keeper.end()
    assert recording.calls == [
        ("open", tmp_path.name),
        ("look", 2.5),
        "mark",
        ("keep", "evidence/003_SKIP_GiveUp"),
        "mark",
        ("keep", "evidence/end"),
        "close",
    ]


def test_recording_of_a_success_is_not_kept(tmp_path: Path, recording: Calls) -> None:
    RecordingKeeper(recording).event(ended(Success({})))
    assert recording.calls == []
