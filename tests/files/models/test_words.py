"""Errors, suggestions, units, schemas: the small parts."""

import copy

import pytest
from pydantic import Field, TypeAdapter

from handcart.files.errors import FileError, Finding, HandcartError, InputError, UnsafePath
from handcart.files.findings import Findings
from handcart.files.models.json_schema import SCHEMA_DIALECT, schema
from handcart.files.models.model import FileModel
from handcart.files.models.units import unit_of
from handcart.files.suggest import listed, nearest, suggest


def test_statuses_of_errors() -> None:
    assert HandcartError.exit_status == 5
    assert InputError.exit_status == FileError.exit_status == UnsafePath.exit_status == 2
    assert issubclass(FileError, HandcartError)
    assert issubclass(FileError, ValueError)


def test_findings_in_the_order_of_lines_and_once() -> None:
    late, early = Finding("f", 10, 1, "b"), Finding("f", 9, 1, "a")
    error = FileError([late, early, late])
    assert error.findings == (early, late)
    assert str(error) == "f:9:1: a\nf:10:1: b"


def test_errors_cross_processes() -> None:
    error = copy.copy(FileError([Finding("f", 1, 2, "x")]))  # by the same way as between processes
    assert error.findings == (Finding("f", 1, 2, "x"),)
    assert copy.copy(UnsafePath("/x", "is absolute")).reason == "is absolute"


def test_no_findings_no_error() -> None:
    findings = Findings()
    findings.raise_all()
    assert not findings


@pytest.mark.parametrize(
    ("name", "allowed", "said"),
    [
        ("sped", ["place", "speed"], "; did you mean 'speed'? allowed: place, speed"),
        ("INSERT", ["Insert", "Search"], "; did you mean 'Insert'? allowed: Insert, Search"),
        ("zzz", ["place", "speed"], "; allowed: place, speed"),
        ("x", [], "; allowed: nothing"),
    ],
)
def test_suggestions(name: str, allowed: list[str], said: str) -> None:
    assert suggest(name, allowed) == said


def test_long_lists_are_cut() -> None:
    assert listed(str(n) for n in range(20)) == "0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11 and 8 more"
    assert nearest("x" * 10_000, ["xx"]) is None


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("width_mm", "mm"),
        ("speed_m_s", "m/s"),
        ("angle_random_walk_deg_rt_s", "deg/√s"),
        ("rate_random_walk_deg_s_rt_s", "deg/s/√s"),
        ("bias_walk_m_rt_s", "m/√s"),
        ("wait_s", "s"),
        ("turn_deg", "deg"),
        ("name", ""),
        ("items", ""),
    ],
)
def test_units(key: str, unit: str) -> None:
    assert unit_of(key) == unit


class Book(FileModel):
    """A book on a shelf."""

    width_mm: float = Field(ge=15, le=45)
    """Thickness across the spine, in [mm]."""


def test_schema_for_editors() -> None:
    found = schema(Book)
    assert found["$schema"] == SCHEMA_DIALECT
    assert (found["title"], found["description"]) == ("Book", "A book on a shelf.")
    assert found["additionalProperties"] is False
    assert found["properties"]["width_mm"]["description"] == "Thickness across the spine, in [mm]."
    assert found["properties"]["width_mm"]["maximum"] == 45
    assert schema(TypeAdapter(list[Book]), "Books")["title"] == "Books"
