"""Networks that are generated from conditions: files, faults, runs, resuming, figures."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from pathlib import Path

import orjson
import pytest

from handcart.files.errors import FileError
from handcart.networks.analysis.figures import network_chances
from handcart.networks.analysis.forecast import forecast
from handcart.networks.analysis.task_findings import task_findings
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.drawing.drawing import to_svg
from handcart.networks.entries import generating
from handcart.networks.events.events import Event, Started
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import standing
from handcart.networks.past_runs.journaled_network import network_of
from handcart.networks.runs.run_header import network_fields
from handcart.networks.task.task_file import Task, load_task
from tests.networks.conftest import Stand

Load = Callable[..., Task]
HEAD = "format: handcart-task/1\ntitle: t\nrobot: librarian\n"
BOOK = """\
facts: {base: [home, shelf], book: [tray, hand, shelved]}
known: {way: [free, blocked]}
goal: {base: home, book: shelved}
actions:
  - {do: THINK, if: {base: home, book: tray}, then: {book: hand}, cost_s: 5, p: 0.9, with: {name: take}}
  - {do: THINK, if: {base: home, way: free}, then: {base: shelf}, cost_s: 5, p: 0.5, attempts: 1,
     on_fail: {else: {known: {way: blocked}}}, with: {name: go}}
  - {do: THINK, if: {base: home}, then: {base: shelf}, cost_s: 50, p: 1.0, with: {name: around}}
  - {do: THINK, if: {base: shelf, book: hand}, then: {book: shelved}, cost_s: 5, p: 1.0, with: {name: put}}
  - {do: THINK, if: {base: shelf}, then: {base: home}, cost_s: 5, p: 1.0, with: {name: back}}
"""


WRONG = {
    "9:27: unknown fact 'bse'; did you mean 'base'?": ("{base: home, way: free}", "{bse: home, way: free}"),
    "book is never 'hnd'; did you mean 'hand'?": (
        "book: hand}, cost_s: 5, p: 0.9",
        "book: hnd}, cost_s: 5, p: 0.9",
    ),
    "'base' is a physical fact, and a Fail changes none": ("known: {way: blocked}", "known: {base: shelf}"),
    "base is never 'hoem'; did you mean 'home'?": ("goal: {base: home, book: shelved}", "goal: {base: hoem}"),
    "one of `facts`": (
        "known: {way: [free, blocked]}",
        "known: {base: [free, blocked], way: [free, blocked]}",
    ),
    "6:15: book is never 'shelf'": ("goal:", "start: {book: shelf}\ngoal:"),
    "unknown fact 'bok'; did you mean 'book'?": ("goal:", "otherwise: [{base: home}, {bok: tray}]\ngoal:"),
    "4:49: hand is listed twice; allowed: once": ("[tray, hand, shelved]", "[tray, hand, hand, shelved]"),
    "'p' is a key of an entry of `then`; allowed: another name": ("book: [tray", "p: [0], book: [tray"),
    "unknown key 'repeat'": ("goal:", "repeat: []\ngoal:"),
    "a Fail leads to it, and book may have": ("goal: {base: home, book: shelved}", "goal: {way: blocked}"),
    "the start is the goal": ("goal: {base: home, book: shelved}", "goal: {base: home, book: tray}"),
    "unknown budget 'none'": ("p: 0.9", "p: 0.9, attempts: {budget: none}"),
    "unknown key 'nme'": ("p: 0.9, with: {name: take}", "p: 0.9, with: {nme: take}"),
}
"""Replacements in the task, with the expected reports."""


def names(task: Task, stand: Stand, journal: Journal | None = None, **script: str) -> list[str]:
    """Run a task; return the names of the actions that it starts, and its end."""
    for name, ends in script.items():
        stand.script[name] = deque(ends)
    events: list[Event] = []
    end = stand.finish(Coordinator(task.network, stand.robot, stand.model, journal, [events.append]))
    started = [event.action.binding for event in events if isinstance(event, Started)]
    return [*(str(binding.fixed["name"]) for binding in started if binding), end.outcome]


def test_conditions_span_every_situation_of_a_run(load: Load) -> None:
    network = load(HEAD + BOOK).network
    expected = {"home, tray", "home, hand", "shelf, tray", "shelf, hand", "shelf, shelved", "home, shelved"}
    blocked = {f"{item}, way blocked" for item in expected if item != "home, shelved"}
    assert set(network.situations) == expected | blocked
    assert dict(network.situations["shelf, hand, way blocked"].facts) == {"base": "shelf", "book": "hand"}
    going = {a.on_fail for a in network.actions if a.binding and a.binding.fixed["name"] == "go"}
    assert going == {"home, tray, way blocked", "home, hand, way blocked"}


@pytest.mark.parametrize(
    ("script", "expected"),
    [
        ({}, ["take", "go", "put", "back", "Success"]),
        ({"go": "F"}, ["take", "go", "around", "put", "back", "Success"]),
        ({"take": "FFF"}, ["take", "take", "take", "Fail"]),
    ],
)
def test_conditions_run_like_written_networks(
    load: Load, stand: Stand, script: dict[str, str], expected: list[str]
) -> None:
    assert names(load(HEAD + BOOK), stand, None, **script) == expected


def test_attempts_are_shared_by_all_situations_of_an_entry(load: Load, stand: Stand) -> None:
    text = """\
facts: {base: [a, b, c]}
goal: {base: c}
actions:
  - {do: THINK, if: {base: [a, b]}, then: {base: c}, cost_s: 5, attempts: 2, with: {name: short}}
  - {do: THINK, if: {base: a}, then: {base: b}, cost_s: 4, with: {name: aside}}
"""
    assert names(load(HEAD + text), stand, short="FFF") == ["short", "short", "Fail"]


def test_renewing_actions_stay_where_they_change_nothing(load: Load, stand: Stand) -> None:
    text = """\
facts: {book: [hand, slot]}
goal: {book: slot}
actions:
  - {do: THINK, then: {}, if: {book: hand}, cost_s: 5, with: {name: look}}
  - {do: DRIVE, if: {book: hand}, then: {book: slot}, cost_s: 5}
"""
    assert len(load(HEAD + text).network.actions) == 1
    fresh = text.replace("cost_s: 5}\n", "cost_s: 5, attempts: {most: 2, fresh_after: THINK}}\n")
    assert len(load(HEAD + fresh).network.actions) == 2


def test_probabilities_of_results_and_causes_are_those_of_the_entry(load: Load) -> None:
    text = """\
facts: {book: [tray, hand, dropped]}
known: {way: [free, blocked]}
goal: {book: hand}
actions:
  - {do: THINK, if: {book: tray, way: free}, then: [{p: 0.6, book: hand}, {p: 0.1, book: dropped}],
     on_fail: {blocked: {p: 0.1, known: {way: blocked}}}, p_give_up: 0.2, cost_s: 5, with: {name: take}}
"""
    task = load(HEAD + text)
    found = forecast(task.network, network_chances(task))
    assert found.goal == pytest.approx(0.6)
    assert found.give_up == pytest.approx(0.2)
    assert found.no_way == pytest.approx(0.2)


@pytest.mark.parametrize("message", WRONG)
def test_wrong_conditions_are_reported_with_their_place(load: Load, message: str) -> None:
    old, new = WRONG[message]
    assert old in BOOK
    with pytest.raises(FileError) as error:
        load(HEAD + BOOK.replace(old, new, 1))
    assert message in str(error.value)
    assert all(finding.line > 3 for finding in error.value.findings)


def test_conditions_that_explode_are_refused(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generating, "MAX_SITUATIONS", 100)
    facts = "".join(f"  f{n}: [off, on]\n" for n in range(12))
    rows = "".join(
        f"  - {{do: THINK, then: {{f{n}: {to}}}, cost_s: 1, with: {{name: x}}}}\n"
        for n in range(12)
        for to in ("'on'", "'off'")
    )
    facts = facts.replace("off, on", "'off', 'on'")
    with pytest.raises(FileError) as error:
        load(f"{HEAD}facts:\n{facts}goal: {{f0: 'on', f1: 'on', f2: 'on'}}\nactions:\n{rows}")
    assert "task.yaml:5:3: the conditions span more than 100 situations" in str(error.value)
    assert "(2 values)" in str(error.value)


def test_actions_and_values_that_never_occur_are_named(load: Load) -> None:
    text = BOOK.replace("[tray, hand, shelved]", "[tray, hand, lost, shelved]")
    text += "  - {do: THINK, if: {book: lost}, then: {book: tray}, cost_s: 5, p: 1, with: {name: find}}\n"
    every = [str(finding) for finding in task_findings(load(HEAD + text))]
    found = [item for item in every if "needed" in item or "never" in item or "no run" in item]
    assert len(found) == 2
    assert "14:21: no run comes to a situation in which THINK changes something (book lost)" in found[0]
    assert "4:49: book is never 'lost' in any run" in found[1]


def test_journal_of_a_generated_network_is_resumed_and_drawn(
    load: Load, stand: Stand, tmp_path: Path
) -> None:
    task = load(HEAD + BOOK)
    path = tmp_path / "journal.jsonl"
    with Journal(path) as journal:
        fields = {
            "schema": "x",
            "network": task.network.fingerprint(),
            "plan_on": network_fields(task.network),
        }
        journal.append("RUN", 0.0, fields)
        assert names(task, stand, journal, go="F")[-1] == "Success"
    records = read_journal(path).records
    kept = network_of(orjson.loads(orjson.dumps(fields["plan_on"])))
    assert [str(action) for action in kept.network.actions] == [
        str(action) for action in task.network.actions
    ]
    assert standing(task.network, records).route.situation == "home, shelved"
    assert "home, tray" in to_svg(task.network)


def test_shipped_conditions_search_again_before_insert() -> None:
    folder = Path(__file__).parents[3] / "tasks" / "return_book"
    generated = load_task(folder / "conditions.yaml").network
    again = [a for a in generated.actions if a.do == "SEARCH" and "before the slot" in a.source]
    assert len(again) == 1
    assert (len(generated.situations), len(generated.actions)) == (13, 13)
