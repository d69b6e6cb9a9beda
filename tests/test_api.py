"""`import handcart`: its public names, its import time, and the examples of docs/reference/api.md."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import handcart
from handcart.evaluation.conformance import kit
from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.report import KitReport
from handcart.files.errors import InputError
from tests.tools.conftest import TOUR

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```python\n(.*?)```", TEXT, re.S)
EXAMPLE_OUTPUTS = (
    r"Success in .*\n(\d+\. .*: Success after \d+\.\d s\n)+\d+\.\d m; the ground truth contradicts: \[\]\n",
    r"[^\n]*unknown place 'dekc'; did you mean 'desk'[^\n]*\n",
    r".* from \w+ to \w+\n\[.*'SEARCH'.*\]\n",
    r".* Success \d+ records\ndriven to \[.*\] in \d+\.\d s\n",
    r"3 of 3 \(0\.\d+, .*\)\n",
    r"all that was tried holds\n",
    r"",  # a primitive, which only has to be accepted
    r"\['Base', 'Arm', .*, 'Positioning'\]\n",
)
"""Patterns of what the examples print, in the order of the page."""
FACE = {
    *("run", "check", "load_task", "load_run", "campaign", "causes", "conformance", "Result"),
    *("ActionPrimitive", "CauseKind", "Discrepancy", "NeedsPerson", "Success", "Fail", "GiveUp"),
    *("Backend", "Base", "Arm", "Gripper", "Camera", "RangeSensor", "Imu", "Gps", "Beacons", "Positioning"),
}


def test_it_offers_exactly_this() -> None:
    assert set(handcart.__all__) == FACE
    assert set(dir(handcart)) >= FACE
    assert all(getattr(handcart, name).__name__.rpartition(".")[2] in (name, "read_run") for name in FACE)
    assert all(f"{name}" in TEXT for name in FACE)
    face: Any = handcart
    with pytest.raises(AttributeError, match="no attribute 'ran'"):
        face.ran  # noqa: B018


def test_nothing_is_imported_before_it_is_used() -> None:
    code = "import sys, handcart; print([each for each in ('numpy', 'pydantic') if each in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "[]\n"


def one_check(setting: kit.KitSetting, processes: int) -> KitReport:
    """Make one of the checks that are asked for, in this process; tests/backends/can makes them all."""
    assert (setting.backend, setting.robot, list(setting.parts), processes) == (
        "kinematic",
        "cart",
        ["checks"],
        2,
    )
    finding = checks()["clock"](setting.bench)
    return KitReport.of(setting.backend, setting.robot, setting.quick, [finding])


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_the_documents_examples_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], number: int
) -> None:
    (tmp_path / "tasks").symlink_to(ROOT / "tasks")
    monkeypatch.chdir(tmp_path)
    if "handcart.conformance(" in EXAMPLES[number]:
        monkeypatch.setattr(kit, "run_kit", one_check)
    code = compile(EXAMPLES[number], "docs/reference/api.md", "exec", dont_inherit=True)
    exec(code, {"__name__": "__main__"})
    printed = capsys.readouterr().out
    assert re.fullmatch(EXAMPLE_OUTPUTS[number], printed, re.S), printed


def test_a_campaign_takes_what_the_command_takes(tmp_path: Path) -> None:
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        (tmp_path / name).write_bytes((ROOT / "tasks" / "return_book" / name).read_bytes())
    task = tmp_path / "tour.yaml"
    task.write_text(TOUR.replace("cost_s: 30", "cost_s: 30, attempts: 1, p: 0.9"), encoding="utf-8")
    vary = tmp_path / "vary.yaml"
    varied = "{file: task, key: actions.0.p, list: [0.2, 0.7]}"
    vary.write_text(f"format: handcart-vary/1\nvary:\n  - {varied}\n", encoding="utf-8")
    out = tmp_path / "out"
    report = handcart.campaign(task, trials=400, level="network", out=out, until="p < 0.8", vary=vary)
    assert report.holds is True
    assert 0.3 < report.successes / len(report.trials) < 0.7
    assert len(report.trials) < 400
    assert {value for trial in report.trials for value in trial.varied.values()} == {0.2, 0.7}
    assert (out / "report.html").is_file()
    assert "0.2" in (out / "trials.jsonl").read_text(encoding="utf-8")
    with pytest.raises(InputError, match=r"until: p < 0\.8 there, nothing now"):
        handcart.campaign(task, trials=400, level="network", out=out, vary=vary)
    with pytest.raises(InputError, match="allowed: run, fitted, network"):
        handcart.campaign(task, level="physics")  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_result_shows_itself_in_a_notebook(tmp_path: Path) -> None:
    task = ROOT / "tasks" / "drive_map" / "task.yaml"
    result = handcart.run(task, robot="cart", set={"tour": ["desk"]}, runs=tmp_path)
    assert result.outcome == "Success"
    assert result.status == 0
    assert [action.do for action in result.actions] == ["MOVE_TO"]
    shown = result._repr_html_()
    assert "<b>Success</b> in situation" in shown
    assert shown.count("<tr>") == 2


@pytest.mark.slow
def test_what_needs_an_operator_is_not_done_unasked(tmp_path: Path) -> None:
    for source in (ROOT / "tasks" / "drive_map").iterdir():
        (tmp_path / source.name).write_bytes(source.read_bytes())
    task = tmp_path / "task.yaml"
    text = task.read_text(encoding="utf-8")
    task.write_text(text.replace("{do: MOVE_TO,", "{do: MOVE_TO, permit: operator,"), encoding="utf-8")
    done = {
        permit: handcart.run(
            task, robot="cart", set={"tour": ["desk"]}, runs=tmp_path / "runs", permit=permit
        ).metrics["path_length_m"]
        for permit in ("always", "never")
    }
    assert done["always"] > 1.0
    assert done["never"] < 0.05
    assert inspect.signature(handcart.run).parameters["permit"].default == "ask"
