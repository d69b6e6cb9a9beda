"""Every row of docs/reference/faults.md has a test that names it."""

from __future__ import annotations

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LAST = {"T": 18, "N": 14, "D": 12, "S": 12, "C": 22, "K": 18, "U": 14}
NAMED = [f"{kind}{number}" for kind, last in LAST.items() for number in range(1, last + 1)]


def test_every_row_is_named_by_a_test() -> None:
    spec = spec_from_file_location("fault_rows", ROOT / "scripts" / "fault_rows.py")
    assert spec is not None
    assert spec.loader is not None
    script = module_from_spec(spec)
    sys.modules[spec.name] = script
    spec.loader.exec_module(script)
    rows, covered = script.rows(), script.tests_by_row()
    assert [row for row in rows if row not in covered] == []
    assert len(rows) == len(set(rows))
    assert set(NAMED) <= set(rows)
