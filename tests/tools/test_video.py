"""Runs that are recorded or shown."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
import pytest

from handcart.backends.mujoco.rendering import gl_context
from handcart.evaluation.trials.video import HEIGHT_PX
from handcart.robotics.numerics.arrays import FloatArray
from tests.tools.conftest import Said

pytest.importorskip("av")
NO_BULLET = pytest.mark.skipif(find_spec("pybullet") is None, reason="PyBullet has no wheel for this Python")
BACKENDS = {"kinematic": 960, "mujoco": 1280, "pybullet": 1280}
"""Width of each backend's videos, in [px]."""
FRAMES = 25


def frames_of(film: Path) -> list[FloatArray]:
    reader, frames = cv2.VideoCapture(str(film)), []
    while (read := reader.read())[0]:
        frames.append(read[1].astype(float))
    assert not frames or reader.get(cv2.CAP_PROP_FPS) == FRAMES
    return frames


def nearer(tour: Path) -> Path:
    """Return the tour with a shorter route."""
    places = tour.with_name("places.yaml")
    places.write_text(places.read_text() + "  near: {x_m: 1.2, y_m: 2.0, heading_deg: 90.0}\n")
    tour.write_text(tour.read_text().replace("shelf_3", "near").replace("base: shelf", "base: near"))
    return tour


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", pytest.param("pybullet", marks=NO_BULLET)])
def test_a_run_is_recorded(handcart: Callable[..., Said], tour: Path, tmp_path: Path, backend: str) -> None:
    film = tmp_path / "tour.mp4"
    said = handcart(
        "run", nearer(tour), "--backend", backend, "--video", film, "--runs", tmp_path / "runs", "--json"
    )
    assert said.status == 0
    simulated = json.loads(said.out.splitlines()[-1])["sim_time_s"]
    frames = frames_of(film)
    assert len(frames) == pytest.approx(FRAMES * simulated, abs=4)
    assert np.abs(frames[2] - frames[-1]).mean() > 1.0
    assert frames[0].shape == (HEIGHT_PX, BACKENDS[backend], 3)


@pytest.mark.slow
def test_a_killed_run_leaves_what_it_has_shown(tour: Path, tmp_path: Path) -> None:
    film = tmp_path / "tour.mp4"
    command = (sys.executable, "-m", "handcart.tools.main", "run", tour, "--video", film, "--runs", tmp_path)
    process = subprocess.Popen(list(map(str, command)), stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 120.0
    while process.poll() is None and time.monotonic() < deadline:
        if film.exists() and film.stat().st_size > 20_000:
            break
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert len(frames_of(film)) >= FRAMES


@pytest.mark.slow
def test_without_opengl_the_camera_alone_is_shown(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(gl_context, "find_library", lambda _: None)
    film, runs = tmp_path / "tour.mp4", tmp_path / "runs"
    tour.write_text(
        tour.read_text().replace("place: shelf_3", "place: home").replace("base: shelf", "base: home")
    )
    said = handcart("run", tour, "--backend", "mujoco", "--video", film, "--runs", runs)
    assert said.status == 0
    assert "what the hand's camera sees alone" in said.err
    assert "apt install libegl1" in said.err
    assert frames_of(film)[0].shape == (HEIGHT_PX, 960, 3)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--video", "tour.avi"], "allowed: a file whose name ends in .mp4"),
        (["--video", "no/such/folder/tour.mp4"], "can't be written"),
        (["--gui"], "the backend 'kinematic' has no window"),
    ],
)
def test_what_cannot_be_shown_is_told_before_anything_moves(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, options: list[str], words: str
) -> None:
    said = handcart("run", tour, *options, "--runs", tmp_path / "runs")
    assert said.status == 2
    assert words in said.err
    assert not (tmp_path / "runs").exists() or not any((tmp_path / "runs").iterdir())


@pytest.mark.parametrize("backend", ["mujoco", pytest.param("pybullet", marks=NO_BULLET)])
def test_a_window_needs_a_display(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, backend: str
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    said = handcart("run", tour, "--backend", backend, "--gui", "--runs", tmp_path / "runs")
    assert said.status == 2
    assert "needs a display" in said.err


def test_a_display_without_opengl_is_told(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DISPLAY", ":nowhere")
    said = handcart("run", tour, "--backend", "mujoco", "--gui", "--runs", tmp_path / "runs")
    assert said.status == 2
    assert "finds no OpenGL on this display" in said.err
