from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.routes.voronoi_graph import voronoi_graph
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField, descend_scan, match_scan

from ..conftest import Boxes


def places(library: GridMap, count: int, seed: int) -> list[Pose2]:
    rng = np.random.default_rng(seed)
    cells = np.argwhere(voronoi_graph(library, 0.34).free)
    points = library.to_point(cells[rng.integers(len(cells), size=count)]) + rng.uniform(
        -0.025, 0.025, (count, 2)
    )
    return [Pose2(float(x), float(y), float(rng.uniform(-3, 3))) for x, y in points]


def unknown_boxes(rng: np.random.Generator, pose: Pose2, count: int) -> list[tuple[float, ...]]:
    """Boxes that the map doesn't show, none within 0.8 m of the robot."""
    boxes: list[tuple[float, ...]] = []
    while len(boxes) < count:
        x, y = rng.uniform((0.5, 0.5), (11.5, 8.5))
        if np.hypot(x - pose.x, y - pose.y) > 0.8:
            boxes.append((x, y, rng.uniform(0, 3), *rng.uniform(0.2, 0.6, 2)))
    return boxes


def off(a: Pose2, b: Pose2) -> np.ndarray:
    return np.array([a.x - b.x, a.y - b.y, wrap(a.theta - b.theta)])


def shifted(pose: Pose2, by: np.ndarray) -> Pose2:
    return Pose2(pose.x + by[0], pose.y + by[1], wrap(pose.theta + by[2]))


@pytest.mark.parametrize("boxes", [0, 12])
def test_poses_on_a_5_cm_grid(
    boxes: int,
    library: GridMap,
    library_boxes: Boxes,
    library_field: LikelihoodField,
    scan: Callable[..., np.ndarray],
) -> None:
    rng = np.random.default_rng(1)
    spread = np.array([0.05, 0.05, 0.03])
    errors, squares = [], []
    for pose in places(library, 100, 2):
        points = scan(library_boxes + unknown_boxes(rng, pose, boxes), pose, rng)
        match = match_scan(
            library_field, points, shifted(pose, rng.normal(0, 1, 3) * spread), np.diag(spread**2)
        )
        error = off(match.pose, pose)
        errors.append(error)
        squares.append(error @ np.linalg.solve(match.covariance, error))
        assert match.inliers > 0.5
    away = np.hypot(*np.array(errors)[:, :2].T)
    assert away.mean() < 0.015
    assert np.degrees(np.abs(np.array(errors)[:, 2])).mean() < 0.2
    assert 0.7 < np.mean(squares) < 4.0


def test_from_far_off_by_annealing(
    library: GridMap, library_boxes: Boxes, library_field: LikelihoodField, scan: Callable[..., np.ndarray]
) -> None:
    rng = np.random.default_rng(3)
    spread = np.array([0.2, 0.2, 0.12])
    away = []
    for pose in places(library, 60, 4):
        start = shifted(pose, rng.uniform(-1, 1, 3) * (0.21, 0.21, 0.17))
        match = match_scan(
            library_field, scan(library_boxes, pose, rng), start, np.diag(spread**2), anneal=True
        )
        away.append(np.hypot(*off(match.pose, pose)[:2]))
    assert max(away) < 0.04


def test_a_corridor_says_nothing_about_the_way_along_it(scan: Callable[..., np.ndarray]) -> None:
    walls = [(25.0, 0.1, 0.0, 50.0, 0.2), (25.0, 2.9, 0.0, 50.0, 0.2)]
    field = LikelihoodField(from_boxes(walls, 0.05, (0.0, 0.0), (50.0, 3.0)))
    pose, prior = Pose2(25.0, 1.5, 0.0), np.diag([0.2, 0.2, 0.1]) ** 2
    match = match_scan(field, scan(walls, pose, np.random.default_rng(0)), Pose2(25.15, 1.6, 0.02), prior)
    assert match.covariance[0, 0] > 0.15**2
    assert match.covariance[1, 1] < 0.03**2
    assert abs(match.pose.y - 1.5) < 0.03
    assert abs(match.pose.x - 25.15) < 0.05


def test_a_thin_walls_back_is_not_taken_for_its_front(scan: Callable[..., np.ndarray]) -> None:
    """Points 80 mm deep in a wall of 130 mm are nearer to its far side."""
    walls = [(3.0, y, 0.0, 6.0, 0.13) for y in (0.513, 4.487)] + [
        (x, 2.5, 0.0, 0.13, 4.0) for x in (0.513, 5.487)
    ]
    field = LikelihoodField(from_boxes(walls, 0.05, (0.0, 0.0), (6.0, 5.0)))
    truth, prior = Pose2(2.6, 2.2, 0.4), np.diag([0.1, 0.1, 0.03]) ** 2
    for x, y in ((0.08, 0.0), (-0.08, 0.0), (0.06, 0.08), (-0.05, -0.09)):
        points = scan(walls, truth, np.random.default_rng(0))
        match = match_scan(field, points, Pose2(2.6 + x, 2.2 + y, 0.42), prior)
        assert match.pose.distance(truth) < 0.03


@pytest.mark.slow
def test_no_points_leave_the_prior(library_field: LikelihoodField) -> None:
    prior = np.diag([0.04, 0.09, 0.01])
    match = match_scan(library_field, np.empty((0, 2)), Pose2(5, 3, 1), prior)
    assert match.pose == pytest.approx(Pose2(5, 3, 1))
    assert match.inliers == 0.0
    assert np.allclose(match.covariance, prior, rtol=0.05)


def test_a_foreign_place_is_not_taken_for_a_match(library_field: LikelihoodField) -> None:
    rng = np.random.default_rng(0)
    match = match_scan(library_field, rng.uniform(-3, 3, (300, 2)), Pose2(6, 3, 0), np.eye(3) * 0.01)
    assert match.inliers < 0.4


def test_residuals_are_distances_to_surfaces() -> None:
    field = LikelihoodField(from_boxes([(1.0, 1.0, 0.0, 0.5, 0.5)], 0.05, (0.0, 0.0), (2.0, 2.0)))
    read = field.read(np.array([[1.725, 1.0], [1.0, 1.0], [5.0, 5.0]]))
    assert read[0] == pytest.approx(0.5, abs=0.03)
    assert read[1] == pytest.approx(0.225, abs=0.03)
    assert read[2] == np.inf


def test_a_map_without_walls_explains_nothing() -> None:
    field = LikelihoodField(from_boxes([], 0.05, (0.0, 0.0), (2.0, 2.0)))
    match = match_scan(field, np.ones((50, 2)) * 0.1, Pose2(1, 1, 0), np.eye(3) * 0.01)
    assert match.pose == pytest.approx(Pose2(1, 1, 0))
    assert match.inliers == 0.0


def test_a_sure_prior_holds_a_scan_that_says_otherwise(
    library_boxes: Boxes, library_field: LikelihoodField, scan: Callable[..., np.ndarray]
) -> None:
    """The prior pulls in every step, not only at the first."""
    pose = Pose2(6.0, 3.5, 0.3)
    points = scan(library_boxes, pose, np.random.default_rng(0))
    prior = shifted(pose, np.array([0.02, 0.0, 0.0]))
    match = match_scan(library_field, points, prior, np.diag([3e-4, 3e-4, 3e-4]) ** 2)
    assert match.pose.distance(prior) < 0.004


def test_what_lies_ten_centimetres_off_is_not_explained() -> None:
    field = LikelihoodField(from_boxes([(2.0, 3.05, 0.0, 4.0, 0.1)], 0.05, (0.0, 0.0), (4.0, 4.0)))
    on_wall = np.column_stack([np.linspace(-1.5, 1.5, 60), np.full(60, 1.525)])
    before_it = on_wall - (0.0, 0.1)
    match = match_scan(field, np.vstack([on_wall, before_it]), Pose2(2.0, 1.5, 0.0), np.eye(3) * 1e-10)
    assert match.inliers == pytest.approx(0.5)


BORDER_OFFSETS = (-0.5, -0.25, -0.02, 0.0, 0.02, 0.25, 0.5)  # of a cell of 5 cm, from a border


def two_walls(offset: float, thickness: float) -> Boxes:
    """A wall at x = 8 m and one at y = 3 m, their near sides `offset` cells behind a border of cells."""
    off = 0.05 * offset + thickness / 2
    return [(8.0 + off, 0.0, 0.0, thickness, 20.0), (0.0, 3.0 + off, 0.0, 40.0, thickness)]


@pytest.mark.parametrize("thickness", [0.01, 0.05, 0.1, 0.15])
def test_walls_on_cell_borders_from_one_side_hold_the_claim(
    thickness: float, scan: Callable[..., np.ndarray]
) -> None:
    """The surface of a wall is in its nearest cell: the pose is off by half of a cell at most."""
    rng, spread = np.random.default_rng(7), np.array([0.05, 0.05, 0.035])
    for offset in BORDER_OFFSETS:
        boxes = two_walls(offset, thickness)
        field = LikelihoodField(from_boxes(boxes, 0.05, (-13.0, -4.0), (23.0, 9.0)))
        for away, start in ((2.0, 0.08), (5.0, -0.08), (8.0, 0.08)):
            pose = Pose2(8.0 - away, rng.uniform(-1.0, 1.0), rng.uniform(-3, 3))
            near = shifted(pose, np.array([start, start, 0.02]))
            match = match_scan(field, scan(boxes, pose, rng), near, np.diag(spread**2))
            error = np.abs(off(match.pose, pose)[:2])
            assert error.max() < 0.025 + 0.006
            assert (error < 3.0 * np.sqrt(np.diag(match.covariance)[:2])).all()
            assert match.inliers > 0.75  # the others end beyond the map


def test_points_deep_in_a_drawn_wall_are_not_drawn_to_its_back(scan: Callable[..., np.ndarray]) -> None:
    """A map that was drawn from echoes has no sides: only the beam's direction distinguishes the back."""
    for thickness, start in ((0.2, 0.12), (0.2, 0.17), (0.3, 0.2)):
        boxes = two_walls(0.3, thickness)
        field = LikelihoodField(from_boxes(boxes, 0.05, (-4.0, -4.0), (14.0, 9.0)), is_drawn=True)
        pose = Pose2(4.0, 0.5, 0.4)
        wrong = shifted(pose, np.array([start, start, 0.0]))
        points = scan(boxes, pose, np.random.default_rng(8))
        assert match_scan(field, points, wrong, np.diag([0.1, 0.1, 0.03]) ** 2).pose.distance(pose) < 0.03


def test_start_behind_a_walls_near_side_finds_the_near_side(scan: Callable[..., np.ndarray]) -> None:
    """The start is wrong by more than a wall's thickness."""
    rng = np.random.default_rng(8)
    for thickness in (0.1, 0.15, 0.2):
        boxes = two_walls(0.3, thickness)
        field = LikelihoodField(from_boxes(boxes, 0.05, (-4.0, -4.0), (14.0, 9.0)))
        pose = Pose2(4.0, 0.5, 0.4)
        wrong = shifted(pose, np.array([0.17, 0.15, 0.0]))
        match = match_scan(field, scan(boxes, pose, rng), wrong, np.diag([0.1, 0.1, 0.03]) ** 2)
        assert match.pose.distance(pose) < 0.03


def test_a_prior_of_whole_numbers_compiles_nothing_anew(library_field: LikelihoodField) -> None:
    """A kernel that is compiled for integers, too, is compiled in the control loop."""
    points = np.random.default_rng(1).uniform(-3, 3, (50, 2))
    match_scan(library_field, points, Pose2(6, 3, 0), np.eye(3) * 0.01)
    assert all("int64" not in str(types) for types in descend_scan.dispatcher.signatures)  # type: ignore[attr-defined]
