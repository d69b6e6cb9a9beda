"""Returning books to their shelves."""

from __future__ import annotations

from pathlib import Path

from .domain import Command, Domain, Knowledge

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "books",
    knowledge=Knowledge("handcart.primitives.books.books:Books", {"catalogue": "The books of a library."}),
    props="handcart.backends.simulation.books.book_props:BookProps",
    physics="handcart.backends.physics.books.bodies:PROP_BODIES",
    primitives={
        "RECOGNIZE": "handcart.primitives.books.recognize:Recognize",
        "PICK_UP": "handcart.primitives.books.pick_up:PickUp",
        "SEARCH": "handcart.primitives.books.search:Search",
        "APPROACH": "handcart.primitives.books.approach:Approach",
        "INSERT": "handcart.primitives.books.insert:Insert",
        "RELEASE": "handcart.primitives.books.release:Release",
    },
    survey="handcart.evaluation.books.book_survey:BookSurvey",
    files={"catalogue": "handcart.primitives.books.catalogue:Catalogue"},
    checks="handcart.evaluation.books.tag_check:TAG_CHECKS",
    mutants="handcart.evaluation.books.book_mutants:BOOK_MUTANTS",
    worlds={"library": "handcart.evaluation.books.library_files:Libraries"},
    commands={
        "make-library": Command(
            "handcart.tools.books.make_library:make_library",
            "Write a library: world, map, places, catalogue.",
        )
    },
    robot_facts="handcart.evaluation.books.book_reach:book_facts",
    rehearsals={_HERE / "return_book" / "task.yaml": {}, _HERE / "return_books" / "task.yaml": {}},
)
