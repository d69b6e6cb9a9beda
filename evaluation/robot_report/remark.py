"""What is doubtful about a robot, each at its place, and many of a kind in one line."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from handcart.files.errors import Finding

_DIFFERS = re.compile(r"'[^']*'|-?\d[\d.e+-]*|\S*/\S*")
_SHOWN = 4


class Remark(NamedTuple):
    """Something that a person should know of, though nothing refuses it."""

    subject: str
    """Such as `link 'base'`; empty: the robot."""
    what: str
    place: Finding | None = None
    """Where that stands, where a file tells; its own message doesn't count."""

    def __str__(self) -> str:
        words = f"{self.subject}: {self.what}" if self.subject else self.what
        return words if self.place is None else str(Finding(*_spot(self.place), words))


def grouped(remarks: Iterable[Remark]) -> list[str]:
    """A line for each kind of remark: the first one, and of what else the same is true."""
    kinds: dict[tuple[str, str], list[Remark]] = {}
    for each in remarks:
        kinds.setdefault((each.subject.split(" ")[0], _DIFFERS.sub("", each.what)), []).append(each)
    return [_line(each) for each in kinds.values()]


def grouped_findings(findings: Sequence[Finding]) -> list[str]:
    """The same for findings: how many more lines of a file have the same fault."""
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for each in findings:
        kinds.setdefault((each.file, _DIFFERS.sub("", each.message)), []).append(each)
    return [str(each[0]) + _more([str(other.line) for other in each[1:]], "line") for each in kinds.values()]


def _line(alike: Sequence[Remark]) -> str:
    names = [each.subject.partition(" ")[2].strip("'") for each in alike[1:]]
    return str(alike[0]) + _more(names, alike[0].subject.split(" ")[0])


def _more(names: Sequence[str], kind: str) -> str:
    if not names:
        return ""
    shown = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
    return f" (and {len(names)} more {kind}{'s' if len(names) > 1 else ''}: {shown})"


def _spot(place: Finding) -> tuple[str, int, int]:
    return place.file, place.line, place.column
