"""Causes of Fails that only calibration has."""

from __future__ import annotations

from typing import Final

from handcart.primitives.outcomes.cause_kind import CauseKind

NOT_OBSERVABLE: Final = CauseKind("not_observable", "The views do not determine the parameters.")
