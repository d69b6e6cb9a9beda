"""Classes of bodies in physics, for `handcart.tasks.domain`."""

from __future__ import annotations

from handcart.backends.simulation.books.book import SimulatedBook

from .book_body import BookBody

PROP_BODIES = {SimulatedBook: BookBody}
