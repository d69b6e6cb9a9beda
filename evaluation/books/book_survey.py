"""Survey of the books' places, and of the robot's stopping errors on the way there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from typing_extensions import override

from handcart.backends.simulation.books.book_props import BookProps
from handcart.evaluation.judging.survey import Survey, SurveyedRun
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.outcomes.outcome import Outcome, Success

from .book_effects import BOOK_EFFECTS, RELEASE
from .shelving import Shelving, shelving
from .stop_errors import stop_errors


@dataclass(frozen=True)
class BookNotes:
    """Observations of the return of books (`BookSurvey`) made so far in a run, which the run could not make
    again when it is resumed.
    """

    accessions: tuple[int, ...] | None
    """Accession numbers of the books to return; None if no books are returned."""
    fronts: list[tuple[int, float]]
    """Accession number of each standing book, with the initial x of its spine in the shelf's frame, in
    [m].
    """
    labels: int
    stops: dict[str, float]


class BookSurvey(Survey):
    """Evaluation of how a run has returned books, by their true poses before and after the run."""

    name = "books"
    effects = BOOK_EFFECTS
    noted = BookNotes
    shown = frozenset({"SEARCH"})

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self._labels, self._stops = 0, dict[str, float]()
        self._shelving: Shelving | None = None
        """Books to return, and the initial state of the shelves; None if the task returns no book."""
        self._books = run.world.of(BookProps)
        first = self._books.tray_book()
        if RELEASE in run.does and first is not None:
            others = [item.accession for item in self._books.to_come]
            self._shelving = shelving(self._books, (first.accession, *others))

    @classmethod
    def applies(cls, run: SurveyedRun) -> bool:
        """Return whether this evaluation applies to a run: it has shelves, or has to return books.

        If the run has shelves but returns no books, only the errors of the base's stops in front of shelves
        are measured.
        """
        return super().applies(run) or bool(run.scene is not None and run.scene.of(BookProps).shelves)

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        self._labels += int(primitive.facts.get("labels_read", 0))
        if isinstance(outcome, Success):
            self._stops |= stop_errors(self.run.world, primitive)
        return []

    @override
    def notes(self) -> BookNotes:
        first = self._shelving
        accessions, fronts = (None, {}) if first is None else (first.accessions, first.fronts)
        return BookNotes(accessions, list(fronts.items()), self._labels, self._stops)

    @override
    def go_on(self, noted: BookNotes) -> None:
        self._labels, self._stops = noted.labels, noted.stops
        self._shelving = None
        if noted.accessions is not None:
            self._shelving = Shelving(noted.accessions, dict(noted.fronts))

    @override
    def figures(self) -> dict[str, Any]:
        if self._shelving is None:
            return self._stops
        stands = self._shelving.judge(self._books)
        return {**self._stops, **stands.figures(), "labels_read": self._labels}

    def faults(self) -> list[str]:
        """Return a message if a returned book is in a wrong place or pose, or if other books were pushed.

        A message shows that the Success of the complete run is false.
        """
        stands = None if self._shelving is None else self._shelving.judge(self._books)
        return [] if stands is None or stands.right else [str(stands)]
