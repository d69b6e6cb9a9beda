"""Trials on a machine that is too slow are counted apart, and no child outlives its benchmark."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from benchmarks.ros2.judged import Tally, Verdict

CHILD = """
import os, time
from benchmarks.ros2.wire_rig import LoopWatch, Process
def spin(pipe):
    watch = LoopWatch(0.01)
    time.sleep(0.2)
    watch.note()
    pipe.send(os.getpid())
    while True:
        pipe.poll(0.01)
process = Process(spin)
print(process.answer(), process.late_s, flush=True)
time.sleep(60.0)
"""


def test_a_late_loop_is_not_judged_whatever_its_result() -> None:
    verdicts = [Verdict("", 0.01), Verdict("not named", 0.05), Verdict("", 0.31), Verdict("silent", 0.2)]
    tally = Tally(verdicts)
    assert tally.words == "1/2, not judged 2 (a loop was up to 0.31 s late; 1 of them good)"
    assert tally.missed == 1
    assert list(tally.findings()) == ["not named", "not judged: silent"]


def test_a_row_without_a_judged_trial_shows_nothing() -> None:
    assert Tally([Verdict("", 0.2)]).missed == 1
    assert Tally([Verdict("", 0.0)]).words == "1/1"


@pytest.mark.slow
def test_a_child_reports_its_lateness_and_ends_with_its_parent() -> None:
    with subprocess.Popen([sys.executable, "-c", CHILD], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        number, late = parent.stdout.readline().split()
        assert float(late) == pytest.approx(0.19, abs=0.1)
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
