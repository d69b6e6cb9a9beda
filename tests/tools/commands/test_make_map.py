"""`handcart make-map`: a world's map, read back by the map's reader."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.files.maps.map_file import load_map
from handcart.tools.main import main

WORLD = """
format: handcart-world/1
start: {x_m: 1, y_m: 1}
walls: [{from_m: [0, 0], to_m: [3, 0]}]
furniture: [{name: crate, x_m: 2, y_m: 2, size_m: [0.4, 0.4, 0.5]}]
"""


def make(*words: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(["make-map", *words])
    return int(end.value.code or 0)


def test_map_of_a_world_is_read_back_as_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("world.yaml").write_text(WORLD, encoding="utf-8")
    assert make("world.yaml", "--out", "maps/plan.yaml", "--resolution", "0.05") == 0
    grid, warning = load_map(Path("maps/plan.yaml"))
    crate, free = grid.to_cell(np.array([[2.0, 2.0], [1.0, 1.0]]))
    assert (warning, bool(grid.occupied[tuple(crate)]), bool(grid.occupied[tuple(free)])) == (
        None,
        True,
        False,
    )
    assert not grid.unknown.any()


@pytest.mark.parametrize(
    ("out", "words"), [("plan.png", "ends in .yaml"), ("world.yaml", "it is the world's file")]
)
def test_bad_name_of_a_map_leaves_the_world_as_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], out: str, words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("world.yaml").write_text(WORLD, encoding="utf-8")
    assert make("world.yaml", "--out", out) == 2
    assert words in " ".join(capsys.readouterr().err.split())
    assert Path("world.yaml").read_text(encoding="utf-8") == WORLD


def test_map_with_a_special_name_is_read_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("world.yaml").write_text(WORLD, encoding="utf-8")
    assert make("world.yaml", "--out", "lab #2.yaml") == 0
    assert load_map(Path("lab #2.yaml"))[0].occupied.any()
