from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.simulation.world.canvas import Canvas

K = np.array([[800.0, 0.0, 100.0], [0.0, 800.0, 80.0], [0.0, 0.0, 1.0]])
SQUARE = np.array([[-0.02, -0.02, 0.4], [0.02, -0.02, 0.4], [0.02, 0.02, 0.4], [-0.02, 0.02, 0.4]])


def canvas() -> Canvas:
    """A camera at the world's origin that looks along z."""
    return Canvas(K, (201, 161), np.eye(4), background=0)


def test_a_printed_face_stands_to_a_fraction_of_a_pixel() -> None:
    picture = np.full((80, 80), 200, dtype=np.uint8)
    face = np.eye(4)
    for shift in (0.0, 0.25, 0.5):
        face[:3, 3] = (-0.02 + shift / 2000.0, -0.02, 0.4)
        painted = canvas()
        painted.texture([(picture, 0.0005)], face)
        row = painted.picture[80].astype(float) / 200.0
        # 40 mm at 0.4 m are 80 px; their middle is at K's plus the shift.
        assert row.sum() == pytest.approx(80.0, abs=0.05)
        assert (row * np.arange(201)).sum() / row.sum() == pytest.approx(100.0 + shift, abs=0.02)


def test_face_behind_the_camera_is_hidden_and_one_across_is_clipped() -> None:
    painted = canvas()
    painted.polygon(SQUARE * [1, 1, -1], 255)
    assert painted.picture.max() == 0
    floor = np.array([[-1, 0.1, -1], [1, 0.1, -1], [1, 0.1, 5], [-1, 0.1, 5.0]])
    painted.polygon(floor, 255)
    # It ends at the horizon: 0.1 m below the eye, 5 m away, is 16 px below the middle.
    assert painted.picture[:94].max() == 0
    assert painted.picture[99:].min() == 255


def test_a_printed_face_across_the_camera_is_shown_up_to_it() -> None:
    picture = np.full((100, 100), 255, dtype=np.uint8)
    picture[:, :50] = 100
    floor = np.array([[1.0, 0, 0, -1.0], [0, 0, 1.0, 0.08], [0, 1.0, 0, -1.0], [0, 0, 0, 1.0]])
    painted = canvas()
    painted.texture([(picture, 0.02)], floor)
    # The face ends 1 m before the eye and 0.08 m below it: 64 px below the middle.
    assert painted.picture[:143].max() == 0
    assert painted.picture[158, 20] == 100
    assert painted.picture[158, 180] == 255
