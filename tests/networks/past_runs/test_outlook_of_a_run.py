"""Outlook of a waiting action from the journal of its run: shared budgets, renewals and rounds counted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from handcart.networks.analysis.outlook import Outlook, outlook
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import Request
from handcart.networks.journal.journal import JOURNAL_SCHEMA, Journal
from handcart.networks.past_runs.hindsight import counts_now
from handcart.networks.past_runs.past_run import read_run
from handcart.networks.runs.run_header import network_fields
from handcart.networks.task.task_file import load_task
from tests.networks.conftest import Stand

HEAD = "format: handcart-task/1\ntitle: t\nrobot: librarian\nstart: a\ngoal: z\n"
SHARED = f"""\
{HEAD}budgets: {{grasps: 2}}
situations: {{a: {{}}, z: {{}}}}
actions:
  - {{do: THINK, from: a, to: z, cost_s: 6, p: 0.5, attempts: {{budget: grasps}}, with: {{name: left}}}}
  - {{do: THINK, from: a, to: z, cost_s: 5, p: 0.5, attempts: {{budget: grasps}}, with: {{name: right}}}}
"""
RENEWED = f"""\
{HEAD}situations: {{a: {{}}, b: {{}}, z: {{}}}}
actions:
  - {{do: THINK, from: a, to: b, cost_s: 5, p: 1.0, with: {{name: look}}}}
  - do: THINK
    from: b
    to: z
    on_fail: a
    cost_s: 5
    p: 0.5
    attempts: {{most: 1, fresh_after: THINK, renewals: 1}}
    with: {{name: insert}}
"""
LOOKED = f"""\
{HEAD}situations: {{a: {{}}, b: {{}}, c: {{}}, z: {{}}}}
actions:
  - {{do: THINK, from: a, then: [{{to: b, p: 0.6}}, {{to: c, p: 0.2, result: far}}], cost_s: 5,
     with: {{name: look}}}}
  - {{do: THINK, from: b, to: z, cost_s: 5, p: 1.0, attempts: 1, with: {{name: near}}}}
  - {{do: THINK, from: c, to: z, cost_s: 5, p: 0.5, attempts: 1, with: {{name: far}}}}
"""
Make = Callable[..., Path]


def seen(folder: Path, primitives: SimpleNamespace, situation: str, action: int) -> Outlook:
    task = load_task(folder.parent / "task" / "task.yaml", {}, lambda name: getattr(primitives, name))
    return outlook(task, situation, counts_now(read_run(folder)), action)


def test_fails_of_a_shared_budget_count_for_all_that_share_it(
    scripted_run: Make, primitives: SimpleNamespace
) -> None:
    succeeds = scripted_run(SHARED, "run", right="S")
    assert seen(succeeds, primitives, "a", 1) == pytest.approx((0.75, 1.0, 0.5))
    fails = scripted_run(SHARED, "other", right="FS")
    assert counts_now(read_run(fails)) == {0: 1}
    assert seen(fails, primitives, "a", 1) == pytest.approx((0.5, 1.0, 0.0))


def test_a_success_gives_attempts_back_in_the_outlook(tmp_path: Path, primitives: SimpleNamespace) -> None:
    path = tmp_path / "task.yaml"
    path.write_text(RENEWED, encoding="utf-8")
    task = load_task(path, {}, lambda name: getattr(primitives, name))
    assert outlook(task, "a", {1: 1}, 0).succeeded == pytest.approx(0.5)
    assert outlook(task, "a", {}, 0).succeeded == pytest.approx(0.75)


def test_outlook_after_a_success_is_the_mean_over_its_results(
    tmp_path: Path, primitives: SimpleNamespace
) -> None:
    path = tmp_path / "task.yaml"
    path.write_text(LOOKED, encoding="utf-8")
    task = load_task(path, {}, lambda name: getattr(primitives, name))
    assert outlook(task, "a", {}, 0).succeeded == pytest.approx(0.75 * 1.0 + 0.25 * 0.5)


@pytest.mark.parametrize(("request_", "fails"), [(Request.RESTORE, {0: 1}), (Request.PREEMPT, {})])
def test_an_action_that_was_preempted_does_not_count(
    new_stand: Callable[[], Stand], tmp_path: Path, request_: Request, fails: dict[int, int]
) -> None:
    stand = new_stand()
    network = stand.driving()
    header = {"network": network.fingerprint(), "plan_on": network_fields(network)}
    with Journal(tmp_path / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, {"schema": JOURNAL_SCHEMA, **header})
        run = Coordinator(network, stand.robot, stand.model, journal)
        stand.finish(run, {20: lambda: run.request(request_)})
    assert counts_now(read_run(tmp_path)) == fails
