"""`on_fail` with a situation for each cause: files, runs, figures, findings."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from handcart.backends.robot.robot import Robot
from handcart.evaluation.campaigns.walks.walk_table import NotWalked, WalkTable
from handcart.files.errors import FileError
from handcart.networks.analysis.forecast import Forecaster, forecast
from handcart.networks.analysis.task_findings import task_findings
from handcart.networks.chains.chance import Chance
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.deciding.best_planner import BestPlanner, chances_of
from handcart.networks.deciding.planners import planner_of
from handcart.networks.drawing.drawing import to_dot, to_mermaid, to_svg
from handcart.networks.events.events import Event, Started
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.planner import Plan
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import standing
from handcart.networks.past_runs.journaled_network import network_of
from handcart.networks.runs.run_header import network_fields
from handcart.networks.task.task_file import Task
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from tests.networks.conftest import Stand, Think

HEAD = "format: handcart-task/1\ntitle: t\nrobot: librarian\nstart: a\ngoal: z\n"
NETWORK = """\
situations: {a: {}, b: {}, c: {}, z: {}}
actions:
  - {do: TRIP, from: a, to: z, cost_s: 10, attempts: 2, p: 0.7, with: {name: ahead},
     on_fail: {blocked: {to: b, p: 0.2}, slipped: {to: c, p: 0.06}}}
  - {do: TRIP, from: b, to: z, cost_s: 30, p: 0.9, with: {name: around}}
"""
Load = Callable[..., Task]


class Trip(Think):
    """Thinks, or fails by the cause that its script says."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        left = self.script.get(self.name)
        match left.popleft() if left else "S":
            case "B":
                raise Discrepancy("blocked", cause=causes.BLOCKED)
            case "L":
                raise Discrepancy("slipped", cause=causes.SLIPPED)
            case "O":
                raise Discrepancy("lost", cause=causes.LOST)
        return
        yield


@pytest.fixture
def primitives() -> SimpleNamespace:
    return SimpleNamespace(THINK=Think, TRIP=Trip)


def done(network: ActionNetwork, stand: Stand, journal: Journal | None = None, **script: str) -> list[str]:
    """The names of the actions that a run starts, and the situation at its end."""
    for name, ends in script.items():
        stand.script[name] = deque(ends)
    events: list[Event] = []
    end = stand.finish(Coordinator(network, stand.robot, stand.model, journal, [events.append]))
    names = [event.action.binding for event in events if isinstance(event, Started)]
    return [*(str(binding.fixed["name"]) for binding in names if binding), end.situation]


@pytest.mark.parametrize(
    ("ends", "expected"),
    [
        ("", ["ahead", "z"]),
        ("B", ["ahead", "around", "z"]),
        ("L", ["ahead", "c"]),
        ("O", ["ahead", "ahead", "z"]),
        ("OB", ["ahead", "ahead", "around", "z"]),
        ("OO", ["ahead", "ahead", "a"]),
    ],
)
def test_the_cause_decides_where_a_fail_leads(
    load: Load, stand: Stand, ends: str, expected: list[str]
) -> None:
    assert done(load(HEAD + NETWORK).network, stand, ahead=ends) == expected


def test_all_other_causes_lead_to_else(load: Load, stand: Stand) -> None:
    network = load(HEAD + NETWORK.replace("slipped: {to: c, p: 0.06}", "slipped: {p: 0.06}, else: c")).network
    assert done(network, stand, ahead="O") == ["ahead", "c"]
    assert done(network, stand, ahead="LB") == ["ahead", "ahead", "around", "z"]


def test_the_old_form_is_else_alone(load: Load) -> None:
    old = load(HEAD + NETWORK.replace("{blocked: {to: b, p: 0.2}, slipped: {to: c, p: 0.06}}", "b")).network
    new = load(HEAD + NETWORK.replace("{blocked: {to: b, p: 0.2}, slipped: {to: c, p: 0.06}}", "{else: b}"))
    assert old.fingerprint() == new.network.fingerprint()
    assert old.fingerprint() != load(HEAD + NETWORK).network.fingerprint()


AROUND = 0.999
P_GOAL = 0.7 + 0.2 * AROUND + 0.04 * (0.7 + 0.2 * AROUND)
"""The goal at once, around, or in a second attempt after another cause."""


@pytest.mark.parametrize("policy", ["rule", "expected_cost", "goal_probability"])
def test_probabilities_by_cause_are_exact(load: Load, policy: str) -> None:
    network = load(f"{HEAD}policy: {policy}\n{NETWORK}").network
    assert forecast(network, chances_of(network)).goal == pytest.approx(P_GOAL, abs=1e-12)
    planner = planner_of(network)
    if isinstance(planner, BestPlanner):
        assert planner.best.decision(planner.best.state("a", {})).action is network.actions[0]


def test_a_dangerous_cause_changes_the_best_decision(load: Load) -> None:
    text = NETWORK + "  - {do: TRIP, from: a, to: z, cost_s: 25, p: 0.99, with: {name: safe}}\n"
    harmless = text.replace("p: 0.2}", "p: 0.3}").replace("p: 0.06}", "p: 0.0}")
    dangerous = text.replace("p: 0.2}", "p: 0.0}").replace("p: 0.06}", "p: 0.3}")
    for network_text, first in ((harmless, "ahead"), (dangerous, "safe")):
        network = load(f"{HEAD}policy: expected_cost\n{network_text}").network
        plan = planner_of(network).plan("a")
        assert isinstance(plan, Plan)
        assert plan.actions[0].binding is not None
        assert plan.actions[0].binding.fixed["name"] == first


def test_the_slope_of_p_is_that_of_two_forecasts(load: Load) -> None:
    network = load(HEAD + NETWORK).network
    chances = chances_of(network)
    moved = [Chance(0.7 + 1e-6), chances[1]]
    slope = (forecast(network, moved).goal - forecast(network, chances).goal) / 1e-6
    assert Forecaster(network, chances).slopes()[0] == pytest.approx(slope, abs=1e-5)


def test_a_journal_leads_to_the_same_situation(load: Load, stand: Stand, tmp_path: Path) -> None:
    network = load(HEAD + NETWORK).network
    with Journal(tmp_path / "j") as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": network.fingerprint()})
        assert done(network, stand, journal, ahead="B") == ["ahead", "around", "z"]
    found = standing(network, read_journal(tmp_path / "j").records)
    assert found.route.situation == "z"
    kept = network_of(json.loads(json.dumps(network_fields(network)))).network
    assert [action.fail_endings for action in kept.actions] == [
        action.fail_endings for action in network.actions
    ]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("{to: b, p: 0.2}", "{to: d, p: 0.2}", "unknown situation 'd'"),
        ("c: {}", "c: {arm: out}", "'c' has other physical facts than 'a'"),
        ("{to: b, p: 0.2}", "b", "the Fail by 'blocked' has no p"),
        ("p: 0.06", "p: 0.2", "p of all causes together is 0.4; allowed: at most 0.3"),
        ("p: 0.06", "q: 0.06", "unknown key 'q'"),
    ],
)
def test_a_fault_in_a_cause_is_named_with_its_place(load: Load, old: str, new: str, said: str) -> None:
    with pytest.raises(FileError, match=said) as found:
        load(HEAD + NETWORK.replace(old, new, 1))
    assert "task.yaml:9:" in str(found.value)


def test_check_names_causes_that_no_fail_has(load: Load) -> None:
    task = load(HEAD + NETWORK.replace("blocked:", "blokced:"))
    findings = [str(finding) for finding in task_findings(task)]
    assert any(
        "no Fail of TRIP has the cause 'blokced'; did you mean 'blocked'?" in finding for finding in findings
    )
    assert any(
        "(a to c), after a Fail of TRIP by 'slipped', ends with status 3" in finding for finding in findings
    )
    assert not any("blokced" in str(finding) for finding in task_findings(load(HEAD + NETWORK)))


REPEATED = """\
situations: {a: {}, b: {}, z: {}}
actions:
  - {do: TRIP, from: a, to: z, cost_s: 10, on_fail: {blocked: b, lost: z}, with: {name: {each: one}}}
  - {do: TRIP, from: b, to: z, cost_s: 30, with: {name: around}}
repeat: {over: [x, y], as: one, start: a, goal: z}
"""


def test_copies_of_a_repeat_keep_their_own_targets(load: Load, stand: Stand) -> None:
    network = load(HEAD + REPEATED).network
    assert [ending.target for ending in network.actions[0].fail_endings] == ["b[1]", "a[2]"]
    assert [ending.target for ending in network.actions[1].fail_endings] == ["b[2]", "z"]
    assert done(network, stand, x="B", y="O") == ["x", "around", "y", "z"]


def test_drawings_name_the_causes(load: Load) -> None:
    network = load(HEAD + NETWORK).network
    assert "TRIP fails: blocked" in to_mermaid(network)
    assert 'label="TRIP fails: slipped", style=dashed' in to_dot(network)
    assert to_svg(network).startswith("<svg")


def test_a_walk_without_a_robot_refuses_causes(load: Load) -> None:
    with pytest.raises(NotWalked, match="by result or cause"):
        WalkTable(load(HEAD + NETWORK).network)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("{to: b, p: 0.2}", "{too: b, p: 0.2}", "unknown key 'too'; did you mean 'to'? allowed: p, to"),
        ("{to: b, p: 0.2}", "3", "blocked is 3; allowed: text in quotes or a mapping with the keys p, to"),
        ("attempts: 2", "attempts: {mst: 2}", "unknown key 'mst'; did you mean 'most'?"),
    ],
)
def test_wrong_key_inside_a_choice_has_one_message(load: Load, old: str, new: str, message: str) -> None:
    with pytest.raises(FileError) as raised:
        load(HEAD + NETWORK.replace(old, new, 1))
    (finding,) = raised.value.findings
    assert finding.message.startswith(message)
