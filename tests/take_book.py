"""A task of two actions with an arm: the library's book is recognized on the tray and taken."""

from __future__ import annotations

from pathlib import Path

LIBRARY = Path(__file__).resolve().parents[1] / "tasks" / "return_book"
TAKE_BOOK = """\
format: handcart-task/1
title: Take the book
robot: {robot}
world: world.yaml
knowledge: {{map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}}
start: waiting
goal: in_hand
situations:
  waiting: {{base: home, book: on the tray}}
  book_known: {{base: home, book: on the tray}}
  in_hand: {{base: home, book: in hand}}
actions:
  - {{do: RECOGNIZE, from: waiting, to: book_known, cost_s: 8}}
  - {{do: PICK_UP, from: book_known, to: in_hand, cost_s: 15}}
"""


def write_take_book(folder: Path, robot: str = "librarian") -> Path:
    """Write the task beside the library's files; return its path."""
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        (folder / name).write_bytes((LIBRARY / name).read_bytes())
    path = folder / "task.yaml"
    path.write_text(TAKE_BOOK.format(robot=robot), encoding="utf-8")
    return path
