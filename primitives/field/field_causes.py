"""Causes of Fails and GiveUps that only work with sensors in a field has."""

from __future__ import annotations

from typing import Final

from handcart.primitives.outcomes.cause_kind import CauseKind

MAGAZINE_EMPTY: Final = CauseKind("magazine_empty", "The magazine gives no sensor.")
TOPPLED: Final = CauseKind("toppled", "The sensor fell over.")
