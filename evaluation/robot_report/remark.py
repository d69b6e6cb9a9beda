"""Remarks on a robot, each with its place in a file; similar remarks are grouped in one line."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from handcart.files.errors import Finding

_DIFFERS = re.compile(r"'[^']*'|-?\d[\d.e+-]*|\S*/\S*")
_SHOWN = 4


class Remark(NamedTuple):
    """Doubtful property of a robot's file or URDF that a person should know but that is not an error."""

    subject: str
    """Subject such as `link 'base'`; empty: the robot."""
    what: str
    place: Finding | None = None
    """Place in a file, if it is known; the finding's own message is ignored."""

    def __str__(self) -> str:
        words = f"{self.subject}: {self.what}" if self.subject else self.what
        return words if self.place is None else str(Finding(*_spot(self.place), words))


def grouped(remarks: Iterable[Remark]) -> list[str]:
    """Return a line for each group of remarks that are alike except for numbers, paths and quoted names.

    The line shows the group's first remark, and the subjects of the others. Remarks on the robot itself have
    no subject; they have a line each.
    """
    kinds: dict[tuple[str, str], list[Remark]] = {}
    for remark in remarks:
        kind = _DIFFERS.sub("", remark.what) if remark.subject else remark.what  # a subject tells them apart
        kinds.setdefault((remark.subject.split(" ")[0], kind), []).append(remark)
    return [_line(kind) for kind in kinds.values()]


def grouped_findings(findings: Sequence[Finding]) -> list[str]:
    """Return a line for each group of findings that are alike except for numbers, paths and quoted names.

    The line shows the group's first finding, and the line numbers of the others.
    """
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        kinds.setdefault((finding.file, _DIFFERS.sub("", finding.message)), []).append(finding)
    return [str(kind[0]) + _more([str(other.line) for other in kind[1:]], "line") for kind in kinds.values()]


def _line(alike: Sequence[Remark]) -> str:
    names = [remark.subject.partition(" ")[2].strip("'") for remark in alike[1:]]
    return str(alike[0]) + _more(names, alike[0].subject.split(" ")[0])


def _more(names: Sequence[str], kind: str) -> str:
    if not names:
        return ""
    shown = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
    return f" (and {len(names)} more {kind}{'s' if len(names) > 1 else ''}: {shown})"


def _spot(place: Finding) -> tuple[str, int, int]:
    return place.file, place.line, place.column
