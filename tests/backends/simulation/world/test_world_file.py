from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.errors import FileError
from handcart.files.models.loading import load

HEAD = "format: handcart-world/1\nstart: {x_m: 0, y_m: 0}\n"
BOOK = "{accession: 1, call: 512.7 NAG, thickness_mm: 30, height_mm: 200, depth_mm: 150}"


def read(tmp_path: Path, text: str) -> Any:
    path = tmp_path / "world.yaml"
    path.write_text(HEAD + text, encoding="utf-8")
    return load(path, world_model())


def test_the_smallest_world_is_an_empty_floor(tmp_path: Path) -> None:
    world = read(tmp_path, "")
    assert (world.walls, world.shelves, world.tray) == ((), (), None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("walls: [{from_m: [0, 0], to_m: [0, 0]}]\n", "no length"),
        (f"tray: {BOOK.replace('30', '3')}\n", "thickness"),
        (f"tray: {BOOK.replace('accession: 1', 'accession: 300')}\n", "below 250"),
        (
            "surprises: [{name: a, x_m: 0, y_m: 0, size_m: [1, 1, 1], appears_s: 3, leaves_s: 2}]\n",
            "leaves before",
        ),
        (
            f"shelves: [{{name: s, x_m: 0, y_m: 0, width_m: 0.1, books: [{BOOK}, {{gap_mm: 71}}]}}]\n",
            "101.0 mm",
        ),
        (
            f"tray: {BOOK}\nshelves: [{{name: s, x_m: 0, y_m: 0, books: [{BOOK}]}}]\n",
            "accession 1 is there twice",
        ),
        ("colour: red\n", "colour"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(FileError, match=message):
        read(tmp_path, text)
