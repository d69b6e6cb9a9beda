"""`handcart campaign`: how each action ended."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.campaign import run_campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.workers import end as end_processes
from handcart.networks.runs.run_options import RunOptions
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[3]

ROUNDS = """\
format: handcart-task/1
title: There and back, twice
robot: librarian
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: here
goal: done
situations: {here: {base: home}, there: {base: shelf}, done: {base: home}}
actions:
  - {do: MOVE_TO, from: here, to: there, cost_s: 30, with: {place: {each: shelf}}}
  - {do: MOVE_TO, from: there, to: done, cost_s: 30, with: {place: home}}
repeat: {over: [shelf_1, shelf_5], as: shelf, start: here, goal: done}
"""


class Trials:
    """Stub of trials: they end as given, by their summaries and a signal before the third one's end."""

    def __init__(self, reason: str, signals: Sequence[signal.Signals] = ()) -> None:
        self.reason, self.signals = reason, signals
        self.seeds: list[int] = []
        self.untrue: dict[int, list[str]] = {}
        self.broken: set[int] = set()

    def __call__(self, setting: CampaignSetting, seed: int) -> Trial:
        self.seeds.append(seed)
        summary = {"outcome": "Success", "reason": "", "run_dir": "none", "seed": seed}
        summary["metrics"] = {"untrue": self.untrue.get(seed, [])}
        summary |= {"sim_time_s": 1.0, "wall_time_s": 1.0, "actions": 1, "fails": 0}
        if seed in self.broken:
            return Trial(seed, 5, summary | {"outcome": "Error", "reason": "TypeError: ours"})
        if seed != 2:
            return Trial(seed, 0, summary)
        for item in self.signals:
            signal.raise_signal(item)
        return Trial(seed, 130, summary | {"outcome": "Cancelled", "reason": self.reason})


@pytest.fixture
def trials(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Trials]:
    def made(*args: Any) -> Trials:
        double = Trials(*args)
        monkeypatch.setattr("handcart.evaluation.campaigns.campaign.run_trial", double)
        return double

    return made


@pytest.mark.parametrize("kind", [None, signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupt_ends_a_campaign_at_once(
    trials: Callable[..., Trials], kind: signal.Signals | None, tmp_path: Path
) -> None:
    """K3: in a trial, which stops by itself then, and between two."""
    ran = trials("interrupted", () if kind is None else (kind,))
    done: list[Trial] = []
    with pytest.raises(KeyboardInterrupt):
        done.extend(run_campaign(CampaignSetting(tmp_path / "task.yaml"), range(5), 1))
    assert [trial.seed for trial in done] == [0, 1]
    assert ran.seeds == [0, 1, 2]


def test_a_trial_that_somebody_stopped_is_left_out(trials: Callable[..., Trials], tmp_path: Path) -> None:
    trials("stopped by request")
    done = list(run_campaign(CampaignSetting(tmp_path / "task.yaml"), range(5), 1))
    assert [trial.seed for trial in done] == [0, 1, 3, 4]


def test_what_ended_before_an_interrupt_is_told(
    trials: Callable[..., Trials],
    handcart: Callable[..., Said],
    tmp_path: Path,
) -> None:
    trials("interrupted")
    said = handcart("campaign", tmp_path / "task.yaml", "--trials", "5", "--jobs", "1", "--json")
    summary = json.loads(said.out)
    assert (said.status, summary["trials"], summary["asked"], summary["interrupted"]) == (130, 2, 5, True)
    assert "interrupted after 2 of 5 trials" in said.err


@pytest.mark.parametrize("as_json", [True, False])
def test_outcomes_that_are_not_so_are_a_fault(
    trials: Callable[..., Trials],
    handcart: Callable[..., Said],
    tmp_path: Path,
    as_json: bool,
) -> None:
    """The campaign ends with status 5, and names the trial to look at first."""
    ran = trials("stopped by request")
    words = ("campaign", tmp_path / "task.yaml", "--trials", "6", "--jobs", "1", *["--json"] * as_json)
    assert handcart(*words).status == 0
    ran.untrue[4] = ["4. RELEASE Success: it stands beside its place"]
    said = handcart(*words)
    assert said.status == 5
    if as_json:
        assert json.loads(said.out)["untrue"] == {"4": ran.untrue[4]}
    else:
        assert "the ground truth contradicts: 1 of 5 trials" in said.out
        assert "\nseed 4: 4. RELEASE Success: it stands beside its place\n" in said.out


def test_a_fault_of_handcart_itself_ends_a_campaign_with_5(
    trials: Callable[..., Trials], handcart: Callable[..., Said], tmp_path: Path, tour: Path
) -> None:
    """So does `merge`, of the parts of such a campaign."""
    trials("stopped by request").broken = {13}
    parts = [tmp_path / name for name in ("first", "second")]
    for number, part in enumerate(parts, 1):
        words = ("--first", "10", "--trials", "6", "--jobs", "1", "--shard", f"{number}/2", "--out", part)
        said = handcart("campaign", tour, *words)
        assert (said.status, "1 x Error: TypeError: ours" in said.out) == (5 * (number == 2), number == 2)
    assert handcart("campaign", "merge", *parts).status == 5


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        (("--jobs", "2"), "--jobs has no effect: --level network without --out and --until counts"),
        (("--cluster", "tcp://nowhere:1"), "--cluster has no effect: --level network"),
        (("--jobs", "1"), ""),
        (("--jobs", "2", "--until", "p > 0.1"), ""),
    ],
)
def test_processes_that_have_no_effect_are_reported(
    handcart: Callable[..., Said], tmp_path: Path, words: tuple[str, ...], reported: str
) -> None:
    said = handcart("campaign", walk(tmp_path), "--level", "network", "--trials", "40", *words)
    assert said.status == 0, said.err
    assert (reported in said.err) if reported else ("no effect" not in said.err)


def test_a_signal_after_a_trials_last_action_ends_the_campaign_too(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """K3: the trial was whole, so it counts."""

    def run(task: Path, runs: Path, options: RunOptions) -> tuple[dict[str, Any], int]:
        assert options.interrupts is not None
        options.interrupts.stop_by(lambda: None)
        signal.raise_signal(signal.SIGTERM)
        return {"outcome": "Success", "reason": "", "metrics": {}}, 0

    monkeypatch.setattr("handcart.evaluation.trials.running.run_task", run)
    trials = run_campaign(CampaignSetting(tmp_path / "task.yaml"), range(500), 1)
    assert next(trials).success
    with pytest.raises(KeyboardInterrupt):
        next(trials)


DEAF_ONCE = """
import signal, time, pathlib
signal.signal(signal.SIGTERM, lambda *_: signal.signal(signal.SIGTERM, signal.SIG_DFL))
pathlib.Path(path).touch()
while True:
    time.sleep(0.05)
"""


def test_process_asked_to_end_as_its_trial_ended_is_asked_again(tmp_path: Path) -> None:
    """K3: else it waits for ever for a lock of the queue that another one took along."""
    ready = tmp_path / "ready"
    process = get_context("spawn").Process(target=exec, args=(DEAF_ONCE, {"path": str(ready)}), daemon=True)
    process.start()
    end = time.monotonic() + 60.0
    while not ready.exists():
        assert time.monotonic() < end
        time.sleep(0.02)
    ending = threading.Thread(target=end_processes, args=([process],), daemon=True)
    ending.start()
    ending.join(20.0)
    assert not process.is_alive()


def living(group: int) -> list[str]:
    """Processes of a group that haven't ended; one that only waits to be asked how it ended has."""
    stats = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            stats.append(path.read_text(encoding="utf-8"))
    rest = [(item, item.rpartition(")")[2].split()) for item in stats]
    return [stat for stat, fields in rest if int(fields[2]) == group and fields[0] != "Z"]


@pytest.mark.slow
@pytest.mark.parametrize(("jobs", "kind"), [(1, signal.SIGTERM), (2, signal.SIGINT)])
def test_a_campaign_of_processes_is_ended_by_a_signal(
    tour: Path, tmp_path: Path, jobs: int, kind: signal.Signals
) -> None:
    """K3: none of its processes is left."""
    words: list[str | Path] = ["campaign", tour, "--trials", "500", "--jobs", str(jobs)]
    words += ["--runs", tmp_path / "runs", "--json"]
    process = subprocess.Popen(
        [sys.executable, "-m", "handcart", *words],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    end = time.monotonic() + 300.0
    while len(list((tmp_path / "runs").glob("*-*/summary.json"))) < 2:
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.02)
    if kind is signal.SIGINT:
        os.killpg(process.pid, kind)  # as a terminal does
    else:
        process.send_signal(kind)
    out, _ = process.communicate(timeout=60.0)
    report = json.loads(out)
    assert (process.returncode, report["interrupted"]) == (130, True)
    assert report["trials"] < 500
    assert set(report["outcomes"]) <= {"Success"}
    end = time.monotonic() + 20.0
    while left := living(process.pid):
        assert time.monotonic() < end, left
        time.sleep(0.05)


@pytest.mark.slow
@pytest.mark.parametrize("as_json", [False, True])
def test_shares_of_each_action(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, as_json: bool
) -> None:
    words = ("campaign", tour, "--trials", "2", "--jobs", "1", "--runs", tmp_path / "runs")
    said = handcart(*words, *(["--json"] if as_json else []))
    assert said.status == 0
    if as_json:
        (share,) = json.loads(said.out)["actions"]
        assert share["action"] == "MOVE_TO (at_home to at_shelf)"
        assert (share["attempts"], share["p"], share["p_give_up"]) == (2, 1.0, 0.0)
        assert share["p_wilson"] == pytest.approx([0.3424, 1.0], abs=1e-4)
    else:
        line = next(item for item in said.out.splitlines() if item.startswith("MOVE_TO"))
        assert line.split()[-6:] == ["2", "1.000", "0.342", "to", "1.000", "0.000"]


@pytest.mark.slow
def test_a_repeated_action_is_one_row_named_as_in_the_file(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    """The last element's copy leads out of the repeat, those of the others back to its start."""
    tour.write_text(ROUNDS, encoding="utf-8")
    said = handcart("campaign", tour, "--trials", "1", "--jobs", "1", "--runs", tmp_path / "runs", "--json")
    assert said.status == 0
    shares = [(action["action"], action["attempts"]) for action in json.loads(said.out)["actions"]]
    assert shares == [("MOVE_TO (here to there)", 2), ("MOVE_TO (there to done)", 2)]


@pytest.mark.parametrize(
    ("generate", "wrong"),
    [
        (["librari"], "unknown kind of generated world; did you mean 'library'?"),
        (["library.blockd=closed"], "unknown key 'blockd'; did you mean 'blocked'?"),
        (["library.blocked=shut"], "allowed: none, way_around, closed"),
        (["library.books=0"], "books=0"),
        (["library", "field.length=3"], "worlds of one kind"),
    ],
)
def test_generated_worlds_are_asked_for_by_name_and_options(
    handcart: Callable[..., Said], generate: list[str], wrong: str
) -> None:
    task = str(ROOT / "tasks" / "return_book" / "task.yaml")
    words = [item for word in generate for item in ("--generate", word)]
    said = handcart("campaign", task, "--trials", "1", *words)
    assert said.status == 2
    assert wrong in said.err
