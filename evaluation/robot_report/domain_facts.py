"""Facts about a robot that a domain reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple


class FactTable(NamedTuple):
    """A table for people."""

    heading: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


class DomainFacts(NamedTuple):
    """Facts about a robot that is to work in a domain."""

    remarks: Sequence[str] = ()
    """Things that the robot lacks for the domain, each as "missing thing: who needs it"."""
    figures: Mapping[str, Any] = {}
    """The facts as JSON values."""
    tables: Sequence[FactTable] = ()
