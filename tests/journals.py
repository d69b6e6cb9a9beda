"""Journals of two runs, compared."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handcart.networks.journal.journal_record import read_journal


def timeless_records(path: Path) -> list[dict[str, Any]]:
    """Return the records of a journal without their times of the wall clock: equal in runs with one seed."""
    records = read_journal(path).records
    return [{key: value for key, value in record.items() if key != "wall"} for record in records]
