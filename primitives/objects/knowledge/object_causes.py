"""Causes of Fails and GiveUps that only work with objects has."""

from __future__ import annotations

from typing import Final

from handcart.primitives.outcomes.cause_kind import CauseKind

NOT_TAKEN: Final = CauseKind("not_taken", "Nobody took the object from the hand.")
PULLED: Final = CauseKind("pulled", "Somebody pulls at the object in the hand before it is offered.")
