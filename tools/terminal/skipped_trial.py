"""Message about a trial that readers of a campaign skip, because its line is damaged."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from handcart.files.printable import printable

if TYPE_CHECKING:
    from handcart.evaluation.campaigns.data.trial_log import TrialFile


def with_note(trials: TrialFile, folder: Path) -> TrialFile:
    """Return the trials of a campaign's folder; say on stderr if the last one is missing."""
    note_skipped(folder, trials.skipped_bytes)
    return trials


def note_skipped(folder: Path, skipped_bytes: int) -> None:
    """Say on stderr that the last line of a campaign's log is damaged, if it has any such bytes."""
    if skipped_bytes:
        words = f"the last line of its log is damaged or being written ({skipped_bytes} bytes)"
        print(printable(f"{folder}: {words}: its trial is skipped"), file=sys.stderr)
