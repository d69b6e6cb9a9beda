"""Runs are requested one at a time, and acknowledged once their reason could be read."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import IO, Any

import pytest

from handcart.networks.journal.journal import JOURNAL_SCHEMA, Journal
from handcart.networks.run_files.run_folder import read_run_journal
from handcart.networks.run_files.socket_path import CONTROL_SOCKET
from handcart.tools.node.run_desk import RunDesk, service_names
from tests.evaluation.viewing.node.noted_link import NotedLink

HEADER: dict[str, Any] = {
    **dict.fromkeys(("network", "robot", "robot_sha256", "start"), ""),
    "simulated": False,
    "task_path": "/t/task.yaml",
    "seed": 0,
    "backend": "ros2",
    "bench": None,
    "schema": JOURNAL_SCHEMA,
    "handcart": version("handcart"),
    "settings": {},
    "errors": False,
}
BROKEN_OFF: dict[str, Any] = {"n": 1, "action": {"index": 0, "do": "MOVE_TO", "from": "here", "to": "there"}}
GAVE_UP: dict[str, Any] = {"n": 1, "outcome": "GiveUp", "reason": "it squeaks", "residuals": {}}
PYTHON = (sys.executable, "-S", "-c")


class Robot:
    """Starts runs that exist on paper: a folder with a journal that is held open."""

    def __init__(self, runs: Path) -> None:
        self.runs, self.asked = runs, list[Sequence[str]]()
        self.refusal = ""
        self._journal: Journal | None = None
        self._children: list[subprocess.Popen[bytes]] = []

    def start(self, words: Sequence[str], said: IO[bytes]) -> subprocess.Popen[bytes]:
        self.asked.append(words)
        if self.refusal:
            code = f"print({self.refusal!r}); raise SystemExit(2)"
        else:
            code = "import sys; sys.stdin.read()"
            self._begin(words)
        child = subprocess.Popen((*PYTHON, code), stdin=subprocess.PIPE, stdout=said, stderr=said)
        self._children.append(child)
        return child

    def _begin(self, words: Sequence[str]) -> None:
        """Write what a new run, or a resumed one, writes first."""
        if "resume" in words:
            folder = Path(words[words.index("resume") + 1])
            self._journal = Journal.go_on(folder / "journal.jsonl", read_run_journal(folder))
            self._journal.append(
                "EPOCH", 1.0, {"after": int(words[words.index("--confirm") + 1]), "in_doubt": 1}
            )
            return
        folder = self.runs / f"run-{len(self.asked)}"
        folder.mkdir(parents=True)
        self._journal = Journal(folder / "journal.jsonl")
        self._journal.append("RUN", 0.0, HEADER, {"wall": {"unix_s": float(len(self.asked))}})
        (folder / CONTROL_SOCKET).touch()

    def end(self, kind: str = "RESULT", **fields: Any) -> None:
        """Let the run end, with a last record."""
        assert self._journal is not None
        if fields:
            self._journal.append(kind, 1.0, fields)
        self._journal.__exit__(None, None, None)
        self._journal = None
        self._children[-1].communicate()

    def close(self) -> None:
        if self._journal is not None:
            self.end()
        for child in self._children:
            child.communicate()


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    found = Robot(tmp_path / "runs")
    yield found
    found.close()


def test_a_second_run_is_refused_while_one_is_running(robot: Robot) -> None:
    options, link = ("--backend", "ros2"), NotedLink()
    desk = RunDesk({"tour": Path("/t/tour.yaml")}, robot.runs, options, (), robot.start)
    desk.offer(link)
    request = link.services["handcart/run/tour"]
    first = request()
    assert first == (True, f"tour runs in {robot.runs / 'run-1'}")
    words = ("run", "/t/tour.yaml", "--node", "--runs", str(robot.runs), "--backend", "ros2")
    assert tuple(robot.asked[0][-len(words) :]) == words
    again = request()
    assert not again.success and "is running; allowed: one at a time" in again.message
    assert desk.state()["running"] == str(robot.runs / "run-1")
    robot.end()
    assert desk.state()["running"] is None
    assert request().success


def test_a_run_of_another_program_counts_too(robot: Robot) -> None:
    RunDesk({"tour": Path("tour.yaml")}, robot.runs, (), (), robot.start).request("tour")
    other = RunDesk({"tour": Path("tour.yaml")}, robot.runs, (), (), robot.start)
    assert not other.request("tour").success
    assert len(robot.asked) == 1


def test_the_answer_is_the_refusal_of_the_run_itself(robot: Robot) -> None:
    robot.refusal = "the robot ros2-a is in another run: /r; allowed: one at a time"
    desk = RunDesk({"tour": Path("tour.yaml")}, robot.runs, (), (), robot.start)
    assert desk.request("tour") == (False, robot.refusal)


def test_a_giveup_is_acknowledged_once_it_was_published(robot: Robot) -> None:
    now = [0.0]
    desk = RunDesk({"tour": Path("tour.yaml")}, robot.runs, (), (), robot.start, lambda: now[0])
    assert desk.acknowledge() == (False, "no run waits for a person")
    desk.request("tour")
    robot.end(**GAVE_UP)
    assert desk.acknowledge() == (False, "no run waits for a person")
    assert desk.state()["waits"]["reason"] == "it squeaks"
    assert "was not read before; read it" in desk.acknowledge().message
    now[0] = 1.5
    assert desk.acknowledge() == (True, "it squeaks")
    assert desk.state()["waits"] is None
    assert read_run_journal(robot.runs / "run-1").records[-1]["kind"] == "ACK"


@pytest.mark.parametrize("simulated", [False, True])
def test_after_a_crash_a_request_is_answered_by_what_waits(
    robot: Robot, simulated: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(HEADER, "simulated", simulated)
    desk = RunDesk({"tour": Path("tour.yaml")}, robot.runs, (), (), robot.start)
    desk.request("tour")
    robot.end("START", **BROKEN_OFF)
    answer = desk.request("tour")
    assert answer.success == simulated
    if not simulated:
        assert f"{robot.runs / 'run-1'}, waits for a person: action 1, MOVE_TO from here" in answer.message
        assert "handcart/acknowledge" in answer.message
        assert len(robot.asked) == 1


def test_a_run_that_broke_off_is_resumed_as_it_was_read(robot: Robot) -> None:
    now = [0.0]
    spaced = ("--node-namespace", "/r")
    desk = RunDesk({"tour": Path("tour.yaml")}, robot.runs, ("-x",), spaced, robot.start, lambda: now[0])
    assert desk.resume() == (False, "there is no run yet")
    desk.request("tour")
    assert "one at a time" in desk.resume().message
    robot.end("START", **BROKEN_OFF)
    run = robot.runs / "run-1"
    read = {"run": str(run), "record": 1, "end": "it broke off after record 1, START"}
    assert desk.state()["resumable"] == read
    assert "its state was not read before" in desk.resume().message
    now[0] = 1.5
    robot.refusal = "the robot isn't where that action began: base 0.3 m off; bring it there"
    assert desk.resume() == (False, robot.refusal)
    robot.refusal = ""
    assert desk.resume() == (True, f"resumed: {run}")
    assert robot.asked[-1][3:] == ["resume", str(run), "--node", "--confirm", "1", *spaced]


def test_a_run_that_has_ended_is_not_resumed(robot: Robot) -> None:
    now = [0.0]
    desk = RunDesk({"tour": Path("tour.yaml")}, robot.runs, (), (), robot.start, lambda: now[0])
    desk.request("tour")
    robot.end("END", outcome="Success", situation="home", reason="")
    assert desk.state()["resumable"] is None
    now[0] = 1.5
    assert "is over: Success in situation home" in desk.resume().message
    assert len(robot.asked) == 1


def test_a_journal_that_grew_since_it_was_read_is_not_resumed(robot: Robot) -> None:
    now = [0.0]
    desk = RunDesk({"tour": Path("tour.yaml")}, robot.runs, (), (), robot.start, lambda: now[0])
    desk.request("tour")
    robot.end("START", **BROKEN_OFF)
    desk.state()
    now[0] = 1.5
    assert desk.acknowledge().success
    assert "its state was not read before" in desk.resume().message


def test_services_get_names_that_ros_accepts() -> None:
    tasks = ("/a/drive_map/task.yaml", "/b/my-tour.yaml", "/c/my-tour.yaml", "/d/2nd.yaml", "/e/2nd.yaml")
    found = list(service_names(list(map(Path, tasks))))
    assert found == ["drive_map", "my_tour", "my_tour_2", "task_2nd", "task_2nd_2"]
