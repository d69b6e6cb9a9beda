"""A shelf of books and the robot's book, as the text of a world file."""

from __future__ import annotations

from collections.abc import Sequence

GAP = "gap_mm: 31"
BOOKS = {
    101: "call: 512.2 ABE, thickness_mm: 45, height_mm: 210, depth_mm: 150, grey: 120",
    102: "call: 512.3 ART, thickness_mm: 45, height_mm: 200, depth_mm: 140, grey: 90",
    103: "call: 512.5 BOR, thickness_mm: 40, height_mm: 220, depth_mm: 150, grey: 150",
    104: "call: 512.8 POI, thickness_mm: 28, height_mm: 200, depth_mm: 150, grey: 125",
    105: "call: 512.9 SER, thickness_mm: 33, height_mm: 220, depth_mm: 150, grey: 95",
    106: "call: 513.1 WEY, thickness_mm: 27, height_mm: 210, depth_mm: 150, grey: 145",
    117: "call: 512.7 NAG, thickness_mm: 25, height_mm: 210, depth_mm: 150, grey: 115",
}
ROOM_WALLS = """\
walls:
  - {from_m: [0, 0], to_m: [4, 0]}
  - {from_m: [4, 0], to_m: [4, 3]}
  - {from_m: [4, 3], to_m: [0, 3]}
  - {from_m: [0, 3], to_m: [0, 0]}
"""
"""A room of 4 x 3 m."""


def shelf_text(row: Sequence[int | str]) -> str:
    """Return the keys `shelves` and `tray`: accessions from left to right, or `GAP`; 117 is on the tray."""
    books = "".join(f"      - {{{entry if isinstance(entry, str) else _book(entry)}}}\n" for entry in row)
    shelf = "name: shelf_1\n    x_m: 2.0\n    y_m: 2.0\n    heading_deg: 90\n    width_m: 0.4\n    books:\n"
    return f"shelves:\n  - {shelf}{books}tray: {{{_book(117)}}}\n"


def _book(accession: int) -> str:
    return f"accession: {accession}, {BOOKS[accession]}"
