from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.drawing.overlay import draw_overlay
from handcart.robotics.perception.landmarks.tag_reader import Tag

GREY = np.full((240, 420), 128, np.uint8)


def label(x: float, text: str) -> Label:
    corners = np.array([[x, 100.0], [x + 20.0, 100.0], [x + 20.0, 180.0], [x, 180.0]])
    return Label(text, None, 0.0, corners, 0.0, 0.0, 0.0, 0.0)


def written(*labels: Label) -> int:
    """How many pixels the words take, shadow and all: those of the outlines aside."""
    words = np.any(draw_overlay(GREY, labels=labels) != draw_overlay(GREY), axis=2)
    return int(words[:99].sum())


@pytest.mark.parametrize("apart", [3.0, 12.0, 40.0])
def test_words_keep_clear_of_each_other(apart: float) -> None:
    near = [label(60.0 + apart * number, f"word {number}") for number in range(3)]
    alone = sum(written(item) for item in near)
    assert written(*near) == alone


def test_words_stay_on_the_picture() -> None:
    inside = written(label(200.0, "a long word"))
    assert written(label(415.0, "a long word")) == inside


def test_what_has_no_room_left_is_written_all_the_same() -> None:
    corners = np.array([[10.0, 2.0], [30.0, 2.0], [30.0, 20.0], [10.0, 20.0]])
    many = [Tag(number, corners) for number in range(50)]
    assert np.any(draw_overlay(GREY, many) != draw_overlay(GREY))
