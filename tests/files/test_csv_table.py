"""Cells of a CSV file as numbers."""

from __future__ import annotations

import math

import pytest

from handcart.backends.can.eds.eds_text import number
from handcart.files.csv_table import number_in


@pytest.mark.parametrize(("cell", "value"), [("1.5", 1.5), ("-2e3", -2000.0), ("+7", 7.0)])
def test_a_decimal_number_is_read(cell: str, value: float) -> None:
    assert number_in(cell) == value


@pytest.mark.parametrize("cell", ["", "x", "1_0", "0x10", "٣", "１２", "3٫5", "१०"])
def test_what_only_python_takes_for_a_number_is_none(cell: str) -> None:
    """Digits of other scripts, as a translated spreadsheet may hold them, are never guessed at."""
    assert math.isnan(number_in(cell))
    if cell != "0x10":
        with pytest.raises(ValueError, match=r"number|invalid literal"):
            number(cell)
