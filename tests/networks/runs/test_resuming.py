"""Known state of a run that broke off, by its journal and its checkpoint."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.saved_state import NotAState, pack
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import Request
from handcart.networks.graph.planner import Plan
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import NeedsOperator, standing
from handcart.networks.journal.waiting import waiting
from handcart.networks.run_files.run_folder import read_run_journal
from handcart.networks.runs.checkpoint import CHECKPOINT_FILE, keep_checkpoint, load_checkpoint
from handcart.networks.runs.resuming import NothingToResume, task_of
from tests.networks.conftest import Stand
from tests.networks.runs.conftest import UnfinishedRun

_OWN = ("kind", "q", "t", "wall", "p", "h")
"""Fields that the journal itself writes into each record."""


def test_a_result_that_only_the_checkpoint_holds_counts(run: UnfinishedRun) -> None:
    run.cut("RESULT", -1)
    past = run.past()
    assert past.recovered is not None
    assert (past.recovered["n"], past.recovered["outcome"]) == (3, "Success")
    assert past.standing.route.arrived


def test_a_checkpoint_that_follows_another_record_is_not_the_journals(run: UnfinishedRun) -> None:
    run.cut("RESULT", -1)
    run.append("INTENT", n=3, effect="the lamp goes out")
    with pytest.raises(NeedsOperator, match="is not the one that its journal names: it is of action 3"):
        run.past()


def test_a_torn_record_may_have_been_the_start_of_the_next_action(run: UnfinishedRun) -> None:
    """D3"""
    run.cut("START", 1, half=True)
    run.forget()
    past = run.past()
    assert past.standing.in_doubt is not None
    assert past.standing.in_doubt["n"] == 2
    assert list(past.doubts()) == [
        "how far action 2, DRIVE from b, had come",
        f"the content of record {past.last + 1}, which is damaged",
    ]


@pytest.mark.parametrize("outcome", ["Success", "Fail"])
def test_a_run_that_came_to_its_end_is_over(run: UnfinishedRun, outcome: str) -> None:
    run.cut("END", 0)
    assert task_of(run.folder)["network"] == run.network.fingerprint()
    run.append("END", outcome=outcome, situation="c", reason="no way")
    with pytest.raises(NothingToResume, match=f"is over: {outcome} in situation c"):
        task_of(run.folder)


@pytest.mark.parametrize("outcome", ["Cancelled", "GiveUp", "Error"])
def test_one_that_was_stopped_or_gave_up_is_not(run: UnfinishedRun, outcome: str) -> None:
    run.cut("END", 0)
    run.append("END", outcome=outcome, situation="c", reason="asked for")
    assert task_of(run.folder)["start"] == "a"


def test_a_give_up_leaves_the_checkpoint_before_it(run: UnfinishedRun) -> None:
    """The person who acknowledges it has put everything back as it was before that action."""
    before = (run.folder / CHECKPOINT_FILE).read_bytes()
    keep = partial(keep_checkpoint, run.folder, run.prepare(), False)
    assert keep({"n": 4, "outcome": "GiveUp", "reason": "stuck"}, "x") is None
    assert (run.folder / CHECKPOINT_FILE).read_bytes() == before
    assert keep({"n": 4, "outcome": "Success"}, "x")
    assert (run.folder / CHECKPOINT_FILE).read_bytes() != before


def test_a_fail_for_good_is_for_good_after_a_resume_too(run: UnfinishedRun) -> None:
    run.cut("RESULT", 0)
    failed = {"n": 1, "outcome": "Fail", "reason": "no way", "permanent": True, "residuals": {}}
    run.append("RESULT", **failed)
    there = standing(run.network, run.records)
    plan = there.route.plan()
    assert isinstance(plan, Plan)
    assert [action.index for action in plan.actions] == [3]
    run.cut("RESULT", 0)
    run.append("RESULT", **failed | {"permanent": False})
    again = standing(run.network, run.records).route.plan()
    assert isinstance(again, Plan)
    assert [action.index for action in again.actions] == [0, 1, 2]


def test_the_result_of_an_action_that_was_not_started_fits_nothing(run: UnfinishedRun) -> None:
    run.cut("RESULT", 1)
    run.append("RESULT", n=1, outcome="Success")
    with pytest.raises(NeedsOperator, match="action 1 is not the one that was started"):
        standing(run.network, run.records)


def test_a_word_on_something_else_settles_nothing(run: UnfinishedRun) -> None:
    """An action that was broken off waits until that very record is acknowledged."""
    run.cut("RESULT", 1)
    start = len(run.records) - 1
    run.append("ACK", record=1, of="RESULT", reason="seen to")
    assert list(waiting(read_run_journal(run.folder))) == [start]
    run.append("ACK", record=start, of="START", reason="seen to")
    assert waiting(read_run_journal(run.folder)) == {}


def test_a_journal_of_another_version_is_not_gone_on_with(run: UnfinishedRun) -> None:
    """D12"""
    run.cut("END", 0)
    header = {key: item for key, item in run.records[0].items() if key not in _OWN}
    other = run.folder.with_name("other")
    other.mkdir()
    with Journal(other / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, header | {"handcart": "0.0.1"})
    with pytest.raises(NeedsOperator, match=r"the run is one of handcart '0\.0\.1'; only"):
        task_of(other)


def test_a_checkpoint_of_another_version_is_refused_in_words(tmp_path: Path) -> None:
    """The names of its parts may have changed, so nothing of it is used."""
    kept: dict[str, Any] = dict.fromkeys(("after", "result", "time_s", "backend", "robot", "model"), None)
    (tmp_path / "checkpoint").write_bytes(pack({"format": "handcart-checkpoint/2", **kept}))
    with pytest.raises(NotAState, match=r"'handcart-checkpoint/2', which another version .* begin a new run"):
        load_checkpoint(tmp_path)


@pytest.mark.parametrize(("word", "cause"), [("F", "unnamed"), ("G", "unnamed"), ("S", "")])
def test_a_resumed_run_ends_with_the_cause_of_its_last_fail(
    new_stand: Callable[[], Stand], tmp_path: Path, word: str, cause: str
) -> None:
    """It is stopped after a Fail or GiveUp, and stopped again before its next action."""
    stand = new_stand()
    network = stand.network("a b x 1", "b z y 1")
    stand.script["x"] = deque([word])
    path = tmp_path / "j"
    with Journal(path) as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": network.fingerprint()})
        stand.finish(Coordinator(network, stand.robot, stand.model, journal))
    records = list(read_journal(path).records)
    kept = records[: [record["kind"] for record in records].index("RESULT") + 1]
    if word == "G":
        kept.append({"kind": "ACK", "q": len(kept), "t": 0.0, "record": 3, "of": "RESULT", "reason": "it"})
    run = Coordinator(network, stand.robot, stand.model, standing=standing(network, kept))
    run.request(Request.STOP)
    end = stand.finish(run)
    assert (end.outcome, end.cause, end.fails) == ("Cancelled", cause, int(word != "S"))
