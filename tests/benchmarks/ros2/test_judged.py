"""Trials on a machine that is too slow are counted apart, and no child outlives its benchmark."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.ros2.judged import Lateness, LoopWatch, QueueClock, Tally, Verdict
from benchmarks.ros2.wire_rig import on_the_air

CHILD = """
import os, time
from benchmarks.ros2.judged import LoopWatch
from benchmarks.ros2.wire_rig import Process
def spin(pipe):
    watch = LoopWatch(0.01)
    time.sleep(0.2)
    watch.note()
    pipe.send(os.getpid())
    while True:
        pipe.poll(0.01)
process = Process(spin)
print(process.answer(), process.late.own_s, process.late.machine_s, flush=True)
time.sleep(60.0)
"""
SHARED_CORE = """
import os, time
from benchmarks.ros2.judged import LoopWatch
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
for _ in range(3):
    if os.fork() == 0:
        end = time.monotonic() + 0.8
        while time.monotonic() < end:
            pass
        os._exit(0)
LoopWatch.shared = [0.0, 0.0, 1.0]
watch, end = LoopWatch(0.01), time.thread_time() + 0.04
while time.thread_time() < end:
    pass
watch.note()
print(*map(float, LoopWatch.shared))
"""
needs_queue = pytest.mark.skipif(math.isnan(QueueClock().read_s()), reason="counts no waits for a core")


def test_only_the_share_of_the_machine_excuses_a_trial() -> None:
    late = [(0.0, 0.01), (0.05, 0.05), (0.31, 0.04), (0.2, 0.0), (0.31, 0.3), (0.0, 2.5)]
    wrong = ["", "not named", "", "silent", "", "not named"]
    tally = Tally([Verdict(words, Lateness(*item)) for words, item in zip(wrong, late, strict=True)])
    assert tally.words == "1/4, not judged 2 (a loop had no core for up to 0.31 s; 1 of them good)"
    assert tally.missed == 3
    assert list(tally.findings()) == [
        "not named",
        "a loop was 0.30 s late by itself",
        "not named; a loop was 2.50 s late by itself",
        "not judged: silent",
    ]


def test_a_row_without_a_judged_trial_shows_nothing() -> None:
    assert Tally([Verdict("", Lateness(0.2))]).missed == 1
    assert Tally([Verdict("", Lateness())]).words == "1/1"


def test_without_counted_waits_every_trial_is_judged() -> None:
    tally = Tally([Verdict("", Lateness(0.0, 0.4, False)), Verdict("silent", Lateness(0.0, 0.1, False))])
    said = "(loops up to 0.40 s late, judged all: no /proc/thread-self/schedstat on this system)"
    assert (tally.words, tally.missed) == (f"1/2 {said}", 1)


@pytest.mark.parametrize("content", [None, "0 0 0\n"])
def test_a_system_without_the_counter_gives_no_split(
    content: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if content is not None:
        (tmp_path / "schedstat").write_text(content, encoding="utf-8")
    shared = [0.0, 0.0, 1.0]
    monkeypatch.setattr(LoopWatch, "shared", shared)
    watch = LoopWatch(0.001, queue=QueueClock(tmp_path / "schedstat"))
    time.sleep(0.002)
    watch.note()
    assert shared[0] == 0.0
    assert shared[1] > 0.0
    assert not shared[2]


def test_a_period_is_split_by_the_wait_within_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "schedstat"
    file.write_text("9 5000000000 1\n", encoding="utf-8")
    shared = [0.0, 0.0, 1.0]
    monkeypatch.setattr(LoopWatch, "shared", shared)
    watch = LoopWatch(0.001, queue=QueueClock(file))
    for waited_ns, machine, own in ((6_000_000_000, 0.02, 0.0), (6_000_000_000, 0.02, 0.02)):
        file.write_text(f"9 {waited_ns} 1\n", encoding="utf-8")
        time.sleep(0.021)
        watch.note()
        assert shared[0] >= machine
        assert shared[1] >= own
    assert shared[0] < 1.0  # no more than the period was late
    figures = watch.figures()
    assert figures["machine_p99_ms"] >= 20.0
    assert figures["own_p99_ms"] >= 20.0


def test_first_periods_do_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    shared = [0.0, 0.0, 1.0]
    monkeypatch.setattr(LoopWatch, "shared", shared)
    watch = LoopWatch(0.001, skipped=1)
    time.sleep(0.03)
    watch.note()
    assert shared[:2] == [0.0, 0.0]
    time.sleep(0.03)
    watch.note()
    assert sum(shared[:2]) >= 0.02


@pytest.mark.slow
@needs_queue
def test_a_loop_without_a_core_is_late_by_the_machine() -> None:
    said = subprocess.run([sys.executable, "-c", SHARED_CORE], capture_output=True, text=True, check=True)
    machine, own, is_split = map(float, said.stdout.split())
    assert is_split
    assert machine > 0.04  # three others want the same core
    assert own < 0.04


@pytest.mark.slow
@needs_queue
def test_a_child_reports_its_lateness_and_ends_with_its_parent() -> None:
    with subprocess.Popen([sys.executable, "-c", CHILD], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        number, own, machine = parent.stdout.readline().split()
        assert float(own) == pytest.approx(0.19, abs=0.02)  # it slept: nothing kept it from a core
        assert float(machine) < 0.1
        parent.send_signal(signal.SIGKILL)
    end = time.monotonic() + 5.0
    while time.monotonic() < end:
        try:
            os.kill(int(number), 0)
        except ProcessLookupError:
            return
        time.sleep(0.02)
    os.kill(int(number), signal.SIGKILL)
    pytest.fail("the child outlives its parent")


def test_two_benchmarks_side_by_side_have_two_ros_domains(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "0")
    with on_the_air(3):
        first = os.environ["ROS_DOMAIN_ID"]
        with on_the_air(3):
            assert os.environ["ROS_DOMAIN_ID"] != first
    with on_the_air(3):
        assert os.environ["ROS_DOMAIN_ID"] == first
