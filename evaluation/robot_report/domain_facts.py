"""Facts that a domain reports on a robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple


class FactTable(NamedTuple):
    """A table of facts for people: a heading, columns and rows."""

    heading: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


class DomainFacts(NamedTuple):
    """Facts that an application domain reports on a robot, such as its reach in the domain's tasks, or parts
    that it lacks.
    """

    remarks: Sequence[str] = ()
    """Things that the robot lacks, each with the part of the domain that needs it."""
    figures: Mapping[str, Any] = {}
    """The facts as JSON values."""
    tables: Sequence[FactTable] = ()
