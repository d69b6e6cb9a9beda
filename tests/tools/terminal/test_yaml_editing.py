"""Edited YAML files keep what nobody asked to change."""

from __future__ import annotations

import re
from typing import Any

import pytest

from handcart.tools.terminal.yaml_editing import edited, with_comments

COUNT = re.compile(r"\d+ of \d+")
ROWS = """\
rows:
  - {do: A, text: "a # b"}

  # one
  - {do: B,
     x: 1}  # mine
  - do: C
    with: &shared {x: 1}
  - do: D  # two
    with: *shared
  - do: E
    text: |
      hello

      # no comment
  - do: F
    list:
      - a
      - b # seen: 3 of 4 times
  # three
  - do: G
    x:
  - {do: H}
other: [1]
"""
COMMENTED = """\
rows:
  - {do: A, text: "a # b"}  # 0 of 9

  # one
  - {do: B,
     x: 1}  # mine; 1 of 9
  - do: C
    with: &shared {x: 1}  # 2 of 9
  - do: D  # two
    with: *shared  # 3 of 9
  - do: E  # 4 of 9
    text: |
      hello

      # no comment
  - do: F
    list:
      - a
      - b # seen: 5 of 9 times
  # three
  - do: G
    x:  # 6 of 9
  - {do: H}  # 7 of 9
other: [1]
"""


def test_a_comment_stands_at_the_end_of_its_item() -> None:
    comments = {number: f"{number} of 9" for number in range(8)}
    once = with_comments(ROWS, "rows", comments, COUNT)
    assert once == COMMENTED
    assert with_comments(once, "rows", comments, COUNT) == COMMENTED
    again = with_comments(once, "rows", {1: "2 of 10"}, COUNT)
    assert again == COMMENTED.replace("1 of 9", "2 of 10")


@pytest.mark.parametrize(
    ("text", "after"),
    [
        ('rows: [{do: A}, {do: "B # x"}]\n', 'rows: [{do: A}, {do: "B # x"}]  # 1 of 9\n'),
        ("rows: [\n  {do: A}, # x\n  {do: B}\n]", "rows: [\n  {do: A}, # x; 0 of 9\n  {do: B}  # 1 of 9\n]"),
        (
            "one: &one {do: A}\nrows:\n  - *one\n  - {do: B}",
            "one: &one {do: A}\nrows:\n  - *one\n  - {do: B}  # 1 of 9",
        ),
    ],
)
def test_items_without_a_line_of_their_own_get_no_comment(text: str, after: str) -> None:
    assert with_comments(text, "rows", {0: "0 of 9", 1: "1 of 9"}, COUNT) == after


@pytest.mark.parametrize(
    "text",
    [
        "rows:\n  - {p: 1}\n  # before\n  - {p: 2}  # behind\n  - {p: 3}\n",
        "rows:\n  - [1]\n\n  # before\n\n  # too\n  - [2]  # behind\n\n  - [3] # behind\n",
        "rows:\n  # first\n  - {p: 1}  # behind\n  # before\n  - p: 2 # behind\n# the end\n",
    ],
)
def test_comments_before_and_behind_a_value_are_kept(text: str) -> None:
    assert edited(text, lambda data: None) == text


LONG_ROWS = """\
rows:
  - {do: A, p: 0.5,
     with: [1,
            2]}  # mine
  - {do: B, p: 0.5,
     x: &x {y: 1,
            z: 2}}
  - do: C
    text: in
      two lines
    again: *x
"""


def test_values_keep_their_lines_where_one_of_them_is_changed() -> None:
    def change(data: Any) -> None:
        data["rows"][1]["p"] = 0.7

    assert edited(LONG_ROWS, lambda data: None) == LONG_ROWS
    assert edited(LONG_ROWS, change) == LONG_ROWS.replace("{do: B, p: 0.5", "{do: B, p: 0.7")


def test_lines_that_do_not_fit_a_new_indentation_are_joined() -> None:
    """The list is indented, and its rows would begin to the left of it."""
    text = "rows:\n- do:\n  - {a: 1,\n   b: 2}\n"
    after = edited(text, lambda data: data["rows"].append(1))
    assert after == "rows:\n  - do:\n      - {a: 1, b: 2}\n  - 1\n"
