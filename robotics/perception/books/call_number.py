"""Call numbers ("512.7 NAG"): a Dewey class, then letters, in the order of a library's shelf."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import total_ordering

_PATTERN = re.compile(r"\s*(\d{3})(?:\s*\.\s*(\d{1,6}))?\s*([A-Z]{1,4})\s*", re.ASCII)


@total_ordering
@dataclass(frozen=True, eq=False)
class CallNumber:
    """A call number: `dewey` ("512"), `decimals` as written ("7" of 512.7, may be empty), `letters` ("NAG").

    Shelf order is digit by digit, so 512.15 comes before 512.7, then by letters. 512.7 and 512.70 are two
    spellings of one number and equal.
    """

    dewey: str
    decimals: str
    letters: str

    @property
    def place(self) -> tuple[str, str, str]:
        """Key of order and equality. Zeros at the end of a decimal fraction are ignored."""
        return self.dewey, self.decimals.rstrip("0"), self.letters

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CallNumber) and self.place == other.place

    def __hash__(self) -> int:
        return hash(self.place)

    def __lt__(self, other: CallNumber) -> bool:
        return self.place < other.place

    def __str__(self) -> str:
        fraction = f".{self.decimals}" if self.decimals else ""
        return f"{self.dewey}{fraction} {self.letters}"


def parse(text: str) -> CallNumber | None:
    """Return the call number written in `text`, or None. Spaces and case are forgiven, anything else is
    not.
    """
    match = _PATTERN.fullmatch(text.upper())
    return CallNumber(match[1], match[2] or "", match[3]) if match else None


def snap(text: str, catalogue: Sequence[CallNumber], distance: int = 2) -> CallNumber | None:
    """Return the known call number nearest to a text, at most `distance` edits away; None for a tie, or if
    none is that near.
    """
    read = text.replace(" ", "").upper()
    exact = {known for known in catalogue if str(known).replace(" ", "") == read}
    if exact:
        return exact.pop() if len(exact) == 1 else None
    nearest, found = distance + 1, set[CallNumber]()
    for known in catalogue:
        edits = edit_distance(read, str(known).replace(" ", ""), min(nearest, distance))
        if edits < nearest:
            nearest, found = edits, set()
        if edits == nearest <= distance:
            found.add(known)
    return found.pop() if len(found) == 1 else None


def edit_distance(a: str, b: str, limit: int) -> int:
    """Levenshtein's distance between two texts; anything above `limit` is given as `limit` + 1."""
    if abs(len(a) - len(b)) > limit:
        return limit + 1
    row = list(range(len(b) + 1))
    for i, letter in enumerate(a, start=1):
        diagonal, row[0] = row[0], i
        for j, other in enumerate(b, start=1):
            diagonal, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, diagonal + (letter != other))
        if min(row) > limit:
            return limit + 1
    return min(row[-1], limit + 1)
