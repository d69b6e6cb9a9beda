"""What is reported of a run that broke off: what is known, what was recovered, what comes next."""

from __future__ import annotations

from tests.networks.runs.conftest import UnfinishedRun


def test_what_is_known_and_what_comes_next_is_told(run: UnfinishedRun) -> None:
    run.cut("START", 2)
    run.forget()
    past = run.past()
    wall = past.contents.records[-1]["wall"]["unix_s"]
    boot = past.contents.records[0]["wall"]["boot_id"]
    known = f"known: record {past.last}, 7 s ago; situation c, 2 actions started, 0 failed"
    assert past.words(wall + 7.2, boot) == [known]
    assert past.words(wall + 7.2, "another") == [known, "known: the machine was restarted since"]
    assert past.words(wall - 7.2, boot)[0].startswith(f"known: record {past.last}, 0 s ago")
    assert past.next_words() == "next: DRIVE (c to z)"
    assert past.recovered is None
    (epoch,) = past.resume_records
    assert epoch == ("EPOCH", {"after": past.last, "in_doubt": None}, {})


def test_age_of_a_run_is_that_of_its_last_record(run: UnfinishedRun) -> None:
    run.cut("START", 2)
    run.forget()
    past = run.past()
    for number, record in enumerate(past.contents.records):
        record["wall"]["unix_s"] = 100.0 * number
    written = 100.0 * (len(past.contents.records) - 1)
    assert past.words(written + 7.2, None)[0].startswith(f"known: record {past.last}, 7 s ago")


def test_a_recovered_result_and_a_torn_tail_are_told(run: UnfinishedRun) -> None:
    run.cut("RESULT", -1, half=True)
    past = run.past()
    lines = past.words(0.0, None)
    assert lines[1:3] == [
        f"torn: the journal's tail from byte {past.contents.torn_at} on is set aside",
        "recovered: action 3 had ended with Success",
    ]
    assert past.checkpoint is not None
    (kind, fields, wall), epoch = past.resume_records
    assert (kind, fields["n"], fields["recovered"]) == ("RESULT", 3, True)
    assert wall == {"checkpoint": past.checkpoint.digest}
    assert epoch[1]["in_doubt"] is None
    assert past.next_words() == "next: nothing, the goal is reached"


def test_no_way_left_is_what_comes_next(run: UnfinishedRun) -> None:
    run.cut("START", 0)
    run.forget()
    for number, index in enumerate((0, 3), 1):
        action = run.network.actions[index]
        words = {"index": index, "do": action.do, "from": action.source, "to": action.target}
        run.append("START", n=number, action={**words, "with": {}})
        failed = {"outcome": "Fail", "reason": "blocked", "permanent": True, "residuals": {}}
        run.append("RESULT", n=number, **failed)
        if number == 1:
            run.append("PLAN", situation="a", way=[3], cost=9.0, excluded=[0])
    past = run.past()
    assert past.next_words().startswith("next: no way left from a to z: ")
    assert (past.standing.started, past.standing.fails, past.standing.plans) == (2, 2, 2)
