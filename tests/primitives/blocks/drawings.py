"""Drawings of small walls."""

from __future__ import annotations

from pathlib import Path

from handcart.files.models.loading import Loaded, load_document
from handcart.files.yaml.yaml_document import read_document
from handcart.primitives.blocks.drawing import Drawing

TWO_AND_ONE = """\
  - {x_m: 4.1, y_m: 1.82, height_m: 0.44, heading_deg: -90, along_mm: [45]}
  - {x_m: 4.1, y_m: 1.82, height_m: 0.4, heading_deg: -90, along_mm: [0, 90]}
"""
TABLE_HEIGHT = 0.4


def drawing_file(folder: Path, rows: str = TWO_AND_ONE, height: float = TABLE_HEIGHT) -> Path:
    """A drawing whose rows, from its line 17 on, are those; the wall's table is that high, in [m]."""
    file = folder / "drawing.yaml"
    file.write_text(
        "format: handcart-drawing/1\n"
        "start: {x_m: 2.8, y_m: 0.8}\n"
        "block_mm: [25, 80, 40]\n"
        "landmarks:\n"
        "  supply: {x_m: 1.5, y_m: 1.72, height_m: 0.4}\n"
        f"  wall: {{x_m: 4.2, y_m: 1.72, height_m: {height}}}\n"
        "tables:\n"
        "  supply table: {x_m: 1.5, y_m: 1.95, height_m: 0.4, size_m: [0.76, 0.66]}\n"
        f"  stacking table: {{x_m: 4.2, y_m: 1.95, height_m: {height}, size_m: [0.76, 0.66]}}\n"
        "supply:\n"
        "  - {x_m: 1.41, y_m: 1.82, height_m: 0.4, heading_deg: 90}\n"
        "  - {x_m: 1.50, y_m: 1.82, height_m: 0.4, heading_deg: 90}\n"
        "  - {x_m: 1.59, y_m: 1.82, height_m: 0.4, heading_deg: 90}\n"
        "carried:\n"
        "  - {x_m: -0.36, y_m: 0.0, height_m: 0.45}\n"
        f"rows:\n{rows}",
        encoding="utf-8",
    )
    return file


def load_drawing(file: Path) -> Loaded[Drawing]:
    """Read one."""
    return load_document(read_document(file), Drawing)
