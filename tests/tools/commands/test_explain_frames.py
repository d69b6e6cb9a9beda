"""Frames beside the journal, and in `handcart explain`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import can
import pytest
from can.io.canutils import CanutilsLogReader

from handcart.backends.can.bench.injected_faults import inject
from handcart.backends.can.can_backend import CanBackend
from handcart.networks.runs.run import execute
from handcart.networks.task.preparing import prepare
from tests.tools.conftest import Said

TASK = """\
format: handcart-task/1
title: Drive on simulated drives
robot: cart
backend: can
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: at_home
goal: at_shelf
situations: {at_home: {base: home}, at_shelf: {base: shelf}}
actions:
  - {do: MOVE_TO, from: at_home, to: at_shelf, cost_s: 30, attempts: 1, with: {place: shelf_3}}
"""


@pytest.fixture
def run(tour: Path, tmp_path: Path) -> Callable[..., Path]:
    """Runs the task with a fault at a time; the run's folder."""
    tour.write_text(TASK, encoding="utf-8")

    def go(fault: str, at: float, name: str = "run") -> Path:
        with prepare(tour) as prepared:
            assert isinstance(prepared.backend, CanBackend)
            assert prepared.backend.bench is not None
            inject(prepared.backend.bench, fault, at)
            execute(prepared, tmp_path / name)
        return tmp_path / name

    return go


@pytest.mark.slow
def test_frames_around_a_drives_fault(handcart: Callable[..., Said], run: Callable[..., Path]) -> None:
    folder = run("fault", 3.0)
    said = handcart("explain", folder)
    assert said.status == 0
    head, *lines = said.out[said.out.index("Frames on the CAN bus") :].splitlines()
    assert head.startswith("Frames on the CAN bus around ")
    text = "\n".join(lines)
    assert (
        "the left wheel drive (node 1)   EMCY       error 2310h, continuous over-current, register 01h"
        in text
    )
    assert "FAULT" in text
    assert "RPDO1      quick stop" in text
    times = [float(line.split()[0]) for line in lines if line.strip().endswith("register 01h")]
    assert times == [pytest.approx(3.0, abs=0.06)]


@pytest.mark.slow
def test_every_frame_is_in_a_candump_log(handcart: Callable[..., Said], run: Callable[..., Path]) -> None:
    folder = run("silent", 2.0)
    with CanutilsLogReader(folder / "frames_000.log") as reader:
        frames = list(reader)
    assert len(frames) > 300
    assert {0x601, 0x581, 0x000, 0x080, 0x181, 0x77F} <= {frame.arbitration_id for frame in frames}
    assert sum(frame.arbitration_id == 0x080 for frame in frames) > 35
    assert frames[-1].timestamp > 2.0
    report = json.loads(handcart("explain", folder, "--json").out)
    assert report["frames"].endswith("_frames.log")
    out = handcart("explain", folder).out
    assert "the left wheel drive (node 1)   TPDO1      the last one: none came after" in out


@pytest.mark.slow
def test_equal_runs_have_equal_frames(run: Callable[..., Path]) -> None:
    """N11: stamps are simulated time: two runs of one seed have the same log, bit for bit."""
    first, second = (run("fault", 1.0, name) for name in ("first", "second"))
    assert (first / "frames_000.log").read_bytes() == (second / "frames_000.log").read_bytes()
    assert (first / "frames.json").read_bytes() == (second / "frames.json").read_bytes()


@pytest.mark.slow
def test_another_recorders_log_is_told_in_the_runs_names(
    handcart: Callable[..., Said], run: Callable[..., Path], tmp_path: Path
) -> None:
    folder, log = run("fault", 1.0), tmp_path / "analyser.asc"
    with can.LogReader(folder / "frames_000.log") as reader, can.Logger(log) as writer:
        for frame in reader:
            frame.channel = 1
            writer(frame)
    printed = handcart("explain", folder, "--frames", log, "--at", 1.0)
    assert "Frames on the CAN bus around 1.000 s" in printed.out
    assert "error 2310h, continuous over-current" in printed.out
    assert f"Frames on the CAN bus at the end of {log}" in handcart("explain", folder, "--frames", log).out
    wrong = handcart("explain", folder, "--frames", folder / "journal.jsonl")
    assert wrong.status == 2
    assert "journal.jsonl is not a log of CAN frames: its suffix is '.jsonl'; allowed: .asc" in wrong.err


def test_a_time_without_the_log_that_it_is_in_is_refused(handcart: Callable[..., Said]) -> None:
    said = handcart("explain", "no_run", "--at", "3.0")
    assert said.status == 2
    assert "--at without --frames; needed: the log whose time it is" in " ".join(said.err.split())
