"""What a first run needs later is compiled by other processes."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from handcart.evaluation.trials.running import run_task
from handcart.networks.run_options import RunOptions
from handcart.robotics.numerics import compiling_ahead as ahead
from handcart.robotics.numerics.compiled import AHEAD

TRACK_SEAM = Path(__file__).parents[3] / "tasks" / "track_seam" / "task.yaml"
NEAR = "handcart.backends.simulation.body.near_pairs"


def test_it_is_compiled_for_what_runs_call_it_with(tmp_path: Path) -> None:
    run_task(TRACK_SEAM, tmp_path, RunOptions())
    kernels = [each for module in AHEAD.values() for each in module]
    assert len(kernels) >= 8
    for kernel, arguments in kernels:
        assert ahead.types_of(arguments) in kernel.dispatcher.signatures, kernel


def test_another_process_leaves_machine_code_on_disk(tmp_path: Path) -> None:
    words = [sys.executable, "-m", ahead.__name__, NEAR]
    env = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run(words, env=env, check=True, timeout=120)
    kept = {path.name.split("-")[0] for path in tmp_path.rglob("*.nbi")}
    assert kept == {"near_pairs._near_boxes", "near_pairs.near_spheres"}


class Begun:
    """In place of a process: what it was told."""

    every: list["Begun"]

    def __init__(self, words: list[str], **_: Any) -> None:
        self.words, self.ended = words, 0
        self.every.append(self)

    def kill(self) -> None:
        self.ended += 1

    def wait(self) -> None:
        self.ended += 1


@pytest.mark.parametrize(("cores", "processes"), [(1, 0), (2, 1), (3, 2), (64, 3), (None, 0)])
def test_cores_that_are_free_take_what_is_needed_last(
    monkeypatch: pytest.MonkeyPatch, cores: int | None, processes: int
) -> None:
    monkeypatch.setattr(Begun, "every", [], raising=False)
    monkeypatch.setattr(subprocess, "Popen", Begun)
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    monkeypatch.setattr(ahead, "AHEAD", {"first": [], "second": [], "third": []})

    def doubled(x: float) -> float:
        return 2.0 * x

    kernel: Any = numba.njit(doubled)  # not kept on disk
    with ahead.compiling_ahead():
        assert not Begun.every  # nothing has been compiled
        assert kernel(1.0) == 2.0
        kernel(np.float32(1.0))  # once more: they are at it already
        shares = [each.words[3:] for each in Begun.every]
        assert len(shares) == processes
        if shares:
            assert sorted(name for share in shares for name in share) == ["first", "second", "third"]
            assert shares[0][0] == "third"
        assert all(each.ended == 0 for each in Begun.every)
    assert all(each.ended == 2 for each in Begun.every)
