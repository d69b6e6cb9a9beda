from __future__ import annotations

import numpy as np
import pytest

from handcart.evaluation.viewing.playback.seven import between, on_floor, seven, sevens, transforms
from handcart.robotics.geometry.transform import transform

A = transform((1.0, 2.0, 3.0), (0.1, -0.4, 3.0))
B = transform((1.5, 2.0, 2.0), (0.3, 0.2, -3.0))


def test_there_and_back() -> None:
    both = np.array([A, B])
    assert transforms(sevens(both)) == pytest.approx(both)
    assert sevens(np.empty((0, 4, 4))).shape == (0, 7)
    assert transforms(np.empty((0, 7))).shape == (0, 4, 4)


def test_on_the_floor_z_is_up() -> None:
    assert transforms(on_floor(np.array([[1.0, 2.0, 0.5]])))[0] == pytest.approx(
        transform((1.0, 2.0, 0.0), (0.0, 0.0, 0.5))
    )


def test_halfway_is_as_far_from_both_ends_the_short_way_round() -> None:
    a, b = np.array(seven(A)), np.array(seven(B))
    middle = between(a, b, 0.5)
    assert middle[:3] == pytest.approx([1.25, 2.0, 2.5])
    assert abs(middle[3:] @ a[3:]) == pytest.approx(abs(middle[3:] @ b[3:]))
    assert abs(middle[3:] @ a[3:]) > abs(a[3:] @ b[3:])
    assert abs(between(a, -np.array(b), 0.5)[3:] @ middle[3:]) == pytest.approx(1.0)  # the same attitude
    assert between(a, a, 0.3) == pytest.approx(a)
