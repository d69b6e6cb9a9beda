"""`handcart learn`: probabilities from campaigns, as a reviewed change of the task's file."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import orjson
import pytest

from handcart.evaluation.campaigns.data.action_ends import action_names
from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial
from handcart.evaluation.campaigns.data.walked_trials import network_trials
from handcart.networks.deciding.posterior import SwitchVerdict
from handcart.networks.entries.action_entry import ActionEntry
from handcart.networks.task.task_file import load_task
from tests.tools.conftest import Said

TASKS = Path(__file__).resolve().parents[3] / "tasks"
NETWORK = """\
start: a
goal: z
situations: {a: {}, b: {}, stuck: {}, z: {}}
actions:
  # the short way
  - {do: MODIFY, from: a, to: z, on_fail: stuck, cost_s: 10, p: 0.5, with: {place: shelf_3}}
  - {do: MODIFY, from: a, to: b, cost_s: 11, p: 0.9, with: {place: shelf_3}}
  - {do: MODIFY, from: b, to: z, cost_s: 12, p: 0.9, with: {place: shelf_3}}
"""


@pytest.fixture
def task(tour: Path) -> Path:
    tour.write_text(tour.read_text().partition("\nstart:")[0] + "\n" + NETWORK)
    return tour


def recorded(task: Path, count: int, name: str) -> Path:
    """Return a campaign's folder with trials as if they had been run."""
    asked: dict[str, Any] = {"task": str(task), "level": "run", "shard": None, "first": 0, "trials": count}
    trials = network_trials(task, {})
    with CampaignFolder.made(task.parent / name, asked).log() as log:
        log.append([trials.trial(seed) for seed in range(count)])
    return task.parent / name


def test_counted_probabilities_are_shown_and_written(handcart: Callable[..., Said], task: Path) -> None:
    campaign = recorded(task, 100, "short")
    before = task.read_text()
    said = handcart("learn", campaign)
    assert said.status == 0, said.err
    assert task.read_text() == before
    assert "never started: its values stay" in said.out
    found = orjson.loads(handcart("learn", campaign, "--json").out)["actions"][0]
    assert found["successes"] + found["fails"] == 100
    assert found["p"] == pytest.approx((found["successes"] + 1) / 102.1, abs=1e-3)
    assert found["p_95"][0] < 0.5 < found["p_95"][1]
    assert found["mean_s"] == pytest.approx(10.0)
    assert handcart("learn", campaign, "--write").status == 0
    assert load_task(task).file.actions[0].p == found["p"]
    assert "# the short way" in task.read_text()
    said_beside = rf"# 20\d\d-\d\d-\d\d: {found['successes']} of 100, p 0\.\d+ to 0\.\d+"
    assert re.search(said_beside, task.read_text())


def test_the_policy_is_changed_where_it_is_surely_better(handcart: Callable[..., Said], task: Path) -> None:
    """The first action of the file is known from trials, the others from the file."""
    said = handcart("learn", recorded(task, 100, "short"), "--write")
    assert "the best one is better than the rule in 100.0% of draws" in said.out
    assert load_task(task).network.policy == "expected_cost"


def test_the_policy_stays_where_too_little_is_known(handcart: Callable[..., Said], task: Path) -> None:
    """After one Success in each of two trials all may still be as the rule takes it."""
    for number in (7, 8):
        task.write_text(task.read_text().replace(f"p: 0.{number}", "p: 0.9"))
    task.write_text(task.read_text().replace("p: 0.5", "p: 0.9"))
    said = handcart("learn", recorded(task, 3, "few"), "--write")
    assert "the policy stays rule" in said.out or "decides as the rule does" in said.out
    assert load_task(task).network.policy == "rule"


def test_a_folder_that_is_no_campaign_is_named(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = handcart("learn", tmp_path)
    assert said.status == 2
    assert "Traceback" not in said.err


@pytest.mark.parametrize(
    ("level", "wrong"),
    [
        ("network", "its trials are of --level network; allowed: those that were run"),
        ("run", "there is no trials.jsonl in it; needed: trials that have ended"),
    ],
)
def test_campaigns_that_are_no_evidence_are_refused(
    handcart: Callable[..., Said], task: Path, level: str, wrong: str
) -> None:
    """Random walks only repeat the probabilities of the file."""
    folder = task.parent / level
    asked: dict[str, Any] = {"task": str(task), "level": level, "shard": None, "first": 0, "trials": 9}
    with CampaignFolder.made(folder, asked).log() as log:
        log.append([network_trials(task, {}).trial(seed) for seed in range(9)])
    if level == "run":
        (folder / "trials.jsonl").unlink()
    said = handcart("learn", folder)
    assert (said.status, wrong in said.err) == (2, True), said.err


CAUSES = """\
start: a
goal: z
situations: {a: {}, b: {}, z: {}}
actions:
  - {do: MODIFY, from: a, to: z, cost_s: 10, with: {place: shelf_3},
     on_fail: {blocked: b, no_route: {to: b, p: 0}, else: {p: 0.5}}}
  - {do: MODIFY, from: b, to: z, cost_s: 12, p: 0.9, with: {place: shelf_3}}
"""


def ended(task: Path, causes: list[str]) -> Path:
    """Return a campaign's folder with an action that ended so; "Success" for a Success."""
    asked: dict[str, Any] = {"task": str(task), "level": "run", "shard": None, "first": 0, "trials": 1}
    ends = [("Success", "") if cause == "Success" else ("Fail", cause) for cause in causes]
    actions = [
        ActionEnd("MODIFY (a to z)", "a", "z", outcome, 10.0 * number, cause=cause)
        for number, (outcome, cause) in enumerate(ends, 1)
    ]
    summary = {"outcome": "Success", "sim_time_s": 100.0, "metrics": {}}
    with CampaignFolder.made(task.parent / "ends", asked).log() as log:
        log.append([Trial(0, 0, summary, actions)])
    return task.parent / "ends"


def test_probabilities_of_causes_are_written_with_intervals(
    handcart: Callable[..., Said], tour: Path
) -> None:
    tour.write_text(tour.read_text().partition("\nstart:")[0] + "\n" + CAUSES)
    campaign = ended(tour, ["Success"] * 60 + ["blocked"] * 30 + ["no_pose"] * 10)
    said = handcart("learn", campaign)
    assert re.search(r"blocked +30 +0\.29\d+ +0\.21\d to 0\.3[89]\d", said.out)
    assert handcart("learn", campaign, "--write").status == 0
    entry = load_task(tour).file.actions[0]
    blocked, no_route = (fail_entry.p or 0.0 for fail_entry in entry.fail_entries.values())
    assert (blocked, no_route) == pytest.approx((30.33 / 102.1, 0.33 / 102.1), abs=2e-3)
    assert isinstance(entry, ActionEntry)
    assert [fail_entry.to for fail_entry in entry.fail_entries.values()] == ["b", "b"]
    other = float(re.search(r"else: \{p: (0\.\d+)\}", tour.read_text())[1])  # type: ignore[index]
    assert (entry.p or 0.0) + blocked + no_route + other == pytest.approx(1.0, abs=1e-4)
    assert re.search(
        r"# 20\S+: 60 of 100, .*; blocked 30 \(p 0.21\d to 0.3[89]\d\), no_pose 10", tour.read_text()
    )


def test_shares_of_causes_stay_where_none_were_recorded(handcart: Callable[..., Said], tour: Path) -> None:
    """What a Fail's causes had of it they keep: the file is valid whatever p becomes."""
    text = CAUSES.replace("cost_s: 10,", "cost_s: 10, p: 0.2,").replace(
        "blocked: b", "blocked: {to: b, p: 0.4}"
    )
    tour.write_text(tour.read_text().partition("\nstart:")[0] + "\n" + text)
    assert handcart("learn", ended(tour, ["Success"] * 90 + [""] * 10), "--write").status == 0
    entry = load_task(tour).file.actions[0]
    assert entry.p == pytest.approx(91 / 102.1, abs=1e-3)
    assert entry.fail_entries["blocked"].p == pytest.approx((1.0 - 91 / 102.1) / 2, abs=1e-3)


OWN_LAYOUT = """\
start: a
goal: z
situations: {a: {}, b: {}, z: {}}
actions:
  # the short way
  - {do: MODIFY, from: a, to: z, on_fail: b, cost_s: 10, p: 0.5, with: {place: shelf_3}}  # mine: at dawn

  # the other one
  - do: MODIFY  # in two
    from: b
    to: z
    cost_s: 12
    p: 0.9

    with:  # where
      place: shelf_3 # the third

# the end
"""


def counted(task: Path, name: str, count: int) -> Path:
    """Return a campaign's folder in which each of a task's actions has succeeded so often."""
    asked: dict[str, Any] = {"task": str(task), "level": "run", "shard": None, "first": 0, "trials": 1}
    ends = [
        ActionEnd(name, name, name, "Success", 10.0 * number, result="")
        for number, name in enumerate(action_names(load_task(task)) * count, 1)
    ]
    summary = {"outcome": "Success", "sim_time_s": 1e4, "metrics": {}}
    with CampaignFolder.made(task.parent / name, asked).log() as log:
        log.append([Trial(0, 0, summary, ends)])
    return task.parent / name


def test_comments_and_blank_lines_of_a_file_are_kept(handcart: Callable[..., Said], tour: Path) -> None:
    """A count is added to a comment at the action's end, and replaces an earlier count."""
    tour.write_text(tour.read_text().partition("\nstart:")[0] + "\n" + OWN_LAYOUT)
    for count in (20, 30):
        said = handcart("learn", counted(tour, f"of_{count}", count), "--write")
        assert said.status == 0, said.err
        after = tour.read_text()
        remark = rf"20\d\d-\d\d-\d\d: {count} of {count}, p 0\.\d+ to \d\.\d+\n"
        assert re.search(rf"place: shelf_3\}}\}} +# mine: at dawn; {remark}\n  # the other one\n", after)
        assert re.search(r"  - do: MODIFY  # in two\n .*\n .*\n .*\n .*\n\n    with: +# where\n", after)
        assert re.search(rf"      place: shelf_3 +# the third; {remark}\n# the end\n", after)
        assert after.count(" of ") == 2
        assert load_task(tour).file.actions[1].p == pytest.approx((count + 1) / (count + 2.1), abs=1e-3)


LONG_ROWS = """\
start: a
goal: z
situations: {a: {}, b: {}, stuck: {}, z: {}}
actions:
  - {do: MODIFY, from: a, to: z, on_fail: stuck,
     cost_s: 10, p: 0.5, with: {place: shelf_3}}
  - {do: MODIFY, from: b, to: z,
     cost_s: 12, p: 0.9,
     with: {place: shelf_3}}
"""


def test_rows_that_are_not_changed_keep_their_lines(handcart: Callable[..., Said], tour: Path) -> None:
    """No trial starts the second action."""
    tour.write_text(tour.read_text().partition("\nstart:")[0] + "\n" + LONG_ROWS)
    assert handcart("learn", recorded(tour, 20, "first"), "--write").status == 0
    after = tour.read_text()
    assert re.search(r" of 20, ", after)
    assert after.endswith(LONG_ROWS[LONG_ROWS.index("  - {do: MODIFY, from: b") :])


def test_rows_that_are_changed_keep_their_lines(handcart: Callable[..., Said], tour: Path) -> None:
    """Values are replaced where they are, a new one is added behind the last."""
    rows = LONG_ROWS.replace("cost_s: 12, p: 0.9,", "cost_s: 12,  # by a watch")
    tour.write_text(tour.read_text().partition("\nstart:")[0] + "\n" + rows)
    said = handcart("learn", counted(tour, "both", 20), "--write")
    assert said.status == 0, said.err
    number, words = r"0\.\d+", r"  # 20\S+ 20 of 20, .*"
    first = (
        rf"a, to: z, on_fail: stuck,\n     cost_s: 10\.0, p: {number}, with: {{place: shelf_3}}}}{words}\n"
    )
    second = r"from: b, to: z,\n     cost_s: 10\.0,  # by a watch\n     with: "
    assert re.search(first, tour.read_text()), tour.read_text()
    assert re.search(rf"{second}{{place: shelf_3}}, p: {number}}}{words}\n", tour.read_text())


def test_learning_names_a_damaged_last_line(handcart: Callable[..., Said], task: Path) -> None:
    campaign = recorded(task, 5, "torn")
    log = campaign / "trials.jsonl"
    assert "damaged" not in handcart("learn", campaign).err
    log.write_bytes(log.read_bytes()[:-20])
    assert f"{campaign}: the last line of its log is damaged" in handcart("learn", campaign).err


def test_an_action_that_always_failed_can_be_learned(handcart: Callable[..., Said], task: Path) -> None:
    said = handcart("learn", ended(task, ["blocked"] * 5000), "--write")
    assert said.status == 0, said.err
    assert load_task(task).file.actions[0].p == 0.001


@pytest.mark.parametrize(("times", "shown"), [([10.0, 20.0], False), ([10.0, 21.0], True)])
def test_equal_durations_give_no_interval(
    handcart: Callable[..., Said], task: Path, times: list[float], shown: bool
) -> None:
    asked: dict[str, Any] = {"task": str(task), "level": "run", "shard": None, "first": 0, "trials": 1}
    ends = [ActionEnd("MODIFY (a to z)", "a", "z", "Fail", time) for time in times]
    summary = {"outcome": "Fail", "sim_time_s": 100.0, "metrics": {}}
    with CampaignFolder.made(task.parent / "twice", asked).log() as log:
        log.append([Trial(0, 0, summary, ends)])
    found = orjson.loads(handcart("learn", task.parent / "twice", "--json").out)["actions"][0]
    assert (found["mean_95_s"] != [None, None]) is shown


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.parent.name for path in TASKS.glob("*/task.yaml")))
def test_each_shipped_task_can_be_learned_again_and_again(
    handcart: Callable[..., Said], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str
) -> None:
    """Its comments stay, in their order; which policy is the best one is not the question here."""
    monkeypatch.setattr(
        "handcart.networks.deciding.posterior.judge_switch", lambda *_: SwitchVerdict(0.5, 0.0, True)
    )
    task = shutil.copytree(TASKS, tmp_path / "tasks") / name / "task.yaml"
    comments = re.findall(r"(?:^|(?<=\s))#.*", task.read_text(), re.MULTILINE)
    actions = len(load_task(task).file.actions)
    for count in (3, 4):
        said = handcart("learn", counted(task, f"of_{count}", count), "--write")
        assert said.status == 0, said.err
        after = task.read_text()
        remark = r"20\d\d-\d\d-\d\d: \d+ of \d+, p 0\.\d+ to \d\.\d+(?:; \w+ 0 \(p .*)?"
        assert len(re.findall(remark, after)) == actions
        kept = [
            re.sub(f"# {remark}$|; {remark}$", "", one)
            for one in re.findall(r"(?:^|(?<=\s))#.*", after, re.MULTILINE)
        ]
        assert [one for one in kept if one] == comments
        load_task(task)
