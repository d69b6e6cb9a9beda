"""Tests of a seam's file: each error is reported with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.files.errors import FileError
from handcart.primitives.seam.seam_file import SEAM_COLUMNS, load_seam

SEAM = Path(__file__).parents[3] / "tasks" / "track_seam" / "seam.csv"


def changed(folder: Path, line: int, text: str) -> Path:
    """The shipped seam with another line, from 1."""
    lines = SEAM.read_text(encoding="utf-8").splitlines()
    lines[line - 1] = text
    path = folder / "seam.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_the_shipped_seam() -> None:
    seam = load_seam(SEAM)
    assert seam.length == pytest.approx(5.13, abs=0.01)
    assert seam.points[:, 2].max() - seam.points[:, 2].min() > 0.4


@pytest.mark.parametrize(
    ("line", "text", "wanted"),
    [
        (1, "x,y,z", r"seam.csv:1:1: these are not columns of a seam; allowed: x_m,y_m,z_m,roll_deg,"),
        (9, "2.1,nan,0.7,0,35,90", r"seam.csv:9:5: y_m is 'nan'; allowed: a finite number"),
        (9, "2.1,4.0,high,0,35,90", r"seam.csv:9:9: z_m is 'high'; allowed: a finite number"),
        (9, "2.1,4.0", r"seam.csv:9:1: 2 values; allowed: 6"),
        (9, "3.1,4.0,0.7,0,35,90", r"seam.csv:9:1: this point jumps by .* m; allowed: 0.05 m a step"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(tmp_path: Path, line: int, text: str, wanted: str) -> None:
    with pytest.raises(FileError, match=wanted):
        load_seam(changed(tmp_path, line, text))


def test_a_repeated_point_and_a_seam_of_one_are_refused(tmp_path: Path) -> None:
    lines = SEAM.read_text(encoding="utf-8").splitlines()
    with pytest.raises(FileError, match=r":7:1: this point repeats the position before it; allowed: "):
        load_seam(changed(tmp_path, 7, lines[5]))
    path = tmp_path / "one.csv"
    path.write_text(",".join(SEAM_COLUMNS) + "\n0,0,1,0,0,0\n", encoding="utf-8")
    with pytest.raises(FileError, match=r"one.csv:2:1: 1 points; allowed: two or more"):
        load_seam(path)


def test_a_seam_as_strangers_write_it_is_refused(tmp_path: Path) -> None:
    """T2, T9"""
    head, path = ",".join(SEAM_COLUMNS) + "\n", tmp_path / "seam.csv"
    for text, wanted in (
        (head + "0,0,1,0,0,0\n" * 50_001, r"seam.csv:50002:1: more than 50000 rows"),
        (head + "9" * 30_000, r"seam.csv:2:1: a line of more than 20000 characters"),
        (
            head + "1e300,0,1,0,0,0\n1,0,1,0,0,0\n",
            r"seam.csv:2:1: x_m is '1e300'; allowed: a finite number up",
        ),
        (head + "1_0,0,1,0,0,0\n1,0,1,0,0,0\n", r"seam.csv:2:1: x_m is '1_0'"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(FileError, match=wanted):
            load_seam(path)
