"""Faults in a campaign's trials."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.backend import CommandError
from handcart.backends.capabilities.base import Base
from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
from handcart.evaluation.campaigns.fault_plan import InjectedFaults, load_faults
from handcart.evaluation.conformance.faults.fault import FOR_GOOD
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend, InjectedError
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.files.errors import FileError
from tests.tools.conftest import Said
from tests.tools.conftest import handcart as handcart

DRIVE = Path(__file__).resolve().parents[3] / "tasks" / "drive_map" / "task.yaml"
PLAN = """\
format: handcart-faults/1
faults:
  - {kind: exception, at_s: 2.0}
  - {kind: slip, every_s: 3.0, periods: 4}
  - {kind: stale sensor, sensor: range, rate_per_s: 0.5, periods: 2}
"""


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    path = tmp_path / "faults.yaml"
    path.write_text(PLAN, encoding="utf-8")
    return path


def test_when_they_come(plan: Path) -> None:
    once, again, drawn = load_faults(plan).faults
    assert list(once.instants(Random(0))) == [2.0]
    assert list(itertools.islice(again.instants(Random(0)), 3)) == [3.0, 6.0, 9.0]
    instants = list(itertools.islice(drawn.instants(Random(1)), 2000))
    assert instants[-1] == pytest.approx(4000.0, rel=0.07)
    assert instants == list(itertools.islice(drawn.instants(Random(1)), 2000))
    assert InjectedFaults(load_faults(plan), 1)._next != InjectedFaults(load_faults(plan), 2)._next


@pytest.mark.parametrize("kind", ["exception", "refused command", "slip"])
def test_a_fault_of_the_next_call_waits_for_it(tmp_path: Path, kind: str) -> None:
    """An exception and a refused command wait for the next call, unless the plan says how long."""
    path = tmp_path / "faults.yaml"
    lines = [f"  - {{kind: {kind}, at_s: 1.0{more}}}\n" for more in ("", ", periods: 3")]
    path.write_text(f"format: handcart-faults/1\nfaults:\n{''.join(lines)}", encoding="utf-8")
    unstated, stated = (fault.fault() for fault in load_faults(path).faults)
    assert (unstated.periods, stated.periods) == (1 if kind == "slip" else FOR_GOOD, 3)
    if kind == "slip":
        return
    with KitBench("kinematic", "librarian").rig() as rig:
        faulty = FaultyBackend(rig.backend)
        faulty.inject(unstated)
        for _ in range(5):
            faulty.step()
        base = needed(faulty, Base)
        with pytest.raises((InjectedError, CommandError)):
            base.drive(0.1, 0.0)
        base.drive(0.1, 0.0)  # it ends with the call


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("{kind: slip}", "needed: one of at_s, every_s, rate_per_s"),
        ("{kind: slip, at_s: 1, every_s: 2}", "needed: one of"),
        ("{kind: stale sensor, sensor: rnage, at_s: 1}", "did you mean 'range'?"),
        ("{kind: stale sensor, at_s: 1}", "unknown sensor"),
        ("{kind: slipp, at_s: 1}", "slip"),
    ],
)
def test_a_plan_that_makes_no_sense_is_refused(tmp_path: Path, line: str, wrong: str) -> None:
    path = tmp_path / "faults.yaml"
    path.write_text(f"format: handcart-faults/1\nfaults:\n  - {line}\n", encoding="utf-8")
    with pytest.raises(FileError) as refused:
        load_faults(path)
    assert wrong in str(refused.value)
    assert "faults.yaml:3:" in str(refused.value)


def test_each_is_injected_once_it_is_due_and_what_it_changed_is_kept(plan: Path) -> None:
    observer, injected = InjectedFaults(load_faults(plan), 1), list[str]()
    observer._coming, observer._next = observer._coming[:2], observer._next[:2]
    backend: Any = SimpleNamespace(asked=False, bitten=0, inject=lambda fault: injected.append(str(fault)))
    observer.end()
    assert observer.injected == []
    observer._backend = backend
    for period in range(1, 81):
        robot: Any = SimpleNamespace(time=period * 0.1)
        backend.asked = False
        observer.period(robot)
        assert backend.asked
        backend.bitten += 1 if period < 50 else 0
    observer.end()
    assert [(item["at_s"], item["bitten"]) for item in observer.injected] == [(2.0, 10), (3.0, 20), (6.0, 0)]
    assert injected == [item["fault"] for item in observer.injected]
    late: Any = SimpleNamespace(time=30.0)  # of several instants that have passed one counts
    observer.period(late)
    assert [item["at_s"] for item in observer.injected] == [2.0, 3.0, 6.0, 30.0]


@pytest.mark.slow
def test_they_come_and_are_recorded_with_each_trial(
    handcart: Callable[..., Said], tmp_path: Path, plan: Path
) -> None:
    command = ["campaign", DRIVE, "--robot", "cart", "--set", "tour=[desk]", "--trials", "1", "--jobs", "1"]
    said = handcart(*command, "--faults", plan, "--out", tmp_path / "out")
    assert said.status == 0, said.err
    (trial,) = CampaignFolder.read(tmp_path / "out").trials()
    assert trial.faults[0] == {"fault": "exception", "at_s": 2.0, "bitten": 1}
    assert sum(fault["fault"].startswith("slip") for fault in trial.faults) >= 2
    assert "MOVE_TO Fail code_error (motion): InjectedError: the backend broke" in said.out
    assert f"--faults {plan}" in said.out
    plan.write_text(PLAN.replace("2.0", "2.5"), encoding="utf-8")
    said = handcart(*command, "--faults", plan, "--out", tmp_path / "out")
    assert (said.status, "faults.yaml has another content" in said.err) == (2, True)
