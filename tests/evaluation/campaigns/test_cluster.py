"""Trials on a real Dask scheduler and real workers: no failure of theirs loses a trial."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest
from distributed import Client

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns import cluster as module
from handcart.evaluation.campaigns import scheduler_check
from handcart.evaluation.campaigns.campaign import run_campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.cluster import Cluster, ClusterLost, TrialThere
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.trial_log import TrialLog, line_of
from handcart.evaluation.campaigns.scheduler_check import NoCluster, NoScheduler, check_scheduler
from handcart.evaluation.campaigns.workers import TrialFault
from handcart.files.errors import InputError

ROOT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class Work:
    """A trial that takes a moment, on one worker ten times as long; it notes who has begun it."""

    notes: Path
    refuses: int = -1

    def __call__(self, seed: int) -> bytes:
        if seed == self.refuses:
            raise InputError("this can't be")
        with (self.notes / str(seed)).open("a", encoding="utf-8") as file:
            file.write(f"{os.getpid()}\n")
        time.sleep(0.1 if "SLOW" in os.environ else 0.05)
        return line_of(Trial(seed, 0, {"outcome": "Success", "reason": "", "metrics": {}}))


@dataclass
class Machines:
    """A scheduler and its file, and the processes of its three workers, the last one slow."""

    scheduler: subprocess.Popen[bytes]
    file: Path
    workers: list[subprocess.Popen[bytes]]


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[Machines]:
    file = tmp_path / "scheduler.json"
    where = ["--scheduler-file", str(file), "--no-dashboard", "--host", "127.0.0.1"]
    more = ["--nthreads", "1", "--no-nanny", "--local-directory", str(tmp_path)]
    scheduler = started(["scheduler", "--port", "0", *where])
    end = time.monotonic() + 60.0
    while not file.exists():
        assert time.monotonic() < end
        time.sleep(0.05)
    workers = [started(["worker", *where, *more], **({"SLOW": "1"} if at == 2 else {})) for at in range(3)]
    try:
        with Client(scheduler_file=str(file), set_as_default=False) as client:
            client.wait_for_workers(3, timeout=60.0)
        yield Machines(scheduler, file, workers)
    finally:
        for worker in (*workers, scheduler):
            worker.kill()
            worker.wait()


def started(words: list[str], **more: str) -> subprocess.Popen[bytes]:
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    command = [sys.executable, "-m", "dask", *words]
    known = os.environ | {"PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "ignore"} | more
    return subprocess.Popen(command, cwd=ROOT, env=known, **quiet)  # type: ignore[call-overload, no-any-return]


@pytest.mark.slow
def test_killed_frozen_and_slow_workers_count_each_trial_once(
    machines: Machines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "PATIENCE_S", 1.0)
    monkeypatch.setattr(module, "LOOKS_S", 0.2)
    count, seen = 60, Counter[int]()
    notes = tmp_path / "notes"
    notes.mkdir()
    for together in Cluster(Work(notes), str(machines.file)).trials(range(count)):
        seen.update(item.seed for item in together)
        begun = {int(part) for path in notes.iterdir() for part in path.read_text("utf-8").split()}
        if machines.workers[0].poll() is None and {worker.pid for worker in machines.workers} <= begun:
            machines.workers[0].kill()
            machines.workers[0].wait()
            machines.workers[1].send_signal(signal.SIGSTOP)
            assert len(seen) < count - 10
    assert seen == Counter(range(count))
    assert machines.workers[0].poll() is not None, "all was over before anything went wrong"


@pytest.mark.slow
def test_cluster_campaign_equals_local_one_and_reports_broken_trials(
    machines: Machines, tmp_path: Path
) -> None:
    setting = CampaignSetting(walk(tmp_path), level="network")
    kept = {}
    for name, cluster in (("here", None), ("there", str(machines.file))):
        with TrialLog(tmp_path / name) as log:
            seeds = [trial.seed for trial in run_campaign(setting, range(40), 1, log, cluster)]
            assert sorted(seeds) == list(range(40))
            kept[name] = list(log.trials())
    assert kept["here"] == kept["there"]
    with pytest.raises(TrialFault, match="this can't be") as raised:
        list(Cluster(Work(tmp_path, refuses=1), str(machines.file)).trials(range(3)))
    assert raised.value.exit_status == 2


@pytest.mark.slow
def test_where_the_scheduler_dies_the_campaign_ends_in_words(machines: Machines, tmp_path: Path) -> None:
    done = 0
    with pytest.raises(ClusterLost, match="the same command runs the remaining trials"):
        for together in Cluster(Work(tmp_path), str(machines.file)).trials(range(1000)):
            done += len(together)
            machines.scheduler.kill()
    assert 0 < done < 1000


def test_a_worker_with_other_files_runs_nothing(tmp_path: Path) -> None:
    there = TrialThere.of(CampaignSetting(walk(tmp_path), level="network"))
    there(0)
    other = TrialThere(there.setting, {**there.files, "map.png": "0" * 64})
    with pytest.raises(TrialFault, match=r"another content in map\.png") as raised:
        other(0)
    assert raised.value.exit_status == 2


@pytest.mark.parametrize(
    ("address", "wrong"),
    [("nowhere.json", "no such file; allowed: an address"), ("tcp://127.0.0.1:9", "no scheduler answers")],
)
def test_where_nobody_answers_nothing_moves(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, address: str, wrong: str
) -> None:
    monkeypatch.setattr(module, "ANSWERS_S", 0.3)
    with pytest.raises(NoCluster, match=wrong):
        list(Cluster(Work(tmp_path), address).trials(range(3)))


FOREIGN = {
    "silent": b"",
    "a web server": b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n",
    "a shell": b"SSH-2.0-OpenSSH_9.6\r\n",
    "nonsense": (1).to_bytes(8, "little") + (40).to_bytes(8, "little") + b"\x81" * 40,
}


@pytest.mark.parametrize("sent", FOREIGN.values(), ids=FOREIGN)
def test_a_silent_or_foreign_server_is_refused_in_time(sent: bytes) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        answering = threading.Thread(target=_answer_with, args=(server, sent), daemon=True)
        answering.start()
        begun = time.monotonic()
        with pytest.raises(NoScheduler, match="no scheduler answers") as raised:
            check_scheduler(f"tcp://127.0.0.1:{server.getsockname()[1]}", 0.5)
        assert time.monotonic() - begun < 5.0
        assert raised.value.exit_status == 2
        assert "\n" not in str(raised.value)
        server.shutdown(socket.SHUT_RDWR)
        answering.join(5.0)


def _answer_with(server: socket.socket, sent: bytes) -> None:
    """Send the same answer to every client, and keep the connections open."""
    with ExitStack() as stack, suppress(OSError):
        while True:
            line, _ = server.accept()
            stack.enter_context(line)
            line.sendall(sent)


@pytest.mark.parametrize(
    ("said", "wrong"),
    [
        ({"type": "Scheduler", "id": "x"}, None),
        ({"type": "Worker"}, "the answer is not that of a scheduler: 'Worker'; allowed"),
        ({"id": "x"}, "the answer is not that of a scheduler: {'id': 'x'}; allowed"),
        ("Scheduler", "the answer is not that of a scheduler: 'Scheduler'; allowed"),
    ],
)
def test_only_who_says_that_it_is_a_scheduler_is_one(
    monkeypatch: pytest.MonkeyPatch, said: object, wrong: str | None
) -> None:
    async def identity(address: str, timeout: float) -> object:
        assert (address, timeout) == ("tcp://10.0.0.1:1", 2.0)
        return said

    monkeypatch.setattr(scheduler_check, "_identity", identity)
    if wrong is None:
        check_scheduler("tcp://10.0.0.1:1", 2.0)
        return
    with pytest.raises(NoScheduler, match=re.escape(wrong)):
        check_scheduler("tcp://10.0.0.1:1", 2.0)


@pytest.mark.parametrize("content", ["", "[]", '{"address": 3}', '{"address": "carrier pigeon"}'])
def test_a_file_that_is_no_scheduler_s_is_refused(tmp_path: Path, content: str) -> None:
    file = tmp_path / "scheduler.json"
    file.write_text(content, encoding="utf-8")
    with pytest.raises(NoScheduler):
        check_scheduler(str(file), 0.5)
