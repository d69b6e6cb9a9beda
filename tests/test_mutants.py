"""The table of planted bugs fits the code; the runner distinguishes noticed bugs from missed ones."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
MUTANTS = ROOT / "scripts" / "mutants"
TABLE = """\
- file: adder.py
  tests: [test_adder.py]
  bugs:
    - {name: subtracts, text: a + b, replacement: a - b}
    - {name: words, text: The sum, replacement: A sum}
    - {name: forgets, text: return a, replacement: return (a if a < 9 else 0)}
"""
TESTS = """import pytest
from adder import add

def test_sum():
    assert add(2, 3) == 5

@pytest.mark.slow
def test_large_sum():
    assert add(20, 3) == 23
"""


@pytest.fixture
def mutants(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.syspath_prepend(str(MUTANTS))
    sys.modules.pop("mutant", None)
    yield import_module("mutant")
    sys.modules.pop("mutant", None)


def test_each_bug_can_be_planted_and_has_its_tests(mutants: Any) -> None:
    table = mutants.read_table()
    assert len(table) >= 290
    assert len({(mutant.file, mutant.name) for mutant in table}) == len(table)
    for mutant in table:
        sound = (ROOT / mutant.file).read_text(encoding="utf-8")
        assert mutant.planted(sound) != sound
        assert mutant.tests
        assert all((ROOT / test.split("::")[0]).is_file() for test in mutant.tests), mutant.tests


def test_each_row_of_operators_and_pages_has_a_bug_of_its_own(mutants: Any) -> None:
    names = [mutant.name.partition(":")[0] for mutant in mutants.read_table()]
    assert [f"U{number}" for number in range(1, 15) if f"U{number}" not in names] == []


def test_a_text_that_is_not_there_once_is_told(mutants: Any) -> None:
    bug = mutants.Mutant("twice", "a.py", "x", "y", ("test_a.py",))
    with pytest.raises(ValueError, match=r"a\.py: twice: the text is there 2 times; needed: once"):
        bug.planted("x x")


@pytest.mark.slow
def test_what_is_noticed_and_what_is_missed(tmp_path: Path) -> None:
    project = tmp_path / "project"
    project.mkdir()
    (project / "adder.py").write_text('"""The sum."""\n\n\ndef add(a, b):\n    return a + b\n')
    (project / "test_adder.py").write_text(TESTS)
    (project / "pytest.ini").write_text("[pytest]\nmarkers = slow\n")
    (tmp_path / "table").mkdir()
    (tmp_path / "table" / "one.yaml").write_text(TABLE)
    command = [sys.executable, str(MUTANTS), "--project", str(project), "--table", str(tmp_path / "table")]
    ended = subprocess.run([*command, "--jobs", "1"], capture_output=True, text=True, check=False)
    assert ended.returncode == 1, ended.stderr
    assert "noticed adder.py: subtracts" in ended.stdout
    assert "MISSED  adder.py: words" in ended.stdout
    assert "noticed adder.py: forgets" in ended.stdout, "by a slow test alone"
    assert "2 of 3 planted bugs were noticed (66.7 %)" in ended.stdout
    assert (project / "adder.py").read_text().endswith("a + b\n")
