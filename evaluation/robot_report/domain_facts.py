"""What a domain tells of a robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple


class FactTable(NamedTuple):
    """A table for people."""

    heading: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


class DomainFacts(NamedTuple):
    """What a domain tells of a robot that is to work in it."""

    remarks: Sequence[str] = ()
    """What the robot lacks for it, each "what is missing: who needs it"."""
    figures: Mapping[str, Any] = {}
    """For programs."""
    tables: Sequence[FactTable] = ()
