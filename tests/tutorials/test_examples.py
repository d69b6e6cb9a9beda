"""Examples run as they are, in an empty folder; the notebook's cells in their order."""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SCRIPTS = {
    "run_a_task.py": "Success in toured",
    "plot_a_run.py": "drawn into path.png",
    "own_primitive.py": "no wall near: Fail",
    "plot_uncertainty.py": "plain: Fail not determined",
    "compare_seeds.py": "3 of 3",
}


def test_every_example_is_run_by_a_test_and_listed() -> None:
    found = {path.name for path in EXAMPLES.iterdir() if path.suffix in (".py", ".ipynb")}
    assert found == {*SCRIPTS, "first_steps.ipynb"}
    page = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert [name for name in sorted(found) if f"[{name}]({name})" not in page] == []


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS)
def test_example_runs_and_prints_its_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], script: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [script])
    runpy.run_path(str(EXAMPLES / script), run_name="__main__")
    assert SCRIPTS[script] in capsys.readouterr().out


@pytest.mark.slow
def test_notebook_runs_cell_by_cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    book = json.loads((EXAMPLES / "first_steps.ipynb").read_text(encoding="utf-8"))
    names: dict[str, object] = {}
    for cell in book["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    assert "did you mean 'desk'?" in capsys.readouterr().out
