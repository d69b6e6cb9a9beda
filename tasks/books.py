"""Returning books to their shelves."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "books",
    primitives={
        "RECOGNIZE": "handcart.primitives.recognize:Recognize",
        "PICK_UP": "handcart.primitives.pick_up:PickUp",
        "SEARCH": "handcart.primitives.search:Search",
        "APPROACH": "handcart.primitives.approach:Approach",
        "INSERT": "handcart.primitives.insert:Insert",
        "RELEASE": "handcart.primitives.release:Release",
    },
    survey="handcart.evaluation.book_survey:BookSurvey",
    files={"catalogue": "handcart.primitives.knowledge:Catalogue"},
    rehearsals={_HERE / name / "task.yaml": {} for name in ("return_book", "return_books")},
)
