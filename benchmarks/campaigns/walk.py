"""A small task with probabilities of its actions, for campaigns of the network alone."""

from __future__ import annotations

import shutil
from pathlib import Path

LIBRARY_FOLDER = Path(__file__).parents[2] / "tasks" / "return_book"
TASK_TEXT = """\
format: handcart-task/1
title: Drive to a shelf
robot: librarian
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: at_home
goal: at_shelf
situations: {at_home: {base: home}, between: {}, at_shelf: {base: shelf}}
actions:
  - {do: MOVE_TO, from: at_home, to: between, cost_s: 20, p: P, p_give_up: 0.02, with: {place: shelf_1}}
  - {do: MOVE_TO, from: at_home, to: between, cost_s: 50, attempts: 1, p: 0.7, with: {place: shelf_5}}
  - {do: MOVE_TO, from: between, to: at_shelf, cost_s: 30, attempts: 3, p: 0.9, with: {place: shelf_3}}
"""


def walk(folder: Path, p: float = 0.85) -> Path:
    """Return the task's file, written into a folder with all that it names.

    Args:
        folder: exists.
        p: probability of the first action's Success.
    """
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        shutil.copy(LIBRARY_FOLDER / name, folder / name)
    path = folder / "walk.yaml"
    path.write_text(TASK_TEXT.replace("p: P", f"p: {p}"), encoding="utf-8")
    return path
