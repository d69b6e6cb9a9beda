"""Causes of Fails and GiveUps that only tracking a seam has."""

from __future__ import annotations

from typing import Final

from handcart.primitives.outcomes.cause_kind import CauseKind

UNTRACKABLE: Final = CauseKind("untrackable", "The arm cannot track the seam from here.")
OFF_SEAM: Final = CauseKind("off_seam", "The tool leaves the seam.")
TOOL_CONTACT: Final = CauseKind("tool_contact", "The tool touches something.")
