from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes, from_ros, unknown_read_as_free


def empty(height: int, width: int, resolution: float = 0.05, x: float = 0.0, y: float = 0.0) -> GridMap:
    return GridMap(np.zeros((height, width), bool), np.zeros((height, width), bool), resolution, x, y)


@given(st.integers(0, 40), st.integers(0, 60), st.floats(0.01, 0.5), st.floats(-20, 20), st.floats(-20, 20))
def test_a_cells_centre_lies_in_it(row: int, column: int, resolution: float, x: float, y: float) -> None:
    grid = empty(41, 61, resolution, x, y)
    cells = np.array([[row, column]])
    assert np.array_equal(grid.to_cell(grid.to_point(cells)), cells)
    assert grid.inside(grid.to_point(cells)).all()


def test_inside_ends_at_the_border() -> None:
    grid = empty(10, 20, 0.1, -1.0, 2.0)
    points = np.array([[-0.99, 2.01], [0.99, 2.99], [1.01, 2.5], [0.0, 1.99], [-1.01, 2.5], [0.0, 3.01]])
    assert grid.inside(points).tolist() == [True, True, False, False, False, False]


def test_row_zero_of_a_ros_picture_is_its_last() -> None:
    image = np.array([[0, 254, 205], [254, 254, 254]], dtype=np.uint8)
    grid = from_ros(image, 0.05, (-1.0, -2.0), 0.65, 0.196)
    assert grid.occupied.tolist() == [[False, False, False], [True, False, False]]
    assert grid.unknown.tolist() == [[False, False, False], [False, False, True]]
    assert np.allclose(grid.to_point(np.array([[1, 0]])), [[-0.975, -1.925]])


def test_negated_pictures_are_read_the_other_way_round() -> None:
    image = np.array([[255, 0, 128]], dtype=np.uint8)
    grid = from_ros(image, 0.05, (0.0, 0.0), 0.65, 0.196, negate=True)
    assert grid.occupied.tolist() == [[True, False, False]]
    assert grid.unknown.tolist() == [[False, False, True]]


def test_thresholds_that_turn_unknown_into_free_are_counted() -> None:
    image = np.array([[205, 205, 254, 0]], dtype=np.uint8)
    assert unknown_read_as_free(image, 0.196) == 0
    assert unknown_read_as_free(image, 0.25) == 2


def test_real_maps_by_the_trinary_rule(turtlebot3: GridMap, depot: GridMap) -> None:
    counts = [
        (int(m.occupied.sum()), int((~m.blocked).sum()), int(m.unknown.sum())) for m in (turtlebot3, depot)
    ]
    assert counts == [(795, 7939, 138722), (5947, 179481, 0)]


def test_sensed_points_become_obstacles_if_on_the_map() -> None:
    grid = empty(40, 40)._replace(unknown=np.eye(40, dtype=bool))
    seen = grid.with_points(np.array([[1.0, 1.0], [50.0, 0.0]]), 0.1)
    rows, columns = np.nonzero(seen.occupied)
    centres = grid.to_point(np.column_stack([rows, columns]))
    own = grid.to_point(grid.to_cell(np.array([[1.0, 1.0]])))[0]
    assert np.hypot(*(centres - own).T).max() <= 0.1 + 1e-6
    assert seen.occupied.sum() == 13
    assert not (seen.occupied & seen.unknown).any()
    assert not grid.occupied.any()


def test_no_points_change_nothing() -> None:
    grid = empty(5, 5)
    assert grid.with_points(np.empty((0, 2)), 0.1) is grid


@settings(deadline=None)
@given(
    st.floats(0.3, 1.7),
    st.floats(0.3, 1.7),
    st.floats(-math.pi, math.pi),
    st.floats(0.02, 1.0),
    st.floats(0.02, 1.0),
)
def test_a_box_occupies_every_cell_it_overlaps_and_none_far_off(
    x: float, y: float, yaw: float, length: float, width: float
) -> None:
    grid = from_boxes([(x, y, yaw, length, width)], 0.05, (0.0, 0.0), (2.0, 2.0))
    u, v = np.meshgrid(np.linspace(-0.499, 0.499, 40) * length, np.linspace(-0.499, 0.499, 40) * width)
    inner = Pose2(x, y, yaw).apply(np.column_stack([u.ravel(), v.ravel()]))
    cells = grid.to_cell(inner[grid.inside(inner)])
    assert grid.occupied[cells[:, 0], cells[:, 1]].all()
    centres = Pose2(x, y, yaw).inverse().apply(grid.to_point(np.argwhere(grid.occupied)))
    beyond = np.maximum(np.abs(centres) - np.array([length, width]) / 2, 0.0)
    assert np.hypot(*beyond.T).max() <= 0.05 * math.sqrt(0.5) + 1e-9


def test_sizes_are_rounded_up_to_whole_cells() -> None:
    assert from_boxes([], 0.05, (0.0, 0.0), (1.0, 0.51)).occupied.shape == (11, 20)


def test_a_box_outside_the_map_leaves_it_free() -> None:
    assert not from_boxes([(9.0, 9.0, 0.3, 1.0, 1.0)], 0.05, (0.0, 0.0), (2.0, 2.0)).occupied.any()


@pytest.mark.parametrize("x", [0.0, 2.0])
def test_a_box_across_the_border_is_clipped(x: float) -> None:
    grid = from_boxes([(x, 1.0, 0.0, 0.5, 0.5)], 0.05, (0.0, 0.0), (2.0, 2.0))
    assert grid.occupied.sum() == 50
