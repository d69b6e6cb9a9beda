"""Runs that are recorded or shown."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.tools.conftest import Said

BACKENDS = [
    "kinematic",
    pytest.param(
        "pybullet",
        marks=pytest.mark.skipif(
            find_spec("pybullet") is None, reason="PyBullet has no wheel for this Python"
        ),
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_run_is_recorded(handcart: Callable[..., Said], tour: Path, tmp_path: Path, backend: str) -> None:
    film, places = tmp_path / "tour.mp4", tour.with_name("places.yaml")
    places.write_text(places.read_text() + "  near: {x_m: 1.2, y_m: 2.0, heading_deg: 90.0}\n")
    tour.write_text(tour.read_text().replace("shelf_3", "near").replace("base: shelf", "base: near"))
    said = handcart("run", tour, "--backend", backend, "--video", film, "--runs", tmp_path / "runs", "--json")
    assert said.status == 0
    simulated = json.loads(said.out.splitlines()[-1])["sim_time_s"]
    reader = cv2.VideoCapture(str(film))
    frames = []
    while (read := reader.read())[0]:
        frames.append(read[1])
    assert len(frames) == pytest.approx(10 * simulated, abs=3)
    first, last = (frames[i].astype(float) for i in (2, -1))
    assert np.abs(first - last).mean() > 1.0
    assert first.shape == ((512, 640, 3) if backend == "kinematic" else (512, 1280, 3))


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


def test_a_window_needs_a_display(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    monkeypatch.delenv("DISPLAY", raising=False)
    said = handcart("run", tour, "--backend", "pybullet", "--gui", "--runs", tmp_path / "runs")
    assert said.status == 2
    assert "no display" in said.err
