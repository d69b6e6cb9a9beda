"""Mutants drawn by a seed: they change code, and what the nearest tests kill is told from survivors."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("cosmic_ray", reason="of the extra `dev`")
coverage = pytest.importorskip("coverage", reason="of the extra `dev`")

ROOT = Path(__file__).resolve().parents[1]
MUTATION = ROOT / "scripts" / "mutation"
OWN = ("drawing", "choosing", "call_remover", "equivalent")
ADDER = '''"""The sum."""


def add(a: float | None, b: float) -> float:
    note(b)
    return (a or 0.0) + b


def note(b: float) -> None:
    SEEN.append(b)


SEEN: list[float] = []
'''
TEST = """from handcart.networks.journal.adder import add


def test_sum() -> None:
    assert add(2, 3) == 5
"""
PACKAGE = """from pathlib import Path

__path__.append(str(Path(__file__).parents[2]))
"""


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.syspath_prepend(str(MUTATION))
    yield lambda name: import_module(name)
    for name in OWN:
        sys.modules.pop(name, None)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project whose module `journal` has one file, of which one line is tested."""
    folder = tmp_path / "project"
    for path, text in {
        "networks/journal/adder.py": ADDER,
        "tests/networks/journal/test_adder.py": TEST,
        "src/handcart/__init__.py": PACKAGE,
        "tools/pytest_plugin.py": "",
    }.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    return folder


def test_mutants_of_a_seed_are_the_same_and_change_what_acts(parts: Any, project: Path) -> None:
    drawing = parts("drawing")
    drawn = list(drawing.draw(project, "1", ["journal"]))
    assert drawn == list(drawing.draw(project, "1", ["journal"]))
    assert drawn != list(drawing.draw(project, "2", ["journal"]))
    changed = {mutant.after for mutant in drawn}
    assert {"pass", "return (a or 0.0) - b", "return (a and 0.0) + b", "return (a or 1.0) + b"} <= changed
    assert not any("None" in mutant.before for mutant in drawn)  # annotations are never evaluated
    for mutant in drawn:
        assert ast.dump(ast.parse(mutant.planted(ADDER))) != ast.dump(ast.parse(ADDER))
        assert ADDER.splitlines()[mutant.line - 1].strip() == mutant.before


def test_each_module_has_places_for_mutants(parts: Any) -> None:
    drawing = parts("drawing")
    modules = list(drawing.MODULES)
    drawn = list(islice(drawing.draw(ROOT, "1", modules), len(modules)))
    assert len({mutant.module for mutant in drawn}) >= len(modules) - 2
    folders = [ROOT / folder for each in modules for folder in drawing.MODULES[each]]
    assert all(list(folder.glob("**/*.py")) for folder in folders)


def test_our_own_operator_removes_calls_as_its_examples_say(parts: Any) -> None:
    remover, mutating = parts("call_remover").CallRemover(), import_module("cosmic_ray.mutating")
    for example in remover.examples():
        assert mutating.mutate_code(example.pre_mutation_code, remover, 0) == example.post_mutation_code
    assert mutating.mutate_code("def f():\n    yield\n    a = b()\n", remover, 0) is None


def test_the_nearest_tests_are_of_the_same_name_or_import_it(parts: Any) -> None:
    nearest = parts("choosing").nearest_tests(ROOT, "networks/journal/journal_record.py")
    importing = [each for each in nearest if "journal_record" in (ROOT / each).read_text()]
    assert nearest[0] in importing
    assert nearest[0].startswith("tests/networks/journal/")
    assert "tests/networks/journal/test_journal.py" in nearest[:3]


def test_coverage_says_which_tests_execute_a_line(parts: Any, project: Path, tmp_path: Path) -> None:
    data = coverage.CoverageData(str(tmp_path / "covered"))
    data.set_context("tests.networks.journal.test_adder.test_sum")
    data.add_lines({str(project / "networks/journal/adder.py"): [5, 6]})
    by_coverage = parts("choosing").tests_by_coverage
    assert by_coverage(project, data, "networks/journal/adder.py", 6) == [
        "tests/networks/journal/test_adder.py"
    ]
    assert by_coverage(project, data, "networks/journal/adder.py", 13) == []
    assert by_coverage(project, data, "networks/journal/other.py", 6) == []


def test_each_equivalent_mutant_is_still_one_and_has_a_reason(parts: Any) -> None:
    for (file, before, after), reason in parts("equivalent").read_equivalents().items():
        lines = [line.strip() for line in (ROOT / file).read_text(encoding="utf-8").splitlines()]
        assert before in lines, (file, before)
        assert before != after
        assert len(reason.split()) >= 4


@pytest.mark.slow
def test_survivors_are_printed_and_too_few_killed_fail(project: Path, tmp_path: Path) -> None:
    (tmp_path / "equivalent.yaml").write_text(
        "- file: networks/journal/adder.py\n  before: SEEN.append(b)\n  after: pass\n"
        "  reason: nobody reads what is noted\n"
    )
    command = [sys.executable, str(MUTATION), "--project", str(project), "--modules", "journal"]
    options = ["--seed", "1", "--drawn", "12", "--equivalent", str(tmp_path / "equivalent.yaml")]
    ended = subprocess.run([*command, *options, "--least", "95"], capture_output=True, text=True, check=False)
    assert ended.returncode == 1, ended.stderr
    assert "killed     networks/journal/adder.py:6 by tests/networks/journal/test_adder.py" in ended.stdout
    assert "SURVIVED   networks/journal/adder.py:5" in ended.stdout
    assert "      - note(b)\n      + pass\n" in ended.stdout
    assert "equivalent networks/journal/adder.py:10 nobody reads what is noted" in ended.stdout
    assert (project / "networks/journal/adder.py").read_text() == ADDER
