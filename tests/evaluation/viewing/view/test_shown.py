"""Conversion of a run's data into what a browser shows."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from handcart.evaluation.viewing.playback.playback import Playback
from handcart.evaluation.viewing.playback.scenery import RobotShape
from handcart.evaluation.viewing.playback.seven import seven
from handcart.evaluation.viewing.view.boxes import unit_box
from handcart.evaluation.viewing.view.network_window import NetworkWindow
from handcart.evaluation.viewing.view.rays import rays_of
from handcart.evaluation.viewing.view.recorded_frames import PATH_STEP_M, RecordedFrames
from handcart.evaluation.viewing.view.time_line import LINE_WIDTH, time_line
from handcart.networks.drawing.styles import HIGHLIGHT_COLOUR
from handcart.networks.graph.network import Action, ActionNetwork, Situation
from handcart.networks.past_runs.journaled_network import NamedBinding
from handcart.networks.past_runs.past_run import PastAction
from handcart.robotics.geometry.transform import transform


def test_a_box_is_closed_and_looks_outwards() -> None:
    corners, triangles = unit_box()
    a, b, c = (corners[triangles[:, k]].astype(float) for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(1.0)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) > 0.0).all()


def test_a_ray_ends_where_the_sensor_hit_something() -> None:
    robot = RobotShape(
        name="cart", urdf="", footprint_m=0.3, angles_rad=(0.0, np.pi / 2, 1.0), base_t_sensor=(0.2, 0.0, 0.0)
    )
    base = np.array(seven(transform((1.0, 2.0, 0.0), (0.0, 0.0, np.pi / 2))))
    lines = rays_of(robot, np.array([1.5, 2.0, np.inf]), base, 0.25)
    assert lines[:, 0] == pytest.approx(np.array([(1.0, 2.2, 0.25)] * 2))
    assert lines[:, 1] == pytest.approx(np.array([(1.0, 3.7, 0.25), (-1.0, 2.2, 0.25)]))


def an_action(number: int, source: str, target: str, start: float, end: float, **more: object) -> PastAction:
    fields = {"broken_off": None, "outcome": "Success", **more}
    return PastAction(number, 0, "GO", source, target, {}, start, end, **fields)  # type: ignore[arg-type]


def test_the_network_is_lit_where_the_run_is() -> None:
    names = ("here", "there[1]", "there[2]", "<done>")
    network = ActionNetwork.build(
        [Situation(name, {}) for name in names],
        [Action(a, b, NamedBinding(name="GO")) for a, b in pairwise(names)],
        "here",
        "<done>",
    )
    window = NetworkWindow(network, ())
    still, running = window.svg("there[2]", None), window.svg("here", an_action(1, "here", "there[1]", 0, 1))
    assert still.count(HIGHLIGHT_COLOUR) == 1
    assert re.search(rf"{HIGHLIGHT_COLOUR}[^/]*/>\s*<text[^>]*>there", still)
    assert running.count(HIGHLIGHT_COLOUR) == 2
    assert "&lt;done&gt;" in still
    assert "<done>" not in still


def test_the_time_line_has_bars_as_long_as_the_actions() -> None:
    actions = [
        an_action(1, "a", "b", 10.0, 30.0),
        an_action(2, "b", "b", 30.0, 50.0, outcome="Fail", broken_off=40.0),
    ]
    svg = time_line(actions, 10.0, 50.0, 20.0)
    found = re.findall(r'<rect x="([\d.]+)" y="\d+" width="([\d.]+)"', svg)[1:]
    bars = [(float(x), float(wide)) for x, wide in found]
    assert bars == [
        (0.0, LINE_WIDTH / 2 - 2.0),
        (LINE_WIDTH / 2, LINE_WIDTH / 2 - 2.0),
        (0.75 * LINE_WIDTH, 0.25 * LINE_WIDTH - 2.0),
        (0.25 * LINE_WIDTH, 6.0),
    ]
    assert time_line([], 0.0, 0.0, 0.0)


def test_a_frame_is_the_same_from_before_and_from_after(toured: Path) -> None:
    playback = Playback.read(toured)
    middle = (playback.start + playback.end) / 2
    forwards, backwards = RecordedFrames(playback), RecordedFrames(playback)
    forwards.at(playback.start)
    backwards.at(playback.end)
    one, other = forwards.at(middle), backwards.at(middle)
    assert one.rays is not None
    assert other.rays is not None
    assert np.array_equal(one.rays, other.rays)
    assert one.driven is not None
    assert other.driven is not None
    assert np.array_equal(one.driven, other.driven)
    assert np.array_equal(one.moment.base, other.moment.base)
    assert one.situation == other.situation
    assert forwards.at(middle).rays is None
    steps = np.linalg.norm(np.diff(one.driven, axis=0), axis=1)
    assert steps.max() < 3 * PATH_STEP_M


def test_the_situation_is_that_of_the_journal(toured: Path) -> None:
    playback = Playback.read(toured)
    end = playback.run.end
    assert end is not None
    assert playback.situation(playback.end + 1.0) == end["situation"]
    for action in playback.run.actions:
        assert playback.situation((action.start + action.end) / 2) == action.source
    moving = playback.run.actions[0]
    assert len(playback.planned(moving.number)) > 2
    assert playback.planned(99).shape == (0, 2)
