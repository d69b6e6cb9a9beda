"""A real run, published and commanded through a link that notes all."""

from __future__ import annotations

import shutil
import threading
import time
from pathlib import Path
from typing import Any

import orjson
import pytest

from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.running import resume_task, run_task
from handcart.evaluation.viewing.node import run_node
from handcart.evaluation.viewing.node.run_node import RunNode, SecondNode, check_alone
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.events.events import Event, Started
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.operator.permits import Permits
from handcart.networks.runs.run_options import RunOptions

from .noted_link import NotedLink

TOUR = Path(__file__).parents[4] / "tasks" / "drive_map" / "task.yaml"
SETTINGS = {"robot": "cart", "tour": "[desk]"}

START = "start: {x_m: 1.0, y_m: 5.2, heading_deg: 0.0}\n"
THERE_AND_BACK = """\
format: handcart-task/1
title: There and back
robot: cart
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, start: home}
start: here
goal: back
situations: {here: {base: home}, there: {base: home}, back: {base: home}}
actions:
  - {do: MOVE_TO, from: here, to: there, cost_s: 30, with: {place: home}}
  - {do: MOVE_TO, from: there, to: back, cost_s: 30, with: {place: home}}
"""


class Commander(RunObserver):
    """Calls services from a thread of its own once the run moves; the run waits for nothing."""

    def __init__(self, link: NotedLink, words: tuple[str, ...], periods: int = 10) -> None:
        self._link, self._words, self._left = link, words, periods
        self.answers: list[Any] = []
        self._thread = threading.Thread(target=self._call)

    def period(self, robot: Robot) -> None:
        self._left -= 1
        if self._left == 0:
            self._thread.start()

    def _call(self) -> None:
        for word in self._words:
            self.answers.append(self._link.services[f"handcart/{word}"]())

    def join(self) -> None:
        self._thread.join(timeout=10.0)


@pytest.fixture(autouse=True)
def hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_node, "LAST_WORDS_S", 0.0)
    monkeypatch.setattr(run_node, "PUBLISH_PERIOD_S", 0.01)


def commanded(folder: Path, words: tuple[str, ...], **options: Any) -> tuple[NotedLink, list[Any], str]:
    """Run the tour as a node that receives commands; return link, answers and outcome."""
    link = NotedLink()
    node = RunNode(link, sleep=lambda seconds: time.sleep(min(seconds, 0.002)))
    commander = Commander(link, words)
    settings = {"backend": "kinematic", "settings": SETTINGS, "observers": (node, commander)}
    summary, _ = run_task(TOUR, folder, RunOptions(**(settings | options)))
    commander.join()
    return link, commander.answers, summary["outcome"]


def texts(link: NotedLink, topic: str) -> list[Any]:
    return [item.data for item in link.sent[f"handcart/{topic}"]]


def test_a_run_is_paused_continued_and_stopped_by_services(tmp_path: Path) -> None:
    link, answers, outcome = commanded(tmp_path, ("permit", "pause", "continue", "stop"))
    assert outcome == "Cancelled"
    permit, pause, go_on, stop = answers
    assert permit == (False, "no action waits for permission")
    assert pause.success and pause.message.startswith("paused while acting in ")
    assert go_on.success and go_on.message.startswith("acting in ")
    assert stop.success and stop.message.startswith("Cancelled: stopped by request")
    assert link.apart == ["handcart/stop"]
    assert link.closed.is_set()
    (run,) = [path for path in tmp_path.iterdir() if path.name != "latest"]
    status = [orjson.loads(text) for text in texts(link, "status")]
    assert status[-1]["state"] == "ended" and status[-1]["outcome"] == "Cancelled"
    assert status[0]["run"] == str(run)
    action = orjson.loads(texts(link, "action")[-1])
    assert (action["do"], action["state"]) == ("MOVE_TO", "broken off")
    assert {"kinematic"} == {orjson.loads((run / "summary.json").read_bytes())["backend"]}


def test_a_question_is_answered_only_once_it_can_have_been_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from handcart.evaluation.viewing.node import door

    monkeypatch.setattr(door, "NEW_QUESTION_S", 0.1)
    link = NotedLink()
    answers: list[Any] = []

    def answer() -> None:
        while not any(orjson.loads(text).get("asks") for text in texts(link, "status")):
            time.sleep(0.005)
        answers.append(link.services["handcart/permit"]())
        time.sleep(0.12)
        answers.append(link.services["handcart/refuse"]())
        answers.append(link.services["handcart/stop"]())

    node = RunNode(link, sleep=lambda _: None)
    asked = threading.Thread(target=answer, daemon=True)
    asked.start()
    settings = {"backend": "kinematic", "settings": SETTINGS, "permits": Permits("ask", step=True)}
    run_task(TOUR, tmp_path, RunOptions(**settings, observers=(node,)))  # type: ignore[arg-type]
    asked.join(timeout=10.0)
    early, later, stopped = answers
    assert not early.success and "is new; read it" in early.message
    assert later.success and stopped.success


def test_a_second_node_in_the_namespace_is_refused() -> None:
    with pytest.raises(SecondNode, match=r"handcart/stop.*--node-namespace"):
        check_alone(NotedLink(others=1), 0.1, sleep=lambda _: None)
    check_alone(NotedLink(), 0.1, sleep=lambda _: None)


def test_the_node_of_a_killed_run_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    link, said, slept = NotedLink(), list[str](), list[float]()
    monkeypatch.setattr(link, "servers", lambda name: int(len(slept) < 50))
    check_alone(link, 1.5, 60.0, said.append, slept.append)
    assert len(slept) == 50
    assert "waiting for up to 60 s" in said[0]
    with pytest.raises(SecondNode):
        check_alone(NotedLink(others=1), 1.5, 1.0, said.append, slept.append)


@pytest.mark.slow
def test_a_resumed_run_is_published_where_it_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Stopping(RunObserver):
        def event(self, event: Event) -> None:
            if isinstance(event, Started) and event.number == 2:
                interrupts.stop()

    task = tmp_path / "task.yaml"
    task.write_text(THERE_AND_BACK)
    for name in ("map.yaml", "map.png", "places.yaml"):
        shutil.copy(TOUR.with_name(name), tmp_path)
    (tmp_path / "world.yaml").write_text("format: handcart-world/1\nmap: map.yaml\n" + START)
    with Interrupts() as interrupts:
        options = RunOptions("kinematic", observers=(Stopping(),), interrupts=interrupts, checkpoints=True)
        summary, _ = run_task(task, tmp_path / "runs", options)
    link = NotedLink()
    node = RunNode(link, sleep=lambda _: None)
    monkeypatch.setattr(run_node, "PUBLISH_PERIOD_S", 100.0)  # begin and end alone are published
    again, _ = resume_task(Path(summary["run_dir"]), None, RunOptions(observers=(node,)))
    assert again["outcome"] == "Success"
    assert summary["situation"] == "there"
    assert texts(link, "situation")[0] == "there"
    assert orjson.loads(texts(link, "status")[-1])["outcome"] == "Success"
    assert "handcart/stop" in link.services and link.closed.is_set()


@pytest.mark.slow
def test_trouble_of_the_node_does_not_change_the_run(tmp_path: Path) -> None:
    class Broken(NotedLink):
        def spin(self, seconds: float) -> None:
            raise RuntimeError("the middleware is gone")

    said: list[str] = []
    node = RunNode(Broken(), said.append, sleep=lambda _: None)
    summary, status = run_task(
        TOUR, tmp_path, RunOptions(backend="kinematic", settings=SETTINGS, observers=(node,))
    )
    assert (summary["outcome"], status) == ("Success", 0)
    assert said == ["the node of ROS 2 has ended, the run continues: RuntimeError: the middleware is gone"]
