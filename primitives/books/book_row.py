"""Contacts of a held book in its slot."""

from __future__ import annotations

from handcart.primitives.books.books import Books
from handcart.primitives.books.catalogue import name_of_book
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import WorldModel

SHELF_PARTS = ("board", "panel", "left panel", "right panel", "book end")
"""Parts of a shelf, by their names in the world."""


def row_contacts(model: WorldModel, shelf: str) -> tuple[MeantContact, ...]:
    """Return the intended contacts of the held book with its shelf and the two neighbours of its slot."""
    known = model.of(Books)
    slot = known.slot
    beside = () if slot is None else tuple(call for call in (slot.after, slot.before) if call)
    books = [name_of_book(book) for book in known.catalogue.books if book.call in beside]
    return tuple(
        MeantContact("held", name) for name in (*(f"{part} of {shelf}" for part in SHELF_PARTS), *books)
    )
