from __future__ import annotations

import http.client
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="the extra view isn't installed")

import viser

from handcart.evaluation.playback.playback import Playback
from handcart.evaluation.view.replay import Replay
from handcart.evaluation.view.server import HOST, NoView, open_server


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    with open_server(0, "test") as opened:
        yield opened.server


@pytest.fixture
def replay(server: viser.ViserServer, toured: Path) -> Replay:
    return Replay(server, Playback.read(toured))


def test_it_plays_to_the_end_and_stands_there(replay: Replay, toured: Path) -> None:
    end = Playback.read(toured).end
    assert not replay.step(1.0), "it doesn't play by itself"
    replay.play(True)
    assert replay.step(1.0)
    assert replay.time == pytest.approx(1.0)
    assert replay.step(1e6)
    assert replay.time == end
    assert not replay.step(1.0)
    replay.play(True)
    replay.step(0.5)
    assert replay.time == pytest.approx(0.5), "from the end it begins anew"


def test_any_time_can_be_gone_to(replay: Replay, toured: Path) -> None:
    playback = Playback.read(toured)
    for time, shown in ((3.3, 3.3), (-5.0, playback.start), (1e9, playback.end), (1.0, 1.0)):
        replay.go_to(time)
        replay.step(0.0)
        assert replay.time == pytest.approx(shown)


def test_it_is_served_to_this_machine_alone(server: viser.ViserServer) -> None:
    port = server.get_port()
    page = http.client.HTTPConnection(HOST, port, timeout=10)
    page.request("GET", "/")
    assert page.getresponse().status == 200
    page.close()
    everywhere = socket.gethostbyname(socket.gethostname())
    if not everywhere.startswith("127."):
        with pytest.raises(OSError):
            socket.create_connection((everywhere, port), timeout=5).close()


def test_a_taken_port_is_told() -> None:
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        said = f"--port: the port {port} can't be had: .*; allowed: a free one"
        with pytest.raises(NoView, match=said), open_server(port, "test"):
            pass
