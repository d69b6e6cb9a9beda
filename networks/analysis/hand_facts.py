"""Facts of a situation about the robot's hand."""

from __future__ import annotations

from collections.abc import Mapping

from handcart.networks.graph.network import Fact
from handcart.primitives.preconditions.hand_use import Hand

HAND_FACTS = ("hand", "gripper")
"""Names of facts whose value is the content of the hand."""
EMPTY_WORDS = ("empty", "free", "nothing", "holds nothing")
FULL_WORDS = ("full", "holds ", "holding ")
IN_HAND = ("in hand", "in the hand")


def hand_by_facts(facts: Mapping[str, Fact]) -> tuple[Hand, str]:
    """Return whether the facts of a situation say that the hand is full or empty, with the fact as text.

    The result is `Hand.ANY` with an empty text if no fact says so.
    """
    for name, value in facts.items():
        if not isinstance(value, str):
            continue
        words, said = value.strip().casefold(), f"{name}: {value}"
        if words in IN_HAND or (
            name in HAND_FACTS and words.startswith(FULL_WORDS) and words not in EMPTY_WORDS
        ):
            return Hand.FULL, said
        if name in HAND_FACTS and words in EMPTY_WORDS:
            return Hand.EMPTY, said
    return Hand.ANY, ""
