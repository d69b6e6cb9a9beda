"""Tests of the order in which a drawing can be built."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.primitives.blocks.laying_order import laying_orders, wall_findings
from tests.primitives.blocks.drawings import drawing_file, load_drawing

ROW = "  - {{x_m: 4.1, y_m: 1.82, height_m: {}, heading_deg: -90, along_mm: [{}]}}\n"


def test_no_block_is_laid_before_what_carries_it(tmp_path: Path) -> None:
    rows = "".join(
        ROW.format(f"{0.4 + 0.04 * n:.2f}", ", ".join(map(str, range(45 * n, 271, 90)))) for n in (2, 1, 0)
    )
    drawing = load_drawing(drawing_file(tmp_path, rows)).value
    orders = laying_orders(drawing)
    assert len(orders) == 2
    for order in orders:
        assert sorted(order) == sorted(drawing.blocks)
        for at, block in enumerate(order):
            for below in drawing.blocks:
                carries = abs(below.place.height_m + 0.04 - block.place.height_m) < 1e-6
                if carries and abs(below.place.x_m - block.place.x_m) < 0.08:
                    assert below in order[:at]
    heights = [block.place.height_m for block in orders[0]]
    assert np.all(np.diff(heights) >= 0.0)


def test_a_drawing_that_can_be_built_has_no_fault(tmp_path: Path) -> None:
    assert list(wall_findings(load_drawing(drawing_file(tmp_path)))) == []


@pytest.mark.parametrize(
    ("rows", "line", "words"),
    [
        (ROW.format(0.4, "0, 70"), 17, "block 2 of row 1 stands in block 1 of row 1"),
        (ROW.format(0.4, "0") + ROW.format(0.48, "0"), 18, "nothing carries block 1 of row 2"),
        (ROW.format(0.4, "0") + ROW.format(0.44, "45"), 18, "block 1 of row 2 tips over"),
        (ROW.format(0.4, "900"), 17, "nothing carries block 1 of row 1"),
        (ROW.format(0.4, "-170, -80, 10, 100"), 11, "3 blocks wait for a wall of 4"),
    ],
)
def test_what_nobody_could_build_is_named_with_its_line(
    tmp_path: Path, rows: str, line: int, words: str
) -> None:
    findings = list(wall_findings(load_drawing(drawing_file(tmp_path, rows))))
    assert [finding.line for finding in findings] == [line]
    assert words in findings[0].message
