"""Mutants drawn by a seed: they change code; killed ones are distinguished from survivors."""

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
OWN = ("drawing", "choosing", "call_remover", "equivalent", "recording")
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
ADDER_FILE = "networks/journal/adder.py"
SUM = "tests/networks/journal/test_adder.py::test_sum"
FAR = "tests/tools/test_far.py::test_far[a b]"
LONG = "tests/tools/test_far.py::test_long"
NEW_TEST = """from handcart.networks.journal.adder import SEEN, add


def test_seen() -> None:
    add(1.0, 7.0)
    assert SEEN[-1:] == [7.0]
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
        "tests/tools/test_far.py": "",
        "src/handcart/__init__.py": PACKAGE,
        "tools/pytest_plugin.py": "",
    }.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    return folder


@pytest.mark.slow
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


@pytest.mark.slow
def test_an_exception_with_a_dot_in_its_name_ends_no_drawing(parts: Any, project: Path) -> None:
    text = "import os\n\n\ndef f(g):\n    try:\n        g(1)\n    except os.error:\n        pass\n"
    (project / ADDER_FILE).write_text(text)
    drawn = list(parts("drawing").draw(project, "1", ["journal"]))
    assert "g( 2)" in {mutant.after for mutant in drawn}


@pytest.mark.slow
def test_each_module_has_places_for_mutants(parts: Any) -> None:
    drawing = parts("drawing")
    modules = list(drawing.MODULE_GROUPS)
    drawn = list(islice(drawing.draw(ROOT, "1", modules), len(modules)))
    assert len({mutant.module for mutant in drawn}) >= len(modules) - 2
    folders = [ROOT / folder for module in modules for folder in drawing.MODULE_GROUPS[module]]
    assert all(list(folder.glob("**/*.py")) for folder in folders)


def test_our_own_operator_removes_calls_as_its_examples_say(parts: Any) -> None:
    remover, mutating = parts("call_remover").CallRemover(), import_module("cosmic_ray.mutating")
    for example in remover.examples():
        assert mutating.mutate_code(example.pre_mutation_code, remover, 0) == example.post_mutation_code
    assert mutating.mutate_code("def f():\n    yield\n    a = b()\n", remover, 0) is None


@pytest.mark.slow
def test_the_nearest_tests_are_of_the_same_name_or_import_it(parts: Any) -> None:
    nearest = parts("choosing").nearest_tests(ROOT, "networks/journal/journal_record.py")
    importing = [text for text in nearest if "journal_record" in (ROOT / text).read_text()]
    assert nearest[0] in importing
    assert nearest[0].startswith("tests/networks/journal/")
    assert "tests/networks/journal/test_journal.py" in nearest[:3]


@pytest.fixture
def recorded(parts: Any, project: Path, tmp_path: Path) -> Any:
    """Return a run's recording: a near test of 2 s, a far one of 1 s, a far one of 20 s."""
    data = coverage.CoverageData(str(tmp_path / "covered"))
    for name, lines in ((SUM, [5, 6, 10]), (FAR, [5]), (LONG, [5, 10]), ("", [4, 9, 13])):
        data.set_context(name)
        data.add_lines({str(project / ADDER_FILE): lines})
    return parts("recording").Recording(data, {SUM: 2.0, FAR: 1.0, LONG: 20.0})


def test_chosen_tests_execute_the_line_cheap_and_near_first(parts: Any, project: Path, recorded: Any) -> None:
    def names(line: int, seconds: float = 60.0) -> list[str]:
        chosen = parts("choosing").choose_tests(project, recorded, ADDER_FILE, line, seconds)
        return [name for name, _ in chosen.tests]

    assert names(5) == [SUM, FAR, LONG]
    assert names(5, seconds=22.0) == [SUM, FAR]
    assert names(5, seconds=0.1) == [SUM]
    assert names(6) == [SUM]


def test_a_line_executed_at_import_has_the_tests_of_what_it_defines(
    parts: Any, project: Path, recorded: Any
) -> None:
    def names(line: int) -> set[str]:
        chosen = parts("choosing").choose_tests(project, recorded, ADDER_FILE, line, 60.0)
        return {name for name, _ in chosen.tests}

    assert names(9) == {SUM, LONG}  # def note: its body
    assert names(13) == {SUM, LONG}  # SEEN: the line that appends to it
    assert names(1) == {SUM, FAR, LONG}  # nothing: all of the file


def test_without_a_recording_the_nearest_files_are_chosen(parts: Any, project: Path, recorded: Any) -> None:
    choose = parts("choosing").choose_tests
    near = SUM.split("::")[0]
    assert choose(project, None, ADDER_FILE, 5, 60.0) == ([], [near], False)
    (project / "networks/journal/other.py").write_text("X = 1\n")
    chosen = choose(project, recorded, "networks/journal/other.py", 1, 60.0)  # its lines left no trace
    assert {name.split("::")[0] for name, _ in chosen.tests} == {near}
    assert not chosen.executing


def test_lines_of_a_statement_end_where_its_body_begins(parts: Any) -> None:
    source = "def f(\n    a=1,\n):\n    if (\n        a\n    ):\n        g()\n    h(\n        a,\n    )\n"
    statements = [parts("choosing").statement_at(ast.parse(source), line) for line in range(1, 11)]
    assert [(min(statement.lines), max(statement.lines)) for statement in statements] == [
        *[(1, 3)] * 3,
        *[(4, 6)] * 3,
        (7, 7),
        *[(8, 10)] * 3,
    ]
    assert [statement.is_imported for statement in statements] == [True] * 3 + [False] * 7
    assert list(statements[0].body) == list(range(4, 11))


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


@pytest.mark.slow
def test_a_recording_chooses_single_tests_and_takes_new_ones_in(project: Path, tmp_path: Path) -> None:
    nothing = tmp_path / "equivalent.yaml"
    nothing.write_text("[]\n")
    (project / "tests/networks/journal/test_else.py").write_text("def test_else() -> None: pass\n")
    (project / "pyproject.toml").write_text("")
    command = [sys.executable, str(MUTATION), "--project", str(project), "--modules", "journal"]
    recorded = ["--record", str(tmp_path / "recorded"), "--jobs", "1"]
    subprocess.run([*command, *recorded], check=True, stdout=subprocess.DEVNULL)
    (project / "tests/networks/journal/test_adder_more.py").write_text(NEW_TEST)
    used = ["--coverage", str(tmp_path / "recorded"), "--seed", "1", "--drawn", "12"]
    ended = subprocess.run(
        [*command, *used, "--equivalent", str(nothing)], capture_output=True, text=True, check=False
    )
    assert f"killed     {ADDER_FILE}:6 by {SUM}" in ended.stdout, ended.stderr
    assert (
        f"killed     {ADDER_FILE}:10 by tests/networks/journal/test_adder_more.py::test_seen" in ended.stdout
    )
    assert "2 tests ran; 1 are known to execute it" in ended.stdout


@pytest.mark.slow
def test_a_test_that_fails_without_any_mutant_kills_none(project: Path, tmp_path: Path) -> None:
    (project / "tests/networks/journal/test_adder.py").write_text(TEST + "    assert False\n")
    command = [sys.executable, str(MUTATION), "--project", str(project), "--modules", "journal"]
    options = ["--seed", "1", "--drawn", "3", "--equivalent", str(tmp_path / "equivalent.yaml")]
    (tmp_path / "equivalent.yaml").write_text("[]\n")
    ended = subprocess.run([*command, *options], capture_output=True, text=True, check=False)
    assert f"fails without it: {SUM}" in ended.stdout
    assert "(0.0 %)" in ended.stdout
