"""A robot whose world persists by itself: latched; resumed after acknowledgement (rows N13, K11, U12,
U13).
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.can.can_backend import CanBackend
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.runs.robot_claim import RobotClaim, claims_folder
from handcart.tools.main import main
from tests.tools.conftest import LIBRARY, Said

TASK = """\
format: handcart-task/1
title: Drive twice
robot: cart
backend: can
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: at_home
goal: back
situations: {at_home: {base: home}, at_shelf: {base: shelf}, back: {base: home again}}
actions:
  - {do: MOVE_TO, from: at_home, to: at_shelf, cost_s: 30, with: {place: near}}
  - {do: MOVE_TO, from: at_shelf, to: back, cost_s: 30, with: {place: home}}
"""


def as_real(patch: pytest.MonkeyPatch, folder: Path) -> None:
    """Let simulated drives count as a real robot's, claimed in a folder."""
    patch.setattr(CanBackend, "simulated", property(lambda _: False, lambda _self, _value: None))
    patch.setenv("XDG_STATE_HOME", str(folder / "state"))


def write_task(folder: Path) -> Path:
    """Write the task and its files."""
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        (folder / name).write_bytes((LIBRARY / name).read_bytes())
    with (folder / "places.yaml").open("a") as places:
        places.write("  near: {x_m: 1.2, y_m: 1.8, heading_deg: 90.0}\n")
    path = folder / "twice.yaml"
    path.write_text(TASK, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of each test, so that the paths in a run's files are right where the run is copied to."""
    return tmp_path_factory.mktemp("home") / "real"


@pytest.fixture(scope="module")
def ran(home: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of that folder after one run of the task, whose drive takes seconds."""
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir()
    task = write_task(home)
    with pytest.MonkeyPatch.context() as patch:
        as_real(patch, home)
        with pytest.raises(SystemExit) as end:
            main(["run", str(task), "--runs", str(home / "runs"), "--json"])
    assert not end.value.code
    copy = tmp_path_factory.mktemp("ran") / "real"
    shutil.copytree(home, copy, symlinks=True, ignore=shutil.ignore_patterns("control*"))
    return copy


@pytest.fixture
def task(home: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The task in an empty folder."""
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir()
    as_real(monkeypatch, home)
    return write_task(home)


@pytest.fixture
def once(ran: Path, home: Path, task: Path) -> Path:
    """The folder of a run that ended, with all around it as the run left it."""
    shutil.rmtree(home)
    shutil.copytree(ran, home, symlinks=True)
    return (home / "runs" / "latest").resolve()


@pytest.fixture
def run(handcart: Callable[..., Said], task: Path, home: Path) -> Callable[..., Said]:
    """Runs the task; each run has a folder in `runs`."""
    return lambda *more: handcart("run", task, "--runs", home / "runs", "--json", *more)


def folder_of(said: Said) -> Path:
    return Path(json.loads(said.out.splitlines()[-1])["run_dir"])


def records(folder: Path) -> tuple[dict[str, Any], ...]:
    return read_journal(folder / "journal.jsonl").records


def cut(folder: Path, kind: str, number: int) -> None:
    """Cut a journal off after its `number`-th record of a kind, as a crash would."""
    path = folder / "journal.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    places = [i for i, line in enumerate(lines) if f'"kind":"{kind}"'.encode() in line]
    path.write_bytes(b"".join(lines[: places[number] + 1]))
    (folder / "checkpoint").unlink(missing_ok=True)


def stands_at(task: Path, x: float, y: float, heading_deg: float) -> None:
    """Set the robot's pose in the world's file."""
    world = task.parent / "world.yaml"
    start = f"start: {{x_m: {x}, y_m: {y}, heading_deg: {heading_deg}}}"
    text, count = re.subn(r"^start: .*$", start, world.read_text(), flags=re.M)
    assert count == 1
    world.write_text(text)


def broke_off(folder: Path, kind: str, number: int) -> None:
    """Break the run off at a record, with its claim of the robot left behind."""
    cut(folder, kind, number)
    (claims_folder() / "can-virtual_cart").write_text(f"{folder.resolve()}\n")


@pytest.mark.slow
def test_runs_follow_each_other_where_nothing_waits(run: Callable[..., Said]) -> None:
    for _ in range(2):
        assert run().status == 0
    assert (claims_folder() / "can-virtual_cart").read_text() == ""


def give_up(folder: Path) -> int:
    """Let a run end in GiveUp; the record's number."""
    cut(folder, "START", 1)
    path = folder / "journal.jsonl"
    with Journal.go_on(path, read_journal(path)) as journal:
        fields = {"n": 2, "outcome": "GiveUp", "reason": "a wheel is stuck", "residuals": {}}
        number = journal.append("RESULT", 80.0, fields)
        journal.append("END", 80.0, {"outcome": "GiveUp", "situation": "at_shelf", "reason": "stuck"})
    (claims_folder() / "can-virtual_cart").write_text(f"{folder.resolve()}\n")
    return number


@pytest.mark.slow
def test_after_a_give_up_no_run_starts_until_a_person_acknowledges_it(
    once: Path, run: Callable[..., Said], handcart: Callable[..., Said]
) -> None:
    """N13, U12: a service that starts again and again moves nothing and fills no disk."""
    folder = once
    number = give_up(folder)
    for _ in range(3):
        said = run()
        assert said.status == 6
        assert "waits for a person: a wheel is stuck" in said.err
        assert f"handcart ack {folder} {number}" in said.err
    assert [path.name for path in folder.parent.iterdir() if not path.is_symlink()] == [folder.name]
    assert handcart("ack", folder, number).status == 0
    assert run().status == 0


@pytest.mark.slow
def test_what_waits_for_a_person_is_told_before_a_robot_is_woken(
    once: Path, handcart: Callable[..., Said], monkeypatch: pytest.MonkeyPatch
) -> None:
    """N13: the drives may be off, and the bus with them."""
    give_up(once)
    monkeypatch.setattr(
        "handcart.networks.task.preparing.make_backend", lambda *_, **__: pytest.fail("a robot was woken")
    )
    said = handcart("resume", once)
    assert said.status == 6
    assert "handcart ack" in said.err


@pytest.mark.slow
def test_one_primitive_alone_is_refused_too(once: Path, handcart: Callable[..., Said]) -> None:
    """N13"""
    give_up(once)
    said = handcart("do", "MOVE_TO", "place=shelf_3", "--robot", "cart", "--backend", "can")
    assert said.status == 6
    assert "waits for a person" in said.err


@pytest.mark.slow
def test_a_give_up_of_a_simulated_run_latches_nothing_but_itself(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """N13: a new run is a new world."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    for _ in range(2):
        assert handcart("run", tour, "--runs", tmp_path / "runs").status == 0
    assert not (tmp_path / "state").exists()


@pytest.mark.slow
def test_an_action_that_was_broken_off_waits_too(
    once: Path, run: Callable[..., Said], handcart: Callable[..., Said]
) -> None:
    """N13: the robot's position is unknown."""
    folder = once
    broke_off(folder, "START", 1)
    number = len(records(folder)) - 1
    said = run()
    assert said.status == 6
    assert "action 2, MOVE_TO from at_shelf, was broken off" in said.err
    assert handcart("ack", folder, number).status == 0
    assert run().status == 0


@pytest.mark.slow
def test_broken_off_between_two_actions_nothing_waits(once: Path, run: Callable[..., Said]) -> None:
    broke_off(once, "RESULT", 0)
    assert run().status == 0


@pytest.mark.slow
def test_a_journal_that_is_gone_needs_a_person(once: Path, run: Callable[..., Said]) -> None:
    broke_off(once, "START", 1)
    (once / "journal.jsonl").unlink()
    said = run()
    assert said.status == 6
    assert f"rm {claims_folder() / 'can-virtual_cart'}" in said.err


def test_two_runs_on_one_robot(run: Callable[..., Said], task: Path) -> None:
    """K11"""

    class Real:
        name, address = "can", "virtual cart"

    real: Any = Real()
    with RobotClaim(real, claims_folder()) as other:
        other.begin(Path("/other/run"))
        said = run()
    assert said.status == 2
    assert "is in another run: /other/run" in said.err


@pytest.mark.slow
def test_resume_shows_all_and_moves_only_with_a_persons_word(
    once: Path, handcart: Callable[..., Said], task: Path
) -> None:
    """Known, expected, measured, unknown, next; then `--confirm` with the last record."""
    folder = once
    broke_off(folder, "RESULT", 0)
    at = records(folder)[-1]["at"]["base"]
    stands_at(task, at[0] + 0.005, at[1], at[2] * 57.29578)
    last = len(records(folder)) - 1
    said = handcart("resume", folder)
    assert said.status == 6
    for words in ("known: record", "expected: base at", "measured: base at", "unknown: ", "next: MOVE_TO"):
        assert words in said.err
    assert f"--confirm {last}" in said.err
    assert len(records(folder)) == last + 1
    assert handcart("resume", folder, "--confirm", last - 1).status == 6
    said = handcart("resume", folder, "--confirm", last, "--json")
    assert said.status == 0
    kinds = [record["kind"] for record in records(folder)]
    assert kinds[last + 1 :] == ["RECON", "EPOCH", "START", "RESULT", "END"]
    assert json.loads(said.out.splitlines()[-1])["metrics"].get("untrue", []) == []


@pytest.mark.slow
def test_moved_by_hand_while_nobody_watched(once: Path, handcart: Callable[..., Said], task: Path) -> None:
    """U13: nothing moves, whatever is confirmed."""
    folder = once
    broke_off(folder, "RESULT", 0)
    at = records(folder)[-1]["at"]["base"]
    stands_at(task, at[0] + 0.15, at[1], at[2] * 57.29578)
    said = handcart("resume", folder, "--confirm", len(records(folder)) - 1)
    assert said.status == 6
    assert "the robot isn't where it was left: base_mm 1" in said.err


@pytest.mark.slow
def test_real_action_in_doubt_measured_at_its_start_has_failed(
    once: Path, handcart: Callable[..., Said], task: Path
) -> None:
    folder = once
    broke_off(folder, "START", 1)
    at = records(folder)[-1]["at"]["base"]
    stands_at(task, at[0], at[1], at[2] * 57.29578)
    said = handcart("resume", folder, "--confirm", len(records(folder)) - 1, "--json")
    assert "unknown: how far action 2, MOVE_TO from at_shelf, had come" in said.err
    assert said.status == 0
    assert json.loads(said.out.splitlines()[-1])["fails"] == 1
    closed = next(record for record in records(folder) if record.get("by") == "recon")
    assert (closed["n"], closed["outcome"]) == (2, "Fail")
    assert closed["residuals"]["base_mm"] < 25


@pytest.mark.slow
def test_what_no_sensor_can_tell_needs_a_yes(once: Path, handcart: Callable[..., Said], task: Path) -> None:
    """An INTENT is open: whether it happened only a person knows."""
    folder = once
    broke_off(folder, "START", 1)
    path = folder / "journal.jsonl"
    at = records(folder)[-1]["at"]["base"]
    number = len(records(folder)) - 1
    with Journal.go_on(path, read_journal(path)) as journal:
        journal.append("INTENT", 30.0, {"n": 2, "effect": "the fingers let the book go"})
    stands_at(task, at[0], at[1], at[2] * 57.29578)
    said = handcart("resume", folder, "--confirm", number + 1)
    assert said.status == 6
    assert "unknown: whether it happened: the fingers let the book go" in said.err
    assert f"handcart ack {folder} {number}" in said.err
    assert handcart("ack", folder, number).status == 0
    assert handcart("resume", folder, "--confirm", number + 2).status == 0


@pytest.mark.slow
def test_another_file_of_the_robot_is_another_robot(
    run: Callable[..., Said], handcart: Callable[..., Said], task: Path
) -> None:
    """D12"""
    from handcart.backends.description.robot_names import SHIPPED_FOLDER

    robot = task.parent / "mine.yaml"
    robot.write_text((SHIPPED_FOLDER / "cart" / "robot.yaml").read_text())
    (task.parent / "cart.urdf").write_bytes((SHIPPED_FOLDER / "cart" / "cart.urdf").read_bytes())
    task.write_text(task.read_text().replace("robot: cart", "robot: mine.yaml"))
    folder = folder_of(run())
    broke_off(folder, "RESULT", 0)
    robot.write_text(robot.read_text().replace("base_mm: 25", "base_mm: 50"))
    said = handcart("resume", folder)
    assert said.status == 6
    assert "the robot is not the one that was run" in said.err


@pytest.mark.slow
def test_journal_waits_for_the_disk_only_with_a_real_robot(
    run: Callable[..., Said], monkeypatch: pytest.MonkeyPatch
) -> None:
    import os

    calls = []
    real = os.fdatasync

    def sync(file: int) -> None:
        calls.append(file)
        real(file)

    monkeypatch.setattr(os, "fdatasync", sync)
    folder = folder_of(run())
    assert len(calls) == len(records(folder))
    calls.clear()
    run("--no-sync")
    assert calls == []
