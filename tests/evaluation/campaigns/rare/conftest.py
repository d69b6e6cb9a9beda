"""Tasks whose rare ends are known exactly."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.campaigns import tosses as known
from handcart.primitives import registry


@pytest.fixture
def tosses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of a task whose runs give up after four tosses that failed; `likely` is how often one does."""
    names = registry._all() | known.TOSS_PRIMITIVE
    monkeypatch.setattr(registry, "_all", lambda: names)
    return known.tosses(tmp_path)
