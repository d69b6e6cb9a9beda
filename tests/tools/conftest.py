"""The command line, in this process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from handcart.tools.main import main
from handcart.tools.terminal import first_use

LIBRARY = Path(__file__).resolve().parents[2] / "tasks" / "return_book"
TOUR = """\
format: handcart-task/1
title: Drive to a shelf
robot: librarian
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: at_home
goal: at_shelf
situations: {at_home: {base: home}, at_shelf: {base: shelf}}
actions:
  - {do: MOVE_TO, from: at_home, to: at_shelf, cost_s: 30, with: {place: shelf_3}}
"""


@dataclass(frozen=True)
class Said:
    """Output of a command, and its exit status."""

    status: int
    out: str
    err: str


@pytest.fixture
def handcart(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[..., Said]:
    """Runs `handcart ...`; however slow the machine, nothing is said of its taking long."""
    monkeypatch.setattr(first_use, "SILENT_TIME_S", 3600.0)

    def run(*words: object) -> Said:
        capsys.readouterr()
        with pytest.raises(SystemExit) as end:
            main([str(word) for word in words])
        printed = capsys.readouterr()
        return Said(int(end.value.code or 0), printed.out, printed.err)

    return run


@pytest.fixture
def tour(tmp_path: Path) -> Path:
    """A task that drives to a shelf, in a folder with the library's files."""
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        (tmp_path / name).write_bytes((LIBRARY / name).read_bytes())
    path = tmp_path / "tour.yaml"
    path.write_text(TOUR, encoding="utf-8")
    return path
