"""Which classes stand for what in physics; see `handcart.tasks.domain`."""

from __future__ import annotations

from handcart.backends.simulation.books.book import Book

from .book_body import BookBody

BODIES = {Book: BookBody}
