"""Trials side by side: a process that is killed loses none, and none is left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.workers import TrialFault, Workers
from handcart.files.errors import InputError

ROOT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class Work:
    """A trial that takes no time; its process is killed in that of a seed, once or always."""

    notes: Path
    kills: int = -1
    always: bool = False
    refuses: int = -1

    def __call__(self, seed: int) -> Trial:
        killed = self.notes / f"killed-{seed}"
        if seed == self.refuses:
            raise InputError("this can't be")
        if seed == self.kills and (self.always or not killed.exists()):
            killed.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return Trial(seed, 0, {"outcome": "Success", "reason": "", "metrics": {}})


def ran(work: Work, count: int = 30, jobs: int = 2) -> list[Trial]:
    return [item for together in Workers(work, jobs).trials(range(count)) for item in together]


@pytest.mark.slow
def test_each_seed_is_done_once_though_a_process_was_killed(tmp_path: Path) -> None:
    done = ran(Work(tmp_path, kills=7))
    assert sorted(item.seed for item in done) == list(range(30))
    assert all(item.success for item in done)
    assert (tmp_path / "killed-7").exists()


@pytest.mark.slow
def test_a_trial_that_kills_whoever_runs_it_has_ended(tmp_path: Path) -> None:
    done = {item.seed: item for item in ran(Work(tmp_path, kills=1, always=True), 4)}
    assert sorted(done) == [0, 1, 2, 3]
    assert done[1].summary["reason"] == "its process died 5 times, at last by signal 9"
    assert [item.status for item in done.values() if item.seed != 1] == [0, 0, 0]


def test_what_cannot_be_run_is_told(tmp_path: Path) -> None:
    with pytest.raises((InputError, TrialFault), match="this can't be"):
        ran(Work(tmp_path, refuses=3))


CAMPAIGN = """
import sys, time
from handcart.evaluation.campaigns.campaign import run_campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.trial_log import TrialLog
from handcart.evaluation.campaigns import campaign
from pathlib import Path

class Slow:
    def __call__(self, seed):
        time.sleep(0.01)
        return Trial(seed, 0, {"outcome": "Success", "reason": "", "metrics": {}, "seed": seed})

def beside(setting, seed):
    return Slow()(seed)

if __name__ == "__main__":
    campaign.run_beside = beside
    with TrialLog(Path(sys.argv[1])) as log:
        for _ in run_campaign(CampaignSetting(Path("none")), range(60), 2, log):
            pass
"""


def children(process: int) -> list[int]:
    found = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8")
    return [int(part) for part in found.split()]


@pytest.mark.slow
def test_killed_at_any_instant_it_goes_on_and_loses_nothing(tmp_path: Path) -> None:
    """The parent twice, a worker once; benchmarks/campaigns/kills.py does it 200 times."""
    script, path = tmp_path / "script.py", tmp_path / "trials.jsonl"
    script.write_text(CAMPAIGN, encoding="utf-8")
    left: list[int] = []
    for after in (0.02, 0.1):
        process = subprocess.Popen([sys.executable, str(script), str(path)], cwd=ROOT)
        size = path.stat().st_size if path.exists() else 0
        end = time.monotonic() + 60.0
        while not (path.exists() and path.stat().st_size > size):
            assert time.monotonic() < end
            time.sleep(0.005)
        time.sleep(after)
        left += children(process.pid)
        process.kill()
        process.wait()
    subprocess.run([sys.executable, str(script), str(path)], cwd=ROOT, check=True, timeout=60)
    from handcart.evaluation.campaigns.data.trial_log import TrialLog

    with TrialLog(path) as log:
        assert [trial.seed for trial in log.trials()] == list(range(60))
    end = time.monotonic() + 20.0
    while any(alive(number) for number in left):
        assert time.monotonic() < end, "a worker outlives its parent"
        time.sleep(0.05)


DEAF = """
import signal, sys, time
from handcart.evaluation.campaigns import campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.data.trial_log import TrialLog
from pathlib import Path

def beside(setting, seed):
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    Path(sys.argv[1]).with_name(f"deaf-{seed}").touch()
    time.sleep(120.0)

if __name__ == "__main__":
    campaign.run_beside = beside
    with TrialLog(Path(sys.argv[1])) as log:
        list(campaign.run_campaign(CampaignSetting(Path("none")), range(9), 2, log))
"""


@pytest.mark.slow
def test_second_interrupt_ends_trials_that_ignore_the_first(tmp_path: Path) -> None:
    """K3: it kills them, and the log is whole."""
    script, path = tmp_path / "script.py", tmp_path / "trials.jsonl"
    script.write_text(DEAF, encoding="utf-8")
    process = subprocess.Popen([sys.executable, str(script), str(path)], cwd=ROOT, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 60.0
    while len(list(tmp_path.glob("deaf-*"))) < 2:
        assert time.monotonic() < end
        time.sleep(0.02)
    there = children(process.pid)
    process.send_signal(signal.SIGINT)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(1.5)
    process.send_signal(signal.SIGINT)
    process.wait(10.0)
    assert process.returncode
    end = time.monotonic() + 10.0
    while any(alive(number) for number in there):
        assert time.monotonic() < end, "a worker outlives its parent"
        time.sleep(0.05)
    assert path.read_bytes() == b""


def alive(process: int) -> bool:
    try:
        stat = Path(f"/proc/{process}/stat").read_text(encoding="utf-8")
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"
