"""Tests of residuals: their labels in journals, and what counts as motion."""

from __future__ import annotations

import math
from typing import Any

import pytest

from handcart.primitives.outcomes.residual import Residual, ResidualKind, Residuals, read_residuals

KINDS = [kind for kind in ResidualKind if kind not in (ResidualKind.OBJECT, ResidualKind.OTHER)]


@pytest.mark.parametrize("kind", KINDS)
def test_a_residual_of_the_robot_reads_back_from_its_label(kind: ResidualKind) -> None:
    assert Residual.from_label(kind.value, 1.0, 2.0) == Residual(kind, 1.0, 2.0)


@pytest.mark.parametrize("name", ["cup", "unsure_box", "base_mm", "a mm", "object x mm", " ", "held"])
def test_a_residual_of_an_object_reads_back_from_its_label(name: str) -> None:
    of_object = Residual(ResidualKind.OBJECT, 1.0, 2.0, name)
    assert Residual.from_label(of_object.label, 1.0, 2.0) == of_object
    assert of_object.label == f"object {name} mm"


@pytest.mark.parametrize("label", ["", "object", "mast_mm", "object cup", "objects cup mm"])
def test_a_label_of_another_version_is_kept_as_it_is(label: str) -> None:
    found = read_residuals({label: 3.0}, {label: 2.0})
    assert [(item.kind, item.label, item.is_motion) for item in found.all] == [
        (ResidualKind.OTHER, label, True)
    ]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("value", [math.inf, math.nan, 2.001])
def test_all_beyond_its_limit_moved_unless_it_is_an_uncertainty(kind: ResidualKind, value: float) -> None:
    found = Residuals([Residual(kind, value, 2.0)])
    assert list(found.beyond) == [kind.value]
    assert list(found.moved) == [kind.value] * ("unsure" not in kind.value)


def test_values_of_a_journal_without_limits_are_within_them() -> None:
    found = read_residuals({"base_mm": 31.0, "object cup mm": None}, {})
    assert dict(found) == {"base_mm": 31.0, "object cup mm": math.inf}
    assert not found.beyond
    assert found.limits == {"base_mm": None, "object cup mm": None}
    assert found.words == "base_mm 31, object cup mm inf"


def test_residuals_equal_a_mapping_of_their_values() -> None:
    found: Any = read_residuals({"base_mm": 312.4, "held": None}, {"base_mm": 25.0, "held": 0.0})
    assert found == {"base_mm": 312.4, "held": math.inf}
    assert found.words_with_limits == "base_mm 312 (at most 25), held inf (at most 0)"
    assert repr(found) == "Residuals(base_mm 312, held inf)"
