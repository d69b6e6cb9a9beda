from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.path_tracking import PathTracker
from handcart.robotics.navigation.localization.localizer import Localizer, ScanLocalizer
from handcart.robotics.navigation.localization.odometry_localizer import OdometryLocalizer
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.odometry.odometry import Odometry, OdometryErrors
from handcart.robotics.navigation.routes.route import plan_route
from handcart.robotics.navigation.routes.voronoi_graph import voronoi_graph
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

from ..conftest import LIBRARY_SIZE, Boxes

TREAD, DT = 0.46, 0.05
START, GOAL = Pose2(1.0, 3.6, 0.0), Pose2(10.9, 7.9, 1.5)
UNKNOWN = [(4.6, 3.1, 0.3, 0.3, 0.3), (7.9, 7.2, 0.0, 0.25, 0.3), (9.6, 3.4, 0.8, 0.4, 0.2)]


def drive(
    localizer: Localizer, library: GridMap, boxes: Boxes, scan: Callable[..., np.ndarray], seed: int = 0
) -> tuple[Pose2, list[float]]:
    """Drive a route on estimates only; truth at the end and the estimate's errors on the way, in [m]."""
    rng = np.random.default_rng(seed)
    scale, tread = 1.0 + rng.normal(0.0, 0.002, 2), TREAD * (1.0 + rng.normal(0.0, 0.005))
    truth = Odometry(START, tread, OdometryErrors(0.0, 0.0, 0.0))
    route = plan_route(voronoi_graph(library, 0.34), START, GOAL)
    assert route is not None
    tracker, errors = PathTracker(route.points, GOAL.theta), list[float]()
    for _ in range(2000):
        if tracker.finished(localizer.pose):
            return truth.pose, errors
        speed, turn_rate = tracker.command(localizer.pose, DT)
        wheels = DT * np.array([speed - turn_rate * TREAD / 2, speed + turn_rate * TREAD / 2])
        truth.predict(*(wheels * scale * (1.0 + rng.normal(0.0, 0.01, 2))))
        localizer.predict(*wheels)
        localizer.correct(scan(boxes, truth.pose, rng))
        errors.append(truth.pose.distance(localizer.pose))
    raise AssertionError("did not arrive")


@pytest.mark.slow
def test_scans_hold_the_pose_among_unknown_boxes(
    library: GridMap, library_boxes: Boxes, library_field: LikelihoodField, scan: Callable[..., np.ndarray]
) -> None:
    """S7: wheels that err slowly are corrected by scans."""
    localizer = ScanLocalizer(library_field, START, TREAD)
    end, errors = drive(localizer, library, library_boxes + UNKNOWN, scan)
    assert np.mean(errors) < 0.02
    assert max(errors) < 0.04
    assert end.distance(GOAL) < 0.04
    assert not localizer.lost
    assert math.sqrt(localizer.covariance[0, 0]) < 0.03


@pytest.mark.slow
def test_wheels_alone_drift_and_say_so(
    library: GridMap, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    localizer = OdometryLocalizer(START, TREAD)
    end, _ = drive(localizer, library, library_boxes, scan, seed=3)
    away = end.distance(localizer.pose)
    assert away > 0.04
    assert away < 4.0 * math.sqrt(np.trace(localizer.covariance[:2, :2]))


def test_poor_scans_are_refused_and_then_the_robot_is_lost(library_field: LikelihoodField) -> None:
    rng = np.random.default_rng(0)
    localizer = ScanLocalizer(library_field, START, TREAD, patience=3)
    for _ in range(3):
        assert not localizer.lost
        assert not localizer.correct(rng.uniform(-3, 3, (300, 2)))
    assert localizer.lost
    assert localizer.pose == START


def test_a_good_scan_makes_up_for_poor_ones(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    """Only several poor ones in a row mean that the robot is lost."""
    rng = np.random.default_rng(0)
    localizer = ScanLocalizer(library_field, START, TREAD, patience=3)
    for _ in range(2):
        assert not localizer.correct(rng.uniform(-3, 3, (300, 2)))
        assert not localizer.correct(rng.uniform(-3, 3, (300, 2)))
        assert not localizer.sure
        assert localizer.correct(scan(library_boxes, START, rng))
        assert localizer.sure
    assert not localizer.lost


def test_by_wheels_alone_what_they_drove_is_no_push(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    """The pose is searched again once it has rolled; a push at rest is added."""
    rng, truth = np.random.default_rng(0), START
    localizer = OdometryLocalizer(START, TREAD, field=library_field)
    for _ in range(3):
        assert not localizer.find_again(scan(library_boxes, truth, rng))
        localizer.predict(0.1, 0.1)
        truth = truth.compose(Pose2(0.1, 0.0, 0.0))
    assert localizer.pose.distance(truth) < 1e-9
    assert not localizer.find_again(scan(library_boxes, truth, rng))
    pushed = truth.compose(Pose2(0.0, 0.06, 0.0))
    assert localizer.find_again(scan(library_boxes, pushed, rng))
    assert localizer.pose.distance(pushed) < 0.02
    localizer.predict(0.1, 0.1)
    slipped = pushed.compose(Pose2(0.06, 0.0, 0.0))
    assert not localizer.find_again(scan(library_boxes, slipped, rng))


@pytest.mark.parametrize("slip", [0.0, 0.02, 0.12, 0.25])
def test_wheels_that_slipped_are_corrected_at_rest(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray], slip: float
) -> None:
    rng, covariance = np.random.default_rng(1), np.diag([0.05, 0.05, 0.035]) ** 2
    localizer = OdometryLocalizer(START, TREAD, covariance=covariance, field=library_field)
    assert localizer.unchecked
    localizer.check_drive(scan(library_boxes, START, rng))
    assert localizer.pose.distance(START) < 0.02
    assert not localizer.unchecked
    for _ in range(20):
        localizer.predict(0.05, 0.05)
    assert localizer.unchecked
    truth = START.compose(Pose2(1.0 - slip, 0.0, 0.0))
    localizer.check_drive(scan(library_boxes, truth, rng))
    assert localizer.pose.distance(truth) < 0.03
    assert localizer.slips == (slip > 0.1)
    assert 0.003 < math.sqrt(localizer.covariance[0, 0]) < 0.025
    assert not localizer.astray


def test_a_drive_that_no_scan_explains_leads_astray(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    """Only where the map explained a scan before it."""
    rng, nowhere = np.random.default_rng(0), np.random.default_rng(0).uniform(-3.0, 3.0, (300, 2))
    blind = OdometryLocalizer(START, TREAD, field=library_field)
    blind.check_drive(nowhere)
    assert not blind.astray
    localizer = OdometryLocalizer(START, TREAD, field=library_field)
    localizer.check_drive(scan(library_boxes, START, rng))
    localizer.predict(0.1, 0.1)
    localizer.check_drive(nowhere)
    assert localizer.astray
    assert localizer.pose.distance(START) == pytest.approx(0.1, abs=0.02)
    localizer.predict(-0.1, -0.1)
    localizer.check_drive(scan(library_boxes, START, rng))
    assert not localizer.astray


def test_wheels_that_tremble_do_not_hide_a_push(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    rng, localizer = np.random.default_rng(0), OdometryLocalizer(START, TREAD, field=library_field)
    assert not localizer.find_again(scan(library_boxes, START, rng))
    for tremble in (1e-4, -1e-4, 0.015):
        localizer.predict(tremble, tremble)
    assert not localizer.find_again(scan(library_boxes, START.compose(Pose2(0.015, 0.0, 0.0)), rng))
    localizer.predict(1e-4, -1e-4)
    assert localizer.find_again(scan(library_boxes, START.compose(Pose2(0.065, 0.0, 0.0)), rng))


def test_too_few_points_correct_nothing(library_field: LikelihoodField) -> None:
    localizer = ScanLocalizer(library_field, START, TREAD)
    assert not localizer.correct(np.ones((5, 2)))
    assert localizer.last_match is None


def test_a_rough_start_is_found(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    truth = Pose2(1.0, 3.6, 0.0)
    points = scan(library_boxes, truth, np.random.default_rng(0))
    localizer = ScanLocalizer(library_field, Pose2(0, 0, 0), TREAD)
    localizer.relocalize(Pose2(1.2, 3.45, 0.15), points)
    assert localizer.pose.distance(truth) < 0.03
    assert localizer.pose.turn(truth) < 0.01


def test_a_lost_robot_finds_back_when_scans_fit_again(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    truth, rng = Pose2(3.0, 3.5, 1.0), np.random.default_rng(0)
    rough = np.diag([0.2, 0.2, 0.1]) ** 2
    localizer = ScanLocalizer(library_field, Pose2(3.15, 3.6, 1.1), TREAD, covariance=rough, patience=1)
    assert not localizer.correct(rng.uniform(-3, 3, (300, 2)))
    assert localizer.lost
    assert localizer.correct(scan(library_boxes, truth, rng))
    assert localizer.pose.distance(truth) < 0.03


@pytest.mark.parametrize("theta", [math.pi - 0.01, -math.pi + 0.01])
def test_headings_near_half_a_turn_are_no_special_case(
    theta: float, library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    truth = Pose2(3.0, 3.5, theta)
    start = Pose2(3.02, 3.5, -math.copysign(math.pi - 0.01, theta))
    localizer = ScanLocalizer(library_field, start, TREAD, covariance=np.diag([0.02, 0.02, 0.03]) ** 2)
    localizer.correct(scan(library_boxes, truth, np.random.default_rng(0)))
    assert localizer.pose.turn(truth) < 0.005


@pytest.mark.parametrize("moved", [(0.05, 0.0, 0.0), (0.0, -0.05, 0.0), (0.0, 0.0, 0.06), (0.0, 0.0, -0.06)])
def test_a_push_is_found_and_taken_over(
    moved: tuple[float, float, float],
    library_field: LikelihoodField,
    library_boxes: Boxes,
    scan: Callable[..., np.ndarray],
) -> None:
    truth, rng = Pose2(3.0, 3.5, 1.0), np.random.default_rng(0)
    localizer = ScanLocalizer(library_field, truth, TREAD)
    for _ in range(20):
        localizer.correct(scan(library_boxes, truth, rng))
    assert not any(localizer.find_again(scan(library_boxes, truth, rng)) for _ in range(50))
    pushed = truth.compose(Pose2(*moved))
    assert localizer.find_again(scan(library_boxes, pushed, rng))
    assert localizer.pose.distance(pushed) < 0.02
    assert localizer.pose.turn(pushed) < 0.01
    assert not localizer.find_again(scan(library_boxes, pushed, rng))


@pytest.mark.parametrize(("resolution", "found"), [(0.05, True), (0.25, False)])
def test_a_push_of_less_than_large_cells_tell_is_none(
    resolution: float, found: bool, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    """Several places fit alike there: a base at rest would be taken for pushed."""
    field = LikelihoodField(from_boxes(library_boxes, resolution, (0.0, 0.0), LIBRARY_SIZE))
    truth, rng = Pose2(3.0, 3.5, 1.0), np.random.default_rng(0)
    localizer = ScanLocalizer(field, truth, TREAD)
    for _ in range(20):
        localizer.correct(scan(library_boxes, truth, rng))
    near, far = (truth.compose(Pose2(ahead, 0.0, 0.0)) for ahead in (0.046, 0.15))
    assert localizer.find_again(scan(library_boxes, near, rng)) is found
    assert localizer.find_again(scan(library_boxes, far, rng))


def test_what_fits_nowhere_is_no_push(
    library_field: LikelihoodField, library_boxes: Boxes, scan: Callable[..., np.ndarray]
) -> None:
    truth, rng = Pose2(3.0, 3.5, 1.0), np.random.default_rng(0)
    localizer = ScanLocalizer(library_field, truth, TREAD)
    localizer.correct(scan(library_boxes, truth, rng))
    before = localizer.pose
    assert not localizer.find_again(rng.uniform(-3, 3, (300, 2)))
    assert localizer.pose == before


@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_along_a_wall_the_beam_that_tells_is_not_taken_for_a_push(noise: float) -> None:
    """S12: one beam tells how far along a corridor it stands, so poses by scans differ by more than 10 mm,
    also where the sensor is three times as noisy as is supposed."""
    walls = [(0.0, 1.05, 0.0, 20.0, 0.1), (0.0, -1.05, 0.0, 20.0, 0.1), (4.05, 0.5, 0.0, 0.1, 1.0)]
    field = LikelihoodField(from_boxes(walls, 0.02, (-10.2, -1.4), (20.4, 2.8)))
    along, rng = np.linspace(-3.0, 3.0, 80), np.random.default_rng(5)
    seen = np.vstack(
        [np.column_stack([along, np.full(80, side)]) for side in (-1.0, 1.0)] + [np.array([[4.0, 0.5]])]
    )
    localizer = ScanLocalizer(field, Pose2(0.0, 0.0, 0.0), TREAD, covariance=0.05**2 * np.eye(3))
    localizer.correct(seen)
    noisy = [seen + rng.normal(0.0, noise, seen.shape) for _ in range(400)]
    assert not any(localizer.find_again(points) for points in noisy)
    assert localizer.find_again(noisy[0] - (0.0, 0.03))  # across it, hundreds of beams count
    assert abs(localizer.pose.y - 0.03) < 0.01


def test_before_any_scan_wheels_alone_claim_nothing_of_one(library_field: LikelihoodField) -> None:
    localizer = OdometryLocalizer(Pose2(3.0, 1.5, 0.0), 0.5, field=library_field)
    assert (localizer.slips, localizer.astray, localizer.explained) == (0, False, 0.0)
    assert localizer.unchecked
    assert localizer.added_sigma == 0.0
    assert localizer.looks
    blind = OdometryLocalizer(Pose2(3.0, 1.5, 0.0), 0.5)
    assert not blind.unchecked
    assert not blind.looks
