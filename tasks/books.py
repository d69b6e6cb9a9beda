"""Returning books to their shelves."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain, Knowledge

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "books",
    knowledge=Knowledge("handcart.primitives.books.books:Books", {"catalogue": "The books of a library."}),
    props="handcart.backends.scene.books.book_props:BookProps",
    primitives={
        "RECOGNIZE": "handcart.primitives.recognize:Recognize",
        "PICK_UP": "handcart.primitives.pick_up:PickUp",
        "SEARCH": "handcart.primitives.search:Search",
        "APPROACH": "handcart.primitives.approach:Approach",
        "INSERT": "handcart.primitives.insert:Insert",
        "RELEASE": "handcart.primitives.release:Release",
    },
    files={"catalogue": "handcart.primitives.knowledge:Catalogue"},
    rehearsals={_HERE / "return_book" / "task.yaml": {}},
)
