from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra view isn't installed")

import viser

from handcart.evaluation.viewing.playback.playback import Playback, PlaybackMoment
from handcart.evaluation.viewing.view.frame import Frame
from handcart.evaluation.viewing.view.panel import Panel
from handcart.evaluation.viewing.view.replay import Replay
from handcart.evaluation.viewing.view.serving.server import LOOPBACK_HOST, NoView, open_server
from handcart.networks.past_runs.past_run import PastAction


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    with open_server(0, "test") as opened:
        yield opened.server


@pytest.fixture
def replay(server: viser.ViserServer, toured: Path) -> Replay:
    return Replay(server, Playback.read(toured))


@pytest.mark.slow
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


@pytest.mark.slow
def test_the_panel_says_why_the_shown_action_was_chosen(replay: Replay) -> None:
    replay.go_to(1.0)
    replay.step(0.0)
    shown = replay._page.panel._why_text.content
    assert "Why this action?" in shown and "cheapest way to the goal" in shown


def test_any_time_can_be_gone_to(replay: Replay, toured: Path) -> None:
    playback = Playback.read(toured)
    for time, shown in ((3.3, 3.3), (-5.0, playback.start), (1e9, playback.end), (1.0, 1.0)):
        replay.go_to(time)
        replay.step(0.0)
        assert replay.time == pytest.approx(shown)


def test_u10_names_that_are_programs_are_text_in_the_panel(server: viser.ViserServer) -> None:
    """Viser takes its content as HTML."""
    bad = "<img src=x onerror=alert(1)>"
    panel = Panel(server, bad, bad)
    moment = PlaybackMoment(0.5, 0.5, np.zeros(3), None, np.zeros(0), 0.0, np.zeros((3, 3)), 1, True)
    action = PastAction(1, 0, bad, bad, bad, {}, 0.0, 1.0, None, "")
    frame = Frame(moment, bad, {})
    for item in (panel._words(frame, action, True), panel._words(frame, action, False)):
        assert "<img" not in item
        assert item.count("&lt;img src=x onerror=alert(1)&gt;") >= 3


def test_a_taken_port_is_told() -> None:
    with socket.socket() as taken:
        taken.bind((LOOPBACK_HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        said = f"--port: the port {port} can't be listened on: .*; allowed: a free one"
        with pytest.raises(NoView, match=said), open_server(port, "test"):
            pass
