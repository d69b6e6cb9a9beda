"""Comparison of a measured size with its limit."""

from __future__ import annotations

import math

import pytest

from handcart.primitives.outcomes.exceeds import exceeds


@pytest.mark.parametrize(
    ("size", "above"), [(0.9, False), (1.0, False), (1.1, True), (math.inf, True), (math.nan, True)]
)
def test_a_size_without_a_number_exceeds_every_limit(size: float, above: bool) -> None:
    assert exceeds(size, 1.0) is above
