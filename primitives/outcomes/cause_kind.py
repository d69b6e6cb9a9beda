"""Kinds of causes: why a motion ended, as one word that programs and task files can compare."""

from __future__ import annotations

from typing import NamedTuple


class CauseKind(NamedTuple):
    """Kind of cause of a Fail or GiveUp, such as an obstacle or a faulty sensor, as one word.

    A domain or another package declares its own kinds as constants of a module, and raises `Discrepancy` or
    `NeedsPerson` with them.
    """

    name: str
    """Word for files and tables: lower case, with underscores."""
    text: str
    """Sentence for people."""
