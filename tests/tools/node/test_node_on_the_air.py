"""A run's node through the middleware, from another process. Runs where rclpy is installed."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

import orjson
import pytest

from handcart.backends.ros2.wire.ros_link import node_name
from handcart.backends.ros2.wire.serving_link import Answer, RosServingLink

pytest.importorskip(
    "rclpy", reason="rclpy is not installed; needed: the extra ros2, apart", exc_type=ImportError
)
from tests.middleware import Client, passes_messages

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # of a parser that rclpy imports
]
TEST_NUMBERS = count()
RUN = ("run", "drive_map", "--robot", "cart", "--backend", "kinematic", "--node", "--no-report")


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep this test's topics on this machine, and apart from those of others and of the test before."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(100 + (os.getpid() + 50 + 7 * next(TEST_NUMBERS)) % 100))
    monkeypatch.setenv("ROS_PYTHON_CHECK_FIELDS", "1")
    if not passes_messages():
        pytest.skip("the middleware passes no messages between two nodes of this machine")


@pytest.fixture
def client(alone: None) -> Iterator[Client]:
    found = Client()
    yield found
    found.close()


@contextmanager
def running(words: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Run a program, and kill it at the end: a failed test would wait for it for ever."""
    with subprocess.Popen(words, text=True, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def test_a_stop_is_answered_while_another_answer_takes_long(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(multiprocessing, "cpu_count", lambda: 1)
    link, over = RosServingLink(node_name("busy")), threading.Event()
    link.serve("busy", lambda: Answer(over.wait(20.0), "late"))
    link.serve("stop", lambda: Answer(True, "stopped"), apart=True)
    spinning = threading.Thread(target=lambda: [link.spin(0.05) for _ in iter(over.is_set, True)])
    spinning.start()
    try:
        waits = client.send("busy")
        begun = time.monotonic()
        assert client.call("stop").message == "stopped"
        assert time.monotonic() - begun < 8.0 and not waits.done()
    finally:
        over.set()
        spinning.join()
        link.close()


def test_a_requested_run_begins_and_a_second_one_is_refused(client: Client, tmp_path: Path) -> None:
    words = [sys.executable, "-m", "handcart", "node", "drive_map", "--robot", "cart"]
    words += ["--backend", "kinematic", "--runs", str(tmp_path)]
    with running(words, stdout=subprocess.DEVNULL) as desk:
        first = client.call("handcart/run/drive_map", 240.0)
        assert first.success, first.message
        again = client.call("handcart/run/drive_map")
        assert not again.success and "one at a time" in again.message
        assert client.call("handcart/stop", 30.0).success
        desk.terminate()
        assert desk.wait(timeout=60.0) == 143


def test_a_kinematic_run_is_watched_stopped_and_resumed(client: Client, tmp_path: Path) -> None:
    words = [sys.executable, "-m", "handcart", *RUN, "--runs", str(tmp_path)]
    status: list[Any] = []
    client.listen("std_msgs/String", "handcart/status", lambda item: status.append(orjson.loads(item.data)))
    kinds = {
        "handcart/markers": "visualization_msgs/MarkerArray",
        "handcart/map": "nav_msgs/OccupancyGrid",
        "handcart/pose": "geometry_msgs/PoseWithCovarianceStamped",
        "/diagnostics": "diagnostic_msgs/DiagnosticArray",
    }
    seen: dict[str, Any] = {}
    for topic, kind in kinds.items():
        client.listen(kind, topic, partial(seen.__setitem__, topic))
    with running(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as run:
        client.wait(lambda: len(seen) == len(kinds) and bool(status), 240.0)
        assert seen["/diagnostics"].status[0].level == b"\0"
        assert client.call("handcart/pause").success
        client.wait(lambda: status[-1]["state"] == "paused while acting", 30.0)
        answer = client.send("handcart/stop")
        begun = time.monotonic()
        client.wait(answer.done, 15.0)
        stopped = answer.result()
        assert stopped.success and "Cancelled" in stopped.message
        assert time.monotonic() - begun < 3.0
        assert run.wait(timeout=60.0) == 130
    client.wait(lambda: status[-1]["state"] == "ended", 30.0)
    (folder,) = tmp_path.glob("drive_map-*")
    status.clear()
    words = [sys.executable, "-m", "handcart", "resume", str(folder), "--node"]
    with running(words, stdout=subprocess.DEVNULL) as run:
        client.wait(lambda: bool(status) and status[-1]["state"] == "acting", 240.0)
        assert status[-1]["run"] == str(folder)
        assert client.call("handcart/stop").success
        assert run.wait(timeout=60.0) == 130
