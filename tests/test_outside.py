"""A domain of another package, potted plants: installed, and nothing of handcart is edited for it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

OUTSIDE = Path(__file__).parent / "outside"
TASK = OUTSIDE / "potted_plants" / "garden" / "task.yaml"
MOST_LINES = 350

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the environment of a process that has the package installed."""
    site, copy = tmp_path_factory.mktemp("site"), tmp_path_factory.mktemp("source")
    for path in OUTSIDE.rglob("*"):
        if path.suffix in (".py", ".yaml", ".toml") and "build" not in path.parts:
            target = copy / path.relative_to(OUTSIDE)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(path.read_bytes())
    command = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation"]
    subprocess.run([*command, "--target", str(site), str(copy)], check=True)
    return os.environ | {"PYTHONPATH": str(site)}


@pytest.fixture
def handcart(environment: dict[str, str], tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs a command."""

    def run(*words: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "handcart", *map(str, words)]
        return subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False
        )

    return run


def test_it_takes_few_lines() -> None:
    files = sorted((OUTSIDE / "potted_plants").glob("*.py"))
    assert sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files) <= MOST_LINES


def test_its_files_are_checked(
    handcart: Callable[..., subprocess.CompletedProcess[str]], tmp_path: Path
) -> None:
    assert handcart("check", TASK).returncode == 0
    assert "needs_ml" in handcart("schema", "plants").stdout
    garden = TASK.parent
    for path in garden.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (garden / "plants.yaml").read_text(encoding="utf-8")
    (tmp_path / "plants.yaml").write_text(text.replace("needs_ml: 60", "need_ml: 60"), encoding="utf-8")
    said = handcart("check", tmp_path / "task.yaml")
    assert said.returncode == 2
    assert "plants.yaml:5:" in said.stderr
    assert "unknown key 'need_ml'; did you mean 'needs_ml'?" in said.stderr


@pytest.mark.parametrize("backend", ["kinematic", "mujoco"])
def test_plants_get_what_they_need(
    handcart: Callable[..., subprocess.CompletedProcess[str]], backend: str
) -> None:
    said = handcart("run", TASK, "--backend", backend, "--json")
    report = json.loads(said.stdout.splitlines()[-1])
    assert (said.returncode, report["outcome"], report["metrics"]["untrue"]) == (0, "Success", [])
    assert report["metrics"]["basil_ml"] == pytest.approx(80.0, abs=25.0)
    assert report["metrics"]["mint_ml"] == pytest.approx(60.0, abs=25.0)
    assert report["metrics"]["spilt_ml"] == 0.0


def test_one_plant_is_watered_alone(handcart: Callable[..., subprocess.CompletedProcess[str]]) -> None:
    said = handcart("do", "WATER", "plant=mint", "--knowledge", TASK)
    assert (said.returncode, said.stdout.split()[0]) == (0, "Success")
    said = handcart("do", "WATER", "plant=mimt", "--knowledge", TASK)
    assert (said.returncode, "did you mean 'mint'?" in said.stderr) == (2, True)


def test_a_campaign_tells_its_figures(handcart: Callable[..., subprocess.CompletedProcess[str]]) -> None:
    said = handcart("campaign", TASK, "--trials", "2", "--jobs", "1")
    assert said.returncode == 0, said.stderr
    assert "basil_ml" in said.stdout


def test_the_kit_finds_nothing_wrong(handcart: Callable[..., subprocess.CompletedProcess[str]]) -> None:
    words = ("--part", "faults", "--robot", "toyama/h1", "--primitive", "WATER", "--instants", "1")
    said = handcart("conformance", *words)
    assert said.returncode == 0, said.stdout + said.stderr
    assert "0 violations" in said.stdout


def test_a_killed_run_goes_on(
    environment: dict[str, str], handcart: Callable[..., subprocess.CompletedProcess[str]], tmp_path: Path
) -> None:
    command = [sys.executable, "-m", "handcart", "run", str(TASK)]
    quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command, env=environment, cwd=tmp_path, **quiet)
    run, end = tmp_path / "runs" / "garden-0", time.monotonic() + 60.0
    while not (run / "checkpoint").exists() and process.poll() is None:
        assert time.monotonic() < end
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    said = handcart("resume", run, "--json")
    if "is over" in said.stderr:
        pytest.skip("the run was faster than the signal")
    report = json.loads(said.stdout.splitlines()[-1])
    assert (said.returncode, report["outcome"]) == (0, "Success"), said.stderr
    assert report["metrics"]["mint_ml"] == pytest.approx(60.0, abs=25.0)
