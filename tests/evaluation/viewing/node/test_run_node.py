"""A real run, published and commanded through a link that notes all."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

import orjson
import pytest

from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.running import run_task
from handcart.evaluation.viewing.node import run_node
from handcart.evaluation.viewing.node.run_node import RunNode, SecondNode, check_alone
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.operator.permits import Permits
from handcart.networks.runs.run_options import RunOptions

from .noted_link import NotedLink

TOUR = Path(__file__).parents[4] / "tasks" / "drive_map" / "task.yaml"
SETTINGS = {"robot": "cart", "tour": "[desk]"}


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
    return [each.data for each in link.sent[f"handcart/{topic}"]]


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
    (run,) = [each for each in tmp_path.iterdir() if each.name != "latest"]
    status = [orjson.loads(each) for each in texts(link, "status")]
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
        while not any(orjson.loads(each).get("asks") for each in texts(link, "status")):
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
        check_alone(NotedLink(others=1), 0.1, lambda _: None)
    check_alone(NotedLink(), 0.1, lambda _: None)


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
