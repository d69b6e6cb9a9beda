"""No library's own warning or line reaches a user."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from handcart.tools.terminal.first_use import COMPILING_MESSAGE

ROOT = Path(__file__).resolve().parents[3]
LIBRARY = ROOT / "tasks" / "return_book"


def unannounced(stderr: str) -> list[str]:
    """The lines of stderr but for what a command says of itself that takes long."""
    return [line for line in stderr.splitlines() if not line.endswith(" ...") and line != COMPILING_MESSAGE]


def say(*words: object, strict: bool = True) -> subprocess.CompletedProcess[str]:
    """A command in a process of its own; `strict`: with warnings as errors."""
    line = [sys.executable, *(["-W", "error"] if strict else []), "-m", "handcart", *map(str, words)]
    return subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False, timeout=120)


@pytest.mark.parametrize(
    "words",
    [
        ("list", "backends"),
        ("describe", "MOVE_TO"),
        ("schema", "robot"),
        ("check", LIBRARY / "map.yaml"),
        pytest.param(("check", LIBRARY / "task.yaml"), marks=pytest.mark.slow),
        pytest.param(("check", ROOT / "backends/robots/cart/robot.yaml"), marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_commands_with_warnings_as_errors(words: tuple[object, ...]) -> None:
    said = say(*words)
    assert (said.returncode, unannounced(said.stderr)) == (0, [])


@pytest.mark.slow
def test_a_damaged_picture_is_told_by_us_alone(tour: Path) -> None:
    picture = tour.parent / "map.png"
    picture.write_bytes(picture.read_bytes()[:200])
    said = say("check", tour, strict=False)
    assert said.returncode == 2
    assert [line for line in unannounced(said.stderr) if "map" not in line] == []
    assert "OpenCV" not in said.stderr
    assert "libpng" not in said.stderr


def test_a_diagram_without_names_has_no_legend() -> None:
    from matplotlib.figure import Figure

    from handcart.evaluation.viewing.drawing.legend import add_legend

    axis = Figure().subplots()
    add_legend(axis)
    assert axis.get_legend() is None
    axis.plot([0, 1], label="something")
    add_legend(axis, fontsize=7)
    assert axis.get_legend() is not None
