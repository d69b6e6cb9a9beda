"""Time-outs of a task, several goals in order, rounds, and interrupts."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import orjson
import pytest
from typing_extensions import override

from handcart.backends.capabilities.battery import Battery
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.files.errors import FileError
from handcart.networks.analysis.aim_findings import aim_findings
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.events import Event, Started
from handcart.networks.events.run_end import RunEnd
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import NeedsOperator, standing
from handcart.networks.past_runs.journaled_network import network_of
from handcart.networks.runs.run_header import network_fields
from handcart.networks.task.task_file import Task
from handcart.robotics.geometry.pose2 import Pose2
from tests.networks.conftest import SPEC, Stand, TwoWheels

Load = Callable[..., Task]
HEAD = "format: handcart-task/1\ntitle: t\nrobot: librarian\n"
CIRCLE = """\
start: home
situations: {home: {}, desk: {}, shelf: {}, charged: {}}
actions:
  - {do: DRIVE, from: home, to: desk, cost_s: 2}
  - {do: DRIVE, from: desk, to: shelf, cost_s: 2}
  - {do: DRIVE, from: shelf, to: home, cost_s: 2}
  - {do: DRIVE, from: shelf, to: charged, cost_s: 9}
  - {do: DRIVE, from: charged, to: shelf, cost_s: 9}
  - {do: DRIVE, from: desk, to: home, cost_s: 3}
"""


class Cell(Battery):
    """A battery with a charge for each reading."""

    def __init__(self, *charges: float) -> None:
        self.charges = deque(charges)

    @override
    def charge_percent(self) -> float:
        return self.charges.popleft() if len(self.charges) > 1 else self.charges[0]


class Powered(TwoWheels):
    """Wheels and a battery."""

    def __init__(self, cell: Cell) -> None:
        super().__init__()
        self.cell = cell

    @override
    def capabilities(self) -> tuple[Capability, ...]:
        return (*super().capabilities(), self.cell)


def run(task: Task, stand: Stand, journal: Journal | None = None) -> tuple[list[str], RunEnd]:
    """Run a task; return where its actions led, and its end."""
    events: list[Event] = []
    coordinator = Coordinator(task.network, stand.robot, stand.model, journal, [events.append])
    end = stand.finish(coordinator)
    return [event.action.target for event in events if isinstance(event, Started)], end


def kept(task: Task, stand: Stand, path: Path) -> tuple[list[str], RunEnd]:
    """Run a task with a journal; check the header, and what is retraced from each of its prefixes."""
    with Journal(path) as journal:
        fields = {"schema": "x", "network": task.network.fingerprint()}
        journal.append("RUN", 0.0, fields)
        found = run(task, stand, journal)
    records = read_journal(path).records
    for count in range(1, len(records) + 1):
        here, past = standing(task.network, records[:count]), records[:count]
        kinds = [record["kind"] for record in past]
        assert (here.plans, here.started) == (kinds.count("PLAN"), kinds.count("START"))
        assert here.done == kinds.count("RESULT")
        begun = [record for record in past if record["kind"] in ("START", "RESULT")]
        assert here.in_doubt == (begun[-1] if begun and begun[-1]["kind"] == "START" else None)
        assert here.last_t == past[-1]["t"]
        assert (here.over is not None) is (kinds[-1] == "END")
        refuse_wrong_aims(task, past)
    _, end = found
    assert (here.route.situation, here.fails) == (end.situation, end.fails)
    again = network_of(orjson.loads(orjson.dumps(network_fields(task.network)))).network
    assert again.aims == task.network.aims
    assert again.fingerprint() != ""
    return found


def refuse_wrong_aims(task: Task, records: Sequence[Mapping[str, Any]]) -> None:
    """Check that a last record of another round, or of an interrupt that leads elsewhere, doesn't fit."""
    *before, last = records
    if last["kind"] != "AIM":
        return
    wrong = {
        "round": [{"round": last.get("round", 0) + off} for off in (-1, 1)],
        "interrupt": [{"goal": "x"}],
    }
    for change in wrong.get(last["what"], ()):
        with pytest.raises(NeedsOperator, match="doesn't fit the task's network: "):
            standing(task.network, [*before, {**last, **change}])


def test_goals_are_reached_in_their_order(load: Load, stand: Stand, tmp_path: Path) -> None:
    task = load(f"{HEAD}goal: [shelf, desk, home]\n{CIRCLE}")
    led, end = kept(task, stand, tmp_path / "j")
    assert led == ["desk", "shelf (goal 2)", "home (goal 2)", "desk (goal 3)", "home (goal 3)"]
    assert (end.outcome, end.situation) == ("Success", "home (goal 3)")


def test_goals_of_conditions_are_reached_in_their_order(load: Load, stand: Stand) -> None:
    text = """\
facts: {base: [home, desk, shelf]}
goal: [{base: shelf}, {base: desk}, {base: home}]
actions:
  - {do: DRIVE, then: {base: home}, cost_s: 2}
  - {do: DRIVE, if: {base: home}, then: {base: desk}, cost_s: 2}
  - {do: DRIVE, if: {base: desk}, then: {base: shelf}, cost_s: 2}
"""
    led, end = run(load(HEAD + text), stand)
    assert led == ["desk", "shelf (goal 2)", "home (goal 2)", "desk (goal 3)", "home (goal 3)"]
    assert end.outcome == "Success"


def test_task_time_out_restores_and_pursues_otherwise(load: Load, stand: Stand, tmp_path: Path) -> None:
    task = load(f"{HEAD}goal: charged\ntime_out_s: 5\notherwise: home\n{CIRCLE}")
    led, end = kept(task, stand, tmp_path / "j")
    assert led[:3] == ["desk", "shelf", "charged"]
    assert led[-1] == "home"
    assert (end.outcome, end.situation, end.otherwise) == ("Fail", "home", "home")
    assert end.reason.startswith("the task took longer than 5 s; otherwise: home is reached")
    assert 5.0 < stand.robot.time < 13.0


def test_task_time_out_without_otherwise_ends_the_run(load: Load, stand: Stand) -> None:
    _, end = run(load(f"{HEAD}goal: charged\ntime_out_s: 3\n{CIRCLE}"), stand)
    assert (end.outcome, end.exit_status, end.reason) == ("Fail", 3, "the task took longer than 3 s")


def test_rounds_begin_when_they_are_due_with_all_attempts(load: Load, stand: Stand, tmp_path: Path) -> None:
    text = f"{HEAD}goal: [shelf, home]\nrounds: {{most: 3, every_s: 20}}\n{CIRCLE}"
    led, end = kept(load(text), stand, tmp_path / "j")
    assert len(led) == 9
    assert (end.outcome, end.rounds) == ("Success", 3)
    assert stand.robot.time == pytest.approx(40 + 3 * 2.0 + 1.0, abs=2.0)


def test_rounds_forever_end_by_a_stop(load: Load, stand: Stand) -> None:
    task = load(f"{HEAD}goal: [shelf, home]\nrounds: forever\n{CIRCLE}")
    coordinator = Coordinator(task.network, stand.robot, stand.model)
    end = stand.finish(coordinator, {2000: lambda: coordinator.request(Request.STOP)})
    assert end.outcome == "Cancelled"
    assert end.rounds > 5


def test_unfinished_rounds_are_listed_and_the_next_begins(load: Load, stand: Stand) -> None:
    text = """\
start: home
goal: [a, back]
otherwise: home
rounds: 3
situations: {home: {}, a: {}, back: {}}
actions:
  - {do: THINK, from: home, to: a, cost_s: 1, attempts: 1, with: {name: out}}
  - {do: THINK, from: a, to: back, cost_s: 1, with: {name: back}}
"""
    stand.script["out"] = deque("SFS")
    led, end = run(load(HEAD + text), stand)
    assert led == ["a (goal 2)", "back (goal 2)", "a (goal 2)", "a (goal 2)", "back (goal 2)"]
    assert (end.outcome, end.reason) == ("Fail", "rounds left undone: 2")


def test_interrupts_come_first_and_the_run_goes_on(
    load: Load, tmp_path: Path, new_stand: Callable[[], Stand]
) -> None:
    interrupts = "interrupts: [{name: low, when: {battery_below_percent: 20}, goal: charged, priority: 1}]\n"
    task = load(f"{HEAD}goal: [shelf, home]\n{interrupts}{CIRCLE}")
    plain = run(task, new_stand())[0]
    assert plain == ["desk", "shelf (goal 2)", "home (goal 2)"]
    stand = new_stand()
    stand.robot = Robot(Powered(Cell(50, 15, 15, 90)), RobotFile.model_validate(SPEC), Pose2(0, 0, 0))
    led, end = kept(task, stand, tmp_path / "j")
    on_the_way = ["desk", "shelf (goal 2)", "charged (goal 2)", "shelf (goal 2)", "home (goal 2)"]
    assert (led, end.outcome) == (on_the_way, "Success")


def test_interrupts_of_higher_priority_come_first(load: Load, stand: Stand, tmp_path: Path) -> None:
    rows = (
        "{name: low, when: {every_s: 9}, goal: left, priority: 1}",
        "{name: high, when: {every_s: 9}, goal: right, priority: 2}",
    )
    text = f"""\
start: a
goal: z
interrupts: [{", ".join(rows)}]
situations: {{a: {{}}, b: {{}}, left: {{}}, right: {{}}, z: {{}}}}
actions:
  - {{do: DRIVE, from: a, to: b, cost_s: 9, with: {{periods: 200}}}}
  - {{do: DRIVE, from: b, to: left, cost_s: 1, with: {{periods: 4}}}}
  - {{do: DRIVE, from: left, to: b, cost_s: 1, with: {{periods: 4}}}}
  - {{do: DRIVE, from: b, to: right, cost_s: 1, with: {{periods: 4}}}}
  - {{do: DRIVE, from: right, to: b, cost_s: 1, with: {{periods: 4}}}}
  - {{do: DRIVE, from: b, to: z, cost_s: 1, with: {{periods: 4}}}}
"""
    led, end = kept(load(HEAD + text), stand, tmp_path / "j")
    assert led == ["b", "right", "b", "left", "b", "z"]
    assert end.outcome == "Success"


def test_low_batteries_are_charged_while_a_round_waits(
    load: Load, tmp_path: Path, new_stand: Callable[[], Stand]
) -> None:
    interrupts = "interrupts: [{name: low, when: {battery_below_percent: 20}, goal: charged}]\n"
    actions = "  - {do: DRIVE, from: home, to: charged, cost_s: 9}\n"
    text = f"{HEAD}goal: [shelf, home]\nrounds: {{most: 2, every_s: 60}}\n{interrupts}{CIRCLE}{actions}"
    stand = new_stand()
    cell = Cell(*[50] * 40, 15)
    stand.robot = Robot(Powered(cell), RobotFile.model_validate(SPEC), Pose2(0, 0, 0))
    led, end = kept(load(text), stand, tmp_path / "j")
    assert led == ["desk", "shelf (goal 2)", "home (goal 2)", "charged", "shelf (goal 2)", "home (goal 2)"]
    records = read_journal(tmp_path / "j").records
    charging = next(r for r in records if r["kind"] == "START" and r["action"]["to"] == "charged")
    assert charging["t"] < 30.0
    assert end.rounds == 2
    assert stand.robot.time > 60.0


@pytest.mark.parametrize(
    ("charges", "seconds"),
    [
        pytest.param([50, 15, 15, *range(15, 91)], (1.4, 3.5), id="charged"),
        pytest.param([50, 15, 15, 15], (300.0, 310.0), id="the charge does not rise"),
        pytest.param([50, 15, float("nan")], (0.0, 2.0), id="the charge is not known"),
    ],
)
def test_a_low_battery_is_charged_before_the_run_goes_on(
    load: Load, tmp_path: Path, stand: Stand, charges: list[float], seconds: tuple[float, float]
) -> None:
    when = "{battery_below_percent: 20, until_percent: 80}"
    row = f"interrupts: [{{name: low, when: {when}, goal: charged}}]\n"
    task = load(f"{HEAD}goal: [shelf, home]\n{row}{CIRCLE}")
    stand.robot = Robot(Powered(Cell(*charges)), RobotFile.model_validate(SPEC), Pose2(0, 0, 0))
    led, end = kept(task, stand, tmp_path / "j")
    assert led == ["desk", "shelf (goal 2)", "charged (goal 2)", "shelf (goal 2)", "home (goal 2)"]
    assert end.outcome == "Success"
    starts = [r["t"] for r in read_journal(tmp_path / "j").records if r["kind"] == "START"]
    ends = [r["t"] for r in read_journal(tmp_path / "j").records if r["kind"] == "RESULT"]
    assert seconds[0] <= starts[3] - ends[2] <= seconds[1]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            "goal: shelf\ninterrupts: [{name: a, when: {every_s: 1, until_percent: 9}, goal: home}]\n",
            "until_percent needs battery_below_percent; allowed: a charge above that one",
        ),
        ("goal: [shelf, shel]\n", "4:15: unknown situation 'shel'; did you mean 'shelf'?"),
        ("goal: [shelf, shelf]\n", "4:15: 'shelf' is reached already"),
        ("goal: [home, shelf]\n", "4:8: 'home' is reached already"),
        ("goal: shelf\ntime_out_s: 0\n", "time_out_s is 0; allowed: a number above 0"),
        ("goal: shelf\nrounds: never\n", "rounds is 'never'"),
        ("goal: shelf\ninterrupts: [{name: a, when: {}, goal: home}]\n", "needs one condition"),
        ("goal: shelf\ninterrupts: [{name: a, when: {every_s: 1}, goal: hom}]\n", "unknown situation 'hom'"),
    ],
)
def test_wrong_aims_are_reported_with_their_place(load: Load, keys: str, message: str) -> None:
    with pytest.raises(FileError) as error:
        load(HEAD + keys + CIRCLE)
    assert message in str(error.value)


def test_rounds_that_end_elsewhere_are_refused(load: Load) -> None:
    text = CIRCLE.replace("home: {}, desk: {}", "home: {base: home}, desk: {base: desk}")
    with pytest.raises(FileError) as error:
        load(f"{HEAD}goal: desk\nrounds: 2\n{text}")
    assert "5:9: the goal 'desk' has other facts than the start 'home' (base)" in str(error.value)


def test_interrupts_that_lead_nowhere_are_named_by_check(load: Load) -> None:
    one_way = CIRCLE.replace("  - {do: DRIVE, from: charged, to: shelf, cost_s: 9}\n", "")
    row = "interrupts: [{name: low, when: {every_s: 9}, goal: charged}]\n"
    task = load(f"{HEAD}goal: [shelf, home]\nrounds: {{most: 2, every_s: 20}}\n{row}{one_way}")
    (finding,) = aim_findings(task)
    assert "6:52: low: from 'charged (goal 2)' nothing leads on to the goal" in str(finding)
    assert task.network.aims.words() == {"rounds": "2, every 20 s", "interrupts": "low (priority 0)"}
    fine = load(f"{HEAD}goal: [shelf, home]\n{row}{CIRCLE}")
    assert list(aim_findings(fine)) == []
