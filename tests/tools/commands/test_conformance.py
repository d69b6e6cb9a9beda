"""`handcart conformance`."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import pytest

import handcart.evaluation.conformance.kit as kit
from handcart.evaluation.conformance.checks.check import CheckResult
from handcart.evaluation.conformance.report import KitReport
from tests.tools.conftest import Said


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [[], ["it rolls on"]])
def test_status_0_only_if_all_holds(
    handcart: Callable[..., Said], monkeypatch: pytest.MonkeyPatch, wrong: list[str]
) -> None:
    def run(setting: kit.KitSetting, processes: int, tell: Any) -> KitReport:
        return KitReport.of(
            setting.backend, setting.robot, setting.quick, [CheckResult("stop", "it stops", wrong)]
        )

    monkeypatch.setattr(kit, "run_kit", run)
    for words in ((), ("--json",)):
        said = handcart("conformance", "--quick", *words)
        assert said.status == (5 if wrong else 0)
        assert all(text in said.out for text in wrong)
    assert json.loads(said.out)["checks"][0]["ok"] is not bool(wrong)


@pytest.mark.slow
def test_progress_off_a_terminal_is_printed_rarely(
    handcart: Callable[..., Said], monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])

    def run(setting: kit.KitSetting, processes: int, tell: Any) -> KitReport:
        for done in range(1, 12):
            tell(done, 11)
            now[0] += 8.0
        return KitReport.of(setting.backend, setting.robot, setting.quick, [CheckResult("stop", "it stops")])

    monkeypatch.setattr(kit, "run_kit", run)
    first, *lines = handcart("conformance").err.splitlines()
    assert first == "quick: few faults and no complete tasks; --full tries everything"
    assert lines == [f"{done} of 11 jobs done after {8 * done - 8} s" for done in (1, 5, 9, 11)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--backend", "kinematik"), "did you mean 'kinematic'"),
        (("--part", "fault"), "did you mean 'faults'"),
        (("--primitive", "REECH"), "did you mean 'REACH'"),
        (("--task", "return_bok"), "did you mean 'return_book'"),
        (("--robot", "nowhere/robot.yaml"), "nowhere/robot.yaml"),
    ],
)
def test_bad_input_is_refused(handcart: Callable[..., Said], words: tuple[str, str], message: str) -> None:
    said = handcart("conformance", *words)
    assert said.status == 2
    assert message in said.err
