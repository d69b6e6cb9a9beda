"""Required content of the hand before a primitive, and its content after Success."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class Hand(Enum):
    """Content of the hand that a primitive requires at its start or leaves at its end, such as empty or
    full.
    """

    EMPTY = "empty"
    FULL = "full"
    """The hand holds one thing: the primitive's `thing`, or any if that has no name."""
    SAME = "same"
    """Unchanged."""
    ANY = "any"
    """Something or nothing; as `before`, no content is required, as `after`, none is known."""


class HandUse(NamedTuple):
    """Content of the hand that a primitive requires at its start, and the content after its Success."""

    before: Hand = Hand.ANY
    """Required content of the hand at the start (EMPTY, FULL or ANY)."""
    after: Hand = Hand.SAME
    """Content of the hand after Success."""


USES_NO_FINGERS = HandUse(Hand.ANY, Hand.SAME)
"""The primitive moves no finger."""
USE_UNDECLARED = HandUse(Hand.ANY, Hand.ANY)
"""The primitive moves the fingers and does not state what they hold."""
TAKES_OBJECT = HandUse(Hand.EMPTY, Hand.FULL)
CARRIES_OBJECT = HandUse(Hand.FULL, Hand.SAME)
LETS_GO = HandUse(Hand.FULL, Hand.EMPTY)
NEEDS_EMPTY = HandUse(Hand.EMPTY, Hand.SAME)
