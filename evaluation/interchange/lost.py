"""Constructs of other formats that a task cannot express."""

from __future__ import annotations

from typing import Any, NamedTuple

from handcart.files.errors import Finding


class LostConstruct(NamedTuple):
    """Element of an imported file (such as a state machine) that a task cannot express with the same
    meaning.
    """

    line: int
    """Its line in the file, from 1; 0 for objects in memory."""
    column: int
    construct: str
    """The construct as the file names it."""
    meaning: str
    """Replacement in the task."""

    def finding(self, file: str) -> Finding:
        """Return a finding that a task cannot express this construct, at its place in the imported file."""
        return Finding(file, self.line, self.column, f"{self.construct} is not expressed; {self.meaning}")


class Imported(NamedTuple):
    """Task that was imported from a file in another format, with those constructs of the file that a task
    cannot express.
    """

    data: dict[str, Any]
    """Content of the task's file."""
    lost: tuple[LostConstruct, ...]
    """Everything that could not be expressed, in the order of the lines."""
