"""World model section of books."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from typing_extensions import override

from handcart.primitives.books.catalogue import Book, Catalogue
from handcart.primitives.knowledge.section import Section
from handcart.robotics.geometry.pose2 import Pose2

NO_BOOKS = Catalogue(format="handcart-catalogue/1", books=())


class Slot(NamedTuple):
    """Gap in a row of books for the book to insert: its sides in the shelf frame, and its neighbours."""

    shelf: str
    """Name of the place with the shelf."""
    left: float
    """y of the left neighbour's side, in [m]."""
    right: float
    """y of the right neighbour's side, in [m]; less than `left`."""
    sigma: float
    """Standard deviation of both sides, in [m]."""
    after: str
    """Call number of the left neighbour; empty at the end of the row."""
    before: str
    """Call number of the right neighbour."""
    sides: tuple[float, ...] = ()
    """y of the sides of books to the left of the slot, including the slot's own left side, in [m]."""

    def moved(self, y: float) -> Slot:
        """Return the slot moved along the shelf by `y` in [m], positive to the left, together with the
        neighbours' sides that bound it.
        """
        sides = tuple(side + y for side in self.sides)
        return self._replace(left=self.left + y, right=self.right + y, sides=sides)


@dataclass
class Books(Section):
    """World model section for returning books, with the robot's knowledge of the books and their slots."""

    FILES: ClassVar = {"catalogue": Catalogue}
    LEARNED: ClassVar = ("book", "book_pose", "slot")
    ELEMENT: ClassVar = LEARNED

    catalogue: Catalogue = NO_BOOKS
    book: Book | None = None
    """Book that is to be returned."""
    book_pose: Pose2 | None = None
    """base_T_book of the book on the tray: middle of its spine, x along its depth."""
    slot: Slot | None = None

    @override
    def noted(self) -> dict[str, Any]:
        return {
            "book": self.book.accession if self.book else None,
            "book_pose": list(self.book_pose) if self.book_pose else None,
            "slot": list(self.slot) if self.slot else None,
        }
