"""`handcart export`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import handcart as face
from tests.tools.conftest import Said


def test_a_campaigns_trials_are_exported(handcart: Callable[..., Said], tour: Path, tmp_path: Path) -> None:
    tour.write_text(tour.read_text(encoding="utf-8").replace("cost_s: 30", "cost_s: 30, p: 0.5"), "utf-8")
    out, file = tmp_path / "out", tmp_path / "trials.parquet"
    face.campaign(tour, trials=30, level="network", out=out)
    said = handcart("export", out, "-o", file)
    assert (said.status, said.out) == (0, f"written: {file}, 30 trials\n")
    assert file.read_bytes()[:4] == b"PAR1"


def test_what_cannot_be_exported_is_told(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = handcart("export", tmp_path, "-o", tmp_path / "trials.csv")
    assert (said.status, "*.mcap, *.parquet" in said.err) == (2, True)
    said = handcart("export", tmp_path, "-o", tmp_path / "trials.parquet")
    assert (said.status, "there is no campaign.json in it" in said.err) == (2, True)
