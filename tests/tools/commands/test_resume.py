"""Resume of a run that broke off (rows K1, K2, D1, D2, D12, N13, U12)."""

from __future__ import annotations

import fcntl
import json
import os
import random
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from benchmarks.damage.forging import reseal
from handcart.backends.saved_state import NotAState
from handcart.evaluation.trials.running import run_task
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.waiting import waiting
from handcart.networks.operator.acknowledging import NothingToAcknowledge, acknowledge
from handcart.networks.run_files.run_folder import read_run_journal
from handcart.networks.runs.checkpoint import load_checkpoint
from handcart.networks.runs.run_options import RunOptions
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[3]
TASK = ROOT / "tasks" / "return_book" / "task.yaml"


THERE_AND_BACK = """\
format: handcart-task/1
title: There and back
robot: librarian
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: here
goal: back
situations: {here: {base: home}, there: {base: home}, back: {base: home}}
actions:
  - {do: MOVE_TO, from: here, to: there, cost_s: 30, with: {place: home}}
  - {do: MOVE_TO, from: there, to: back, cost_s: 30, with: {place: home}}
"""


def killed(runs: Path, seconds: float) -> Path:
    """The folder of a run of return_book that was killed so long after it began to move."""
    command = [sys.executable, "-m", "handcart", "run", str(TASK), "--runs", str(runs)]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    folder = runs / "return_book-0"
    while not (folder / "control").exists():
        assert process.poll() is None
        time.sleep(0.01)
    time.sleep(seconds)
    process.kill()
    process.wait()
    return folder


def finished(folder: Path) -> Counter[int]:
    """Return the number of Successes of each action of the network."""
    started, done = {}, Counter[int]()
    for record in read_journal(folder / "journal.jsonl").records:
        if record["kind"] == "START":
            started[record["n"]] = record["action"]["index"]
        if record["kind"] == "RESULT" and record["outcome"] == "Success":
            done[started[record["n"]]] += 1
    return done


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A run that came to its end, and what it said."""
    runs = tmp_path_factory.mktemp("runs")
    end, _ = run_task(TASK, runs, RunOptions(checkpoints=True))
    return runs / "return_book-0", end


@pytest.fixture
def whole(once: tuple[Path, dict[str, Any]], tmp_path: Path) -> tuple[Path, dict[str, Any]]:
    """A copy of it."""
    folder = tmp_path / "whole" / "return_book-0"
    shutil.copytree(once[0], folder, ignore=shutil.ignore_patterns("control*"))
    return folder, once[1]


def cut(folder: Path, kind: str, number: int) -> None:
    """Cut a journal off before its `number`-th record of a kind."""
    path = folder / "journal.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    places = [i for i, line in enumerate(lines) if f'"kind":"{kind}"'.encode() in line]
    path.write_bytes(b"".join(lines[: places[number]]))


@pytest.mark.slow
def test_killed_at_any_instant_it_ends_as_it_would_have(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    """K1, K2: no finished action is repeated; `benchmarks.hostile.crashes` kills at many instants."""
    folder = killed(tmp_path, random.Random(3).uniform(0.2, 3.0))
    before = finished(folder)
    said = handcart("resume", folder, "--json")
    assert said.status == 0, said.err
    end = json.loads(said.out.splitlines()[-1])
    assert (end["outcome"], end["situation"], end["metrics"]["untrue"]) == ("Success", "returned", [])
    assert set(finished(folder).values()) == {1}
    assert before <= finished(folder)


@pytest.mark.slow
def test_killed_before_its_end_was_noted_nothing_is_done_again(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    folder, end = whole
    cut(folder, "END", 0)
    said = handcart("resume", folder, "--json")
    assert said.status == 0
    again = json.loads(said.out.splitlines()[-1])
    assert (again["outcome"], again["situation"]) == (end["outcome"], end["situation"])
    assert again["sim_time_s"] == end["sim_time_s"]


@pytest.mark.slow
def test_a_result_that_only_the_checkpoint_has_is_recovered(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    folder, _ = whole
    cut(folder, "RESULT", -1)
    said = handcart("resume", folder, "--json")
    assert said.status == 0
    assert "recovered: action 8 had ended with Success" in said.err
    assert set(finished(folder).values()) == {1}


@pytest.mark.slow
def test_a_torn_tail_is_set_aside_and_told(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """D1"""
    folder, _ = whole
    path = folder / "journal.jsonl"
    cut(folder, "END", 0)
    path.write_bytes(path.read_bytes()[:-7])
    said = handcart("resume", folder)
    assert said.status == 0
    assert "torn: the journal's tail from byte" in said.err
    assert len(list(folder.glob("journal.jsonl.torn-*"))) == 1
    assert read_journal(path).torn_at is None


@pytest.mark.slow
def test_damage_inside_is_refused_with_its_place(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """D2"""
    folder, _ = whole
    path = folder / "journal.jsonl"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(bytes(content))
    said = handcart("resume", folder)
    assert said.status == 5
    assert "isn't what was written" in said.err
    assert path.read_bytes() == bytes(content)


@pytest.mark.slow
def test_a_run_that_came_to_its_end_is_not_resumed(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    folder, _ = whole
    said = handcart("resume", folder)
    assert said.status == 2
    assert "is over: Success" in said.err


@pytest.mark.slow
def test_a_real_robot_moves_only_when_a_person_has_looked(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    from handcart.backends.kinematic.kinematic_backend import KinematicBackend

    folder, _ = whole
    cut(folder, "END", 0)
    last = len(read_journal(folder / "journal.jsonl").records) - 1
    monkeypatch.setattr(KinematicBackend, "simulated", False)
    said = handcart("resume", folder)
    assert said.status == 6
    assert f"--confirm {last}" in said.err
    assert handcart("resume", folder, "--confirm", last - 1).status == 6
    assert handcart("resume", folder, "--confirm", last).status == 0


@pytest.mark.slow
def test_another_task_is_not_gone_on_with(handcart: Callable[..., Said], tour: Path, tmp_path: Path) -> None:
    """D12"""
    handcart("run", tour, "--runs", tmp_path / "runs")
    folder = tmp_path / "runs" / f"{tour.stem}-0"
    cut(folder, "END", 0)
    tour.write_text(tour.read_text().replace("cost_s: 30", "cost_s: 31"))
    said = handcart("resume", folder)
    assert said.status == 6
    assert "its network is another one" in said.err


@pytest.mark.slow
def test_a_give_up_is_latched_until_a_person_acknowledges_that_record(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """N13, U12"""
    folder, _ = whole
    cut(folder, "RESULT", 6)
    path = folder / "journal.jsonl"
    (folder / "checkpoint").unlink()
    with Journal.go_on(path, read_journal(path)) as journal:
        fields = {"n": 7, "outcome": "GiveUp", "reason": "the book fell", "residuals": {}}
        number = journal.append("RESULT", 80.0, fields)
        journal.append("END", 80.0, {"outcome": "GiveUp", "situation": "in_slot", "reason": "the book fell"})
    said = handcart("resume", folder)
    assert said.status == 6
    assert f"handcart ack {folder} {number}" in said.err
    assert handcart("ack", folder, number - 1).status == 2
    assert handcart("ack", folder, number).status == 0
    with pytest.raises(NothingToAcknowledge):
        acknowledge(folder, number)
    assert "holds no checkpoint" in handcart("resume", folder).err


@pytest.mark.slow
def test_a_run_begun_elsewhere_is_gone_on_with(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    """A run begun with `--from`; and one that is over says so."""
    tour.write_text(THERE_AND_BACK, encoding="utf-8")
    handcart("run", tour, "--from", "there", "--runs", tmp_path / "runs")
    folder = tmp_path / "runs" / f"{tour.stem}-0"
    said = handcart("resume", folder)
    assert (said.status, "is over: Success" in said.err) == (2, True)
    cut(folder, "END", 0)
    said = handcart("resume", folder, "--json")
    assert said.status == 0
    assert json.loads(said.out.splitlines()[-1])["situation"] == "back"


@pytest.mark.slow
def test_ended_run_reports_so_without_task_and_checkpoint(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """Nothing but the journal is read of it."""
    folder, _ = whole
    (folder / "checkpoint").write_bytes(b"cposix\nsystem\n(Vtrue\ntR.")
    assert "is over: Success" in handcart("resume", folder).err


@pytest.mark.slow
def test_a_checkpoint_that_is_not_the_journals_is_refused(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """A checkpoint of action 8 with a journal that ends before action 4: nothing begins again."""
    folder, _ = whole
    cut(folder, "START", 3)
    before = (folder / "journal.jsonl").read_bytes()
    said = handcart("resume", folder)
    assert said.status == 6
    assert "is not the one that its journal names: it is of action 8" in said.err
    assert (folder / "journal.jsonl").read_bytes() == before


@pytest.mark.slow
def test_a_checkpoint_one_ahead_of_another_journal_is_refused(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """Only the one that was kept right after the journal's last record is taken."""
    folder, _ = whole
    cut(folder, "RESULT", -1)
    reseal(folder, lambda records: records[-1].update(t=records[-1]["t"] + 1.0))
    said = handcart("resume", folder)
    assert (said.status, "is not the one that its journal names" in said.err) == (6, True)


@pytest.mark.slow
def test_what_a_journal_says_does_nothing_to_a_terminal(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """T18, D15: control characters are printed in escaped form."""
    folder, _ = whole
    cut(folder, "END", 0)
    path = folder / "journal.jsonl"
    with Journal.go_on(path, read_journal(path)) as journal:
        journal.append("END", 80.0, {"outcome": "GiveUp", "situation": "returned", "reason": "\x1b[2J"})
    number = len(read_journal(path).records) - 1
    for words in (("resume", folder), ("ack", folder, number)):
        said = handcart(*words)
        assert "\\x1b[2J" in said.out + said.err
        assert "\x1b" not in said.out + said.err


@pytest.mark.slow
def test_a_damaged_checkpoint_is_refused(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """300 flipped bits, none of them taken; one of them through the command."""
    folder, _ = whole
    cut(folder, "END", 0)
    path = folder / "checkpoint"
    content = path.read_bytes()
    rng = random.Random(0)
    for _ in range(300):
        damaged = bytearray(content)
        damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)
        path.write_bytes(damaged)
        with pytest.raises(NotAState):
            load_checkpoint(folder)
    said = handcart("resume", folder)
    assert (said.status, "no saved state" in said.err) == (2, True)
    path.unlink()
    assert "holds no checkpoint" in handcart("resume", folder).err


@pytest.mark.slow
def test_a_damaged_last_start_leaves_that_action_in_doubt(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """D3: never "not done"."""
    folder, _ = whole
    cut(folder, "START", 4)
    path = folder / "journal.jsonl"
    path.write_bytes(path.read_bytes() + b'{"q":99,"p":"damaged')
    (folder / "checkpoint").unlink()
    said = handcart("resume", folder)
    assert "how far action 5" in said.err
    assert "the content of record" in said.err


@pytest.mark.slow
def test_a_real_robots_damaged_last_start_waits_for_a_person(whole: tuple[Path, dict[str, Any]]) -> None:
    """D3, N13: until a person has acknowledged that all is as it was before it."""
    folder, _ = whole
    cut(folder, "START", 4)
    reseal(folder, lambda records: records[0].update(simulated=False))
    path = folder / "journal.jsonl"
    number = len(read_journal(path).records)
    path.write_bytes(path.read_bytes() + b'{"q":99,"p":"damaged')
    assert waiting(read_run_journal(folder)) == {
        number: f"record {number} is damaged: an action may have begun"
    }
    acknowledge(folder, number)
    assert waiting(read_run_journal(folder)) == {}


@pytest.mark.slow
@pytest.mark.parametrize("word", ["resume", "ack"])
def test_a_run_that_is_alive_is_left_alone(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]], word: str
) -> None:
    folder, _ = whole
    cut(folder, "END", 0)
    with (folder / "journal.jsonl").open("ab") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        said = handcart(word, folder, *(["0"] if word == "ack" else []))
    assert said.status == 2
    assert (f"the run in {folder} is alive" in said.err) == (word != "ack")


@pytest.mark.slow
def test_a_journal_of_another_version_is_told(
    handcart: Callable[..., Said], whole: tuple[Path, dict[str, Any]]
) -> None:
    """D12"""
    folder, _ = whole
    cut(folder, "END", 0)
    reseal(folder, lambda records: records[0].update(handcart="9.0"))
    said = handcart("resume", folder)
    assert (said.status, "run is one of handcart '9.0'" in said.err) == (6, True)
    reseal(folder, lambda records: records[0].update(schema="handcart-journal/7"))
    said = handcart("resume", folder)
    assert (said.status, "'handcart-journal/7'" in said.err) == (6, True)


@pytest.mark.slow
def test_a_path_that_is_no_folder_of_a_run(handcart: Callable[..., Said], tour: Path, tmp_path: Path) -> None:
    """A dangling link in place of the run's folder, and a path that is not UTF-8."""
    (tmp_path / "runs").mkdir()
    link = tmp_path / "runs" / f"{tour.stem}-0"
    link.symlink_to(tmp_path / "nothing")
    said = handcart("resume", link)
    assert (said.status, "it is a link to nothing" in said.err) == (2, True)
    tour.write_text(tour.read_text().replace("place: shelf_3", "place: home"), encoding="utf-8")
    assert handcart("run", tour, "--runs", tmp_path / "runs").status == 0
    assert not (tmp_path / "nothing").exists()
    odd = os.fsdecode(bytes(tmp_path) + b"/\xff")
    said = handcart("run", tour, "--runs", odd)
    assert (said.status, "is not UTF-8" in said.err) == (2, True)
