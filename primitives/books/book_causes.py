"""Causes of Fails and GiveUps that only work with books has."""

from __future__ import annotations

from typing import Final

from handcart.primitives.outcomes.cause_kind import CauseKind

UNKNOWN_BOOK: Final = CauseKind("unknown_book", "The book is not in the catalogue, or has no call number.")
NO_SLOT: Final = CauseKind("no_slot", "The shelf has no free slot for the book.")
JAMMED: Final = CauseKind("jammed", "The book jams while it is pushed in.")
PROTRUDES: Final = CauseKind("protrudes", "The book protrudes from the shelf.")
NEIGHBOUR_PUSHED: Final = CauseKind("neighbour_pushed", "The push may have moved another book.")
