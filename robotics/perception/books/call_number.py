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
    """Call number of a book, which is ordered like books on a shelf.

    Its parts are `dewey` ("512"), `decimals` as written ("7" for 512.7, may be empty) and `letters` ("NAG").
    Decimals are compared digit by digit, so 512.15 comes before 512.7; equal numbers are ordered by their
    letters. 512.7 and 512.70 are equal.
    """

    dewey: str
    decimals: str
    letters: str

    @property
    def place(self) -> tuple[str, str, str]:
        """Key by which call numbers are compared and sorted, without zeros at the end of the decimals."""
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
    """Return the call number written in `text`; None if the text is not one. Spaces and case are ignored."""
    match = _PATTERN.fullmatch(text.upper())
    return CallNumber(match[1], match[2] or "", match[3]) if match else None


def snap(text: str, catalogue: Sequence[CallNumber], distance: int = 2) -> CallNumber | None:
    """Return the known call number nearest to a text; None if there are several, or if none is near enough.

    Args:
        text: text as it was read.
        catalogue: known call numbers.
        distance: largest number of edits (Levenshtein) between the text and a call number.
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
    """Return Levenshtein's distance between two texts, or `limit` + 1 if it is above `limit`."""
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
