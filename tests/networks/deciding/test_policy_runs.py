"""Runs of tasks that decide by a policy, whose Successes differ, and whose attempts are shared."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import pytest

from handcart.backends.robot.robot import Robot
from handcart.files.errors import FileError
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.script import follow
from handcart.networks.events.events import Event, Started
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import RunPosition, standing
from handcart.networks.past_runs.journaled_network import network_of
from handcart.networks.runs.run_header import network_fields
from handcart.networks.task.task_file import Task
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from tests.networks.conftest import Stand, Think

HEAD = "format: handcart-task/1\ntitle: t\nrobot: librarian\nstart: a\ngoal: z\n"
Load = Callable[..., Task]


class Weigh(Think):
    """Thinks, and has the result that its script says."""

    results: ClassVar = ("light", "heavy")
    measured: ClassVar[deque[str]] = deque()

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield from super().motion(robot, model)
        self.evidence.result = self.measured.popleft() if self.measured else ""


@pytest.fixture
def primitives() -> SimpleNamespace:
    Weigh.measured = deque()
    return SimpleNamespace(THINK=Think, WEIGH=Weigh)


def lines(*rows: str) -> str:
    names = {word.strip(",}") for row in rows for word in row.split() if word.strip(",}") in set("abcdz")}
    return (
        f"situations: {{{', '.join(f'{name}: {{}}' for name in sorted(names))}}}\nactions:\n{''.join(rows)}"
    )


def think(name: str, rest: str) -> str:
    return f"  - {{do: THINK, with: {{name: {name}}}, {rest}}}\n"


def started(task: Task | ActionNetwork, stand: Stand) -> tuple[list[str], str, int]:
    """Run a task; return the names of its actions, and the situation and status at the end."""
    network = task.network if isinstance(task, Task) else task
    events: list[Event] = []
    end = stand.finish(Coordinator(network, stand.robot, stand.model, observers=[events.append]))
    done = [event.action.binding for event in events if isinstance(event, Started)]
    return [str(binding.fixed["name"]) for binding in done if binding], end.situation, end.exit_status


TRAP = "situations: {a: {}, b: {}, stuck: {}, z: {}}\nactions:\n" + "".join(
    [
        think("short", "from: a, to: z, on_fail: stuck, cost_s: 10, p: 0.5"),
        think("first", "from: a, to: b, cost_s: 10, p: 0.99"),
        think("second", "from: b, to: z, cost_s: 10, p: 0.99"),
    ]
)


@pytest.mark.parametrize(
    ("policy", "names"),
    [("rule", ["short"]), ("expected_cost", ["first", "second"]), ("goal_probability", ["first", "second"])],
)
def test_a_run_follows_the_policy_of_its_file(
    load: Load, stand: Stand, policy: str, names: list[str]
) -> None:
    assert started(load(f"{HEAD}policy: {policy}\n{TRAP}"), stand)[0] == names
    assert started(load(HEAD + TRAP, policy=policy), stand)[0] == names


def test_a_person_is_called_where_that_costs_least(load: Load, stand: Stand) -> None:
    task = load(f"{HEAD}policy: expected_cost\nperson_s: 9\n{TRAP}")
    names, situation, status = started(task, stand)
    assert (names, situation, status) == ([], "a", 4)
    assert "every action costs more than a person (9 s)" in follow(task.network, []).reason


def test_a_success_leads_where_its_result_says(load: Load, stand: Stand) -> None:
    then = "then: [{to: b, p: 0.6, result: light}, {to: c, p: 0.3, result: heavy}]"
    rows = [
        f"  - {{do: WEIGH, with: {{name: weigh}}, from: a, {then}, cost_s: 5}}\n",
        think("carry", "from: b, to: z, cost_s: 1, p: 1"),
        think("push", "from: c, to: z, cost_s: 1, p: 1"),
    ]
    for result, name in (("light", "carry"), ("heavy", "push"), ("", "carry")):
        Weigh.measured.append(result)
        assert started(load(HEAD + lines(*rows)), stand) == (["weigh", name], "z", 0)


def test_otherwise_is_reached_where_no_route_is_left(load: Load, stand: Stand) -> None:
    rows = lines(
        think("try", "from: a, to: z, cost_s: 5, attempts: 1"), think("back", "from: a, to: b, cost_s: 5")
    )
    task = load(HEAD + "otherwise: b\n" + rows)
    stand.script["try"] = deque("F")
    assert started(task, stand) == (["try", "back"], "b", 3)
    assert started(load(HEAD + "otherwise: b\n" + rows), stand) == (["try"], "z", 0)


def test_otherwise_of_a_repeat_is_one_situation_outside(load: Load, stand: Stand) -> None:
    rows = lines(
        think("try", "from: a, to: z, cost_s: 5, attempts: 1"), think("back", "from: a, to: b, cost_s: 5")
    )
    task = load(HEAD + "otherwise: b\nrepeat: {over: [1, 2], as: cup, start: a, goal: z}\n" + rows)
    assert {"a[1]", "a[2]", "b"} <= set(task.network.situations)
    stand.script["try"] = deque("SF")
    assert started(task, stand) == (["try", "try", "back"], "b", 3)


MANY = "".join(
    [
        "situations: {a: {}, b: {}, c: {}, stuck: {}, z: {}}\nactions:\n",
        think("short", "from: a, to: z, on_fail: stuck, cost_s: 10, p: 0.05"),
        "  - {do: WEIGH, with: {name: weigh}, from: a, cost_s: 5, p_give_up: 0.01,\n",
        "     then: [{to: b, p: 0.6, result: light}, {to: c, p: 0.3, result: heavy}]}\n",
        think("carry", "from: b, to: z, cost_s: 1, p: 0.9, attempts: {most: 2, fresh_after: WEIGH}"),
        think("push", "from: c, to: z, cost_s: 9, p: 0.9, attempts: 2"),
        think("pull", "from: c, to: z, cost_s: 12, p: 0.95"),
    ]
)


@pytest.mark.parametrize("policy", ["rule", "expected_cost", "goal_probability"])
def test_a_run_resumed_after_any_action_ends_as_the_whole(
    load: Load, stand: Stand, tmp_path: Path, policy: str
) -> None:
    """With results of Successes, doubled weights, and what the policy remembers of Fails."""
    network = load(f"{HEAD}policy: {policy}\n{MANY}").network
    outcomes = {"push": "FF", "pull": "FS"}
    with Journal(tmp_path / "whole") as journal:
        whole = _run(network, stand, outcomes, journal)
    records = read_journal(tmp_path / "whole").records
    assert whole[0] == "weigh" and whole[-1] == "z" and len(whole) == 6
    cuts = [number for number, record in enumerate(records) if record["kind"] == "RESULT"]
    for count, cut in enumerate(cuts, start=1):
        left = {name: ends[whole[:count].count(name) :] for name, ends in outcomes.items()}
        at = standing(network, records[: cut + 1])
        assert _run(network, stand, left, None, at) == whole[count:]


def _run(
    network: ActionNetwork,
    stand: Stand,
    outcomes: Mapping[str, str],
    journal: Journal | None,
    at: RunPosition | None = None,
) -> list[str]:
    """Run with scripted outcomes, from a position on; return the actions and the situation at the end."""
    Weigh.measured = deque(["heavy"])
    for name, ends in outcomes.items():
        stand.script[name] = deque(ends)
    if journal is not None:
        journal.append("RUN", 0.0, {"schema": "x", "network": network.fingerprint()})
    events: list[Event] = []
    coordinator = Coordinator(network, stand.robot, stand.model, journal, [events.append], standing=at)
    end = stand.finish(coordinator)
    done = [event.action.binding for event in events if isinstance(event, Started)]
    return [*(str(binding.fixed["name"]) for binding in done if binding), end.situation]


def test_attempts_of_a_budget_are_shared(load: Load, stand: Stand) -> None:
    rows = lines(
        think("left", "from: a, to: z, cost_s: 5, attempts: {budget: grasps}"),
        think("right", "from: a, to: z, cost_s: 6, attempts: {budget: grasps}"),
    )
    stand.script["left"], stand.script["right"] = deque("FFFF"), deque("FFFF")
    names, _, status = started(load(HEAD + "budgets: {grasps: 3}\n" + rows), stand)
    assert (names, status) == (["left", "left", "left"], 3)


def test_attempts_are_given_back_after_a_new_look(load: Load, stand: Stand) -> None:
    rows = lines(
        think("look", "from: a, to: b, cost_s: 5"),
        "  - {do: WEIGH, with: {name: insert}, from: b, to: z, on_fail: a, cost_s: 5,"
        " attempts: {most: 1, fresh_after: THINK, renewals: 2}}\n",
    )
    stand.script["insert"] = deque("FFFF")
    names, _, status = started(load(HEAD + rows), stand)
    assert names == ["look", "insert"] * 3 + ["look"] * (names[-1] == "look")
    assert status == 3


def test_an_unlimited_action_is_tried_until_it_succeeds(load: Load, stand: Stand) -> None:
    rows = lines(think("knock", "from: a, to: z, cost_s: 5, attempts: unlimited"))
    stand.script["knock"] = deque("F" * 30)
    names, _, status = started(load(HEAD + rows), stand)
    assert (len(names), status) == (31, 0)


def changed(old: str, new: str) -> str:
    """Return the trap with a change; without `p` beside a `then`."""
    text = TRAP.replace(old, new)
    return text.replace(", p: 0.99}", "}") if "then" in new else text


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("policy: best\n" + TRAP, "policy"),
        ("policy: expected_cost\n" + changed(", p: 0.5", ""), "THINK has no p, which policy"),
        (changed("to: b,", "then: [{to: b, p: 0.8}, {to: z, p: 0.4}],"), "p of all entries"),
        (changed("to: b,", "then: [{to: bb}],"), "unknown situation 'bb'"),
        (changed("p: 0.5", "attempts: {budget: grasp}"), "unknown budget 'grasp'"),
        (changed("p: 0.5", "attempts: {fresh_after: THNK}"), "did you mean 'THINK'"),
        ("otherwise: bb\n" + TRAP, ":6:12: unknown situation 'bb'; did you mean 'b'"),
        (changed("to: b,", ""), "the key 'to' is missing"),
    ],
)
def test_wrong_keys_of_deciding_are_named(load: Load, text: str, wrong: str) -> None:
    with pytest.raises(FileError) as raised:
        load(HEAD + text)
    assert wrong in str(raised.value)


def test_fingerprints_of_files_without_new_keys_stay(load: Load) -> None:
    """Runs of older versions are resumed by this checksum."""
    network = load(HEAD + TRAP).network
    digest = hashlib.sha256(repr((network.start, network.goal)).encode())
    for situation in network.situations.values():
        digest.update(repr((situation.name, sorted(situation.facts.items()), situation.element)).encode())
    for a in network.actions:
        row = (a.do, a.source, a.target, a.on_fail, a.cost_s, a.attempts)
        said = a.binding.said() if a.binding else {}
        digest.update(repr((row, said, a.permit, a.time_out_s)).encode())
    assert network.fingerprint() == digest.hexdigest()


CHANGES = [
    ("policy: expected_cost\n", ""),
    ("policy: expected_cost\nperson_s: 50\n", ""),
    ("otherwise: b\n", ""),
    ("restoring: {attempts: 3, wait_s: 2}\n", ""),
    ("", "attempts: unlimited"),
    ("", "attempts: {fresh_after: THINK}"),
    ("budgets: {tries: 3}\n", "attempts: {budget: tries}"),
]


def test_each_new_key_changes_the_fingerprint(load: Load) -> None:
    texts = [
        HEAD + TRAP,
        *(HEAD + head + TRAP.replace("p: 0.5", f"p: 0.5, {row}".rstrip(", ")) for head, row in CHANGES),
    ]
    prints = [load(text).network.fingerprint() for text in texts]
    assert len(set(prints)) == len(prints)


@pytest.mark.parametrize(("head", "row"), CHANGES)
def test_a_journal_holds_the_network_it_was_decided_in(load: Load, head: str, row: str) -> None:
    network = load(HEAD + head + changed("p: 0.5", f"p: 0.5, {row}".rstrip(", "))).network
    read = network_of(network_fields(network)).network
    assert (read.policy, read.person_s, read.otherwise, read.restoring) == (
        network.policy,
        network.person_s,
        network.otherwise,
        network.restoring,
    )
    for ours, its in zip(network.actions, read.actions, strict=True):
        assert ours.further(network.policy != "rule") == its.further(read.policy != "rule")
