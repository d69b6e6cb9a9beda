"""Contents of a drawn network, in which nothing overlaps or is clipped."""

from __future__ import annotations

from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest

from handcart.networks.drawing.figure import figure_of
from handcart.networks.drawing.network_picture import (
    DrawnBox,
    DrawnFrame,
    DrawnLink,
    NetworkPicture,
    draw_network,
)
from handcart.networks.graph.network import Action, ActionNetwork, Situation
from handcart.networks.past_runs.journaled_network import NamedBinding
from handcart.networks.task.task_file import load_task
from tests.drawn_texts import faults_of

TASKS = sorted(
    path
    for path in (Path(__file__).parents[3] / "tasks").glob("*/*.yaml")
    if path.read_text(encoding="utf-8").count("handcart-task/1")
)


@pytest.fixture(scope="module", params=TASKS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def picture(request: pytest.FixtureRequest) -> NetworkPicture:
    task = load_task(request.param)
    return draw_network(task.network, title=task.file.title)


def apart(a: DrawnBox | DrawnFrame, b: DrawnBox | DrawnFrame) -> bool:
    beside = a.x + a.width <= b.x or b.x + b.width <= a.x
    return beside or a.y + a.height <= b.y or b.y + b.height <= a.y


def along(link: DrawnLink) -> np.ndarray:
    """(n, 2) points of it."""
    share = np.linspace(0.0, 1.0, 24)[:, None]
    points, begin = [], np.array(link.points[0])
    for p, q, end in link.curves():
        before, middle, after, last = (
            (1 - share) ** 3,
            3 * (1 - share) ** 2 * share,
            3 * (1 - share) * share**2,
            share**3,
        )
        points.append(before * begin + middle * np.array(p) + after * np.array(q) + last * np.array(end))
        begin = np.array(end)
    return np.concatenate(points)


@pytest.mark.slow
def test_no_two_texts_overlap_and_none_is_clipped(picture: NetworkPicture) -> None:
    assert faults_of(figure_of(picture)) == []


@pytest.mark.slow
def test_texts_are_as_wide_as_they_are_drawn(picture: NetworkPicture) -> None:
    axes = figure_of(picture).axes[0]
    for text, drawn in zip(picture.texts, axes.texts, strict=True):
        assert drawn.get_window_extent().width == pytest.approx(text.width, abs=0.03 * text.width + 2.0)


def test_boxes_are_apart_and_hold_their_texts(picture: NetworkPicture) -> None:
    assert all(apart(a, b) for a, b in combinations(picture.boxes, 2))
    for box in picture.boxes:
        assert all(box.x < t.left and t.left + t.width < box.x + box.width for t in box.texts)
        assert all(box.y < t.y - t.size and t.y < box.y + box.height for t in box.texts)
    drawn: list[DrawnBox | DrawnFrame] = [*picture.boxes, *picture.frames]
    for item in drawn:
        assert 0 <= item.x < item.x + item.width <= picture.width
        assert 0 <= item.y < item.y + item.height <= picture.height


def test_no_link_passes_through_a_box(picture: NetworkPicture) -> None:
    for link in picture.links:
        x, y = along(link).T
        for box in picture.boxes:
            inside = (
                (x > box.x + 1) & (x < box.x + box.width - 1) & (y > box.y + 1) & (y < box.y + box.height - 1)
            )
            assert not inside.any(), box.texts[0].words


def test_no_picture_is_higher_than_a_page(picture: NetworkPicture) -> None:
    assert picture.height < 1000.0  # a field of 200 targets, too


def a_network(*names: str, elements: dict[str, str] | None = None) -> ActionNetwork:
    return ActionNetwork.build(
        [Situation(name, {}, (elements or {}).get(name)) for name in names],
        [
            Action(a, b, NamedBinding(name="GO", parameters={"place": b}), permit=a == "here")
            for a, b in pairwise(names)
        ],
        names[0],
        names[-1],
    )


def test_copies_of_a_repeat_are_one_box_that_counts_them_all() -> None:
    words = {"there[1]": "way[1] (north)", "there[2]": "way[2] (south)"}
    network = a_network("here", "there[1]", "there[2]", "done", elements=words)
    drawn = draw_network(network, [(1, "Fail"), (1, "Success")])
    assert [box.texts[0].words for box in drawn.boxes if box.kind == "situation"] == ["there"]
    assert [frame.title.words for frame in drawn.frames] == ["for each way, 2 times: north, south"]
    (mixed,) = [box for box in drawn.boxes if box.kind == "mixed"]
    said = [text.words for text in mixed.texts]
    assert said == ["GO", "1 s", "place: there[2] … done", "1 Success, 1 Fail"]
    assert mixed == drawn.box(action=2)
    assert drawn.box("there[2]").texts[0].words == "there"


def test_what_a_person_permits_is_drawn() -> None:
    drawn = draw_network(a_network("here", "there"))
    assert [text.words for text in drawn.box(action=0).texts] == [
        "GO",
        "1 s, operator permits",
        "place: there",
    ]


def test_a_fail_has_not_come_to_the_target() -> None:
    failed = draw_network(a_network("here", "there"), [(0, "Fail")])
    assert [link.travelled for link in failed.links] == [True, False]
    went = draw_network(a_network("here", "there"), [(0, "Success")])
    assert [link.travelled for link in went.links] == [True, True]


def test_numbers_that_no_repeat_made_stay() -> None:
    drawn = draw_network(a_network("shelf[1]", "shelf[2]"))
    assert [drawn.box(name).texts[0].words for name in ("shelf[1]", "shelf[2]")] == ["shelf[1]", "shelf[2]"]


def test_letters_that_the_font_lacks_have_room() -> None:
    drawn = draw_network(a_network("書架" * 6, "there"))
    box = drawn.box("書架" * 6)
    assert box.width > 12 * 12.0
