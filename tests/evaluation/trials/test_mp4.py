"""Frames written into a video are the frames read from it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.evaluation.trials.mp4 import Mp4

av = pytest.importorskip("av")
PATCH = 64  # [px]
COLOURS = np.array(((200, 40, 30), (30, 160, 60), (40, 60, 200), (230, 230, 225), (20, 20, 25), (99, 90, 60)))


def test_colours_stay_what_they_are(tmp_path: Path) -> None:
    picture = np.repeat(np.repeat(COLOURS[None].astype(np.uint8), PATCH, axis=0), PATCH, axis=1)
    film = Mp4(tmp_path / "film.mp4", (picture.shape[1], picture.shape[0]))
    for _ in range(3):
        film.write(picture)
    film.close()
    with av.open(str(tmp_path / "film.mp4")) as container:
        seen = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(seen) == 3
    middles = seen[-1][PATCH // 2, PATCH // 2 :: PATCH].astype(int)
    assert np.abs(middles - COLOURS).max() <= 6
