"""Claims of a filter of wheels and scans where scans give no information along one direction."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import ScanLocalizer
from handcart.robotics.navigation.maps.grid_map import from_boxes
from handcart.robotics.navigation.odometry.odometry import Odometry, OdometryErrors
from handcart.robotics.navigation.scans.scan_matching import LikelihoodField

from ..conftest import Boxes

Scan = Callable[..., np.ndarray]
TREAD, STEP, LENGTH = 0.5, 0.03, 40.0
EXACT = OdometryErrors(0.0, 0.0, 0.0)
REACH = 5.0
NOISE_M = 0.01


def corridor(angle: float) -> Boxes:
    """Two walls of 40 m, 3 m apart, closed at one end, turned about the closed end by `angle`."""
    turned = Pose2(3.0, 20.0, angle)
    walls = [(20.0, 1.5, LENGTH, 0.2), (20.0, -1.5, LENGTH, 0.2), (0.0, 0.0, 0.2, 3.2)]
    made = [(turned.compose(Pose2(x, y, 0.0)), long, wide) for x, y, long, wide in walls]
    return [(pose.x, pose.y, angle, long, wide) for pose, long, wide in made]


def near(points: np.ndarray) -> np.ndarray:
    """Return a scan as a lidar of 5 m reach measures it."""
    return np.asarray(points[np.hypot(*points.T) < REACH])


def drive(
    scan: Scan,
    angle: float,
    ways: tuple[float, ...],
    off: float,
    seed: int,
    claimed: OdometryErrors = OdometryErrors(radius=0.02, slip=0.01),
    slip: float = 0.01,
) -> tuple[ScanLocalizer, Pose2]:
    """Drive there and back along a corridor with wheels whose radius is `off` by a share; estimate, truth."""
    boxes, rng = corridor(angle), np.random.default_rng(seed)
    start = Pose2(3.0, 20.0, angle).compose(Pose2(2.0, 0.0, 0.0))
    field = LikelihoodField(from_boxes(boxes, 0.05, (0.0, 0.0), (46.0, 46.0)))
    localizer = ScanLocalizer(field, start, TREAD, claimed)
    localizer.correct(near(scan(boxes, start, rng)))
    localizer.odometry.set_origin()
    truth = Odometry(start, TREAD, EXACT)
    for way in ways:
        for _ in range(round(abs(way) / STEP)):
            rolled = math.copysign(STEP, way)
            truth.predict(*(rolled * (1.0 + off) * (1.0 + rng.normal(0.0, slip, 2))))
            localizer.predict(rolled, rolled)
            localizer.correct(near(scan(boxes, truth.pose, rng)))
    return localizer, truth.pose


def by_direction(localizer: ScanLocalizer, truth: Pose2, angle: float) -> tuple[float, float, float, float]:
    """Errors along and across the corridor, and what is claimed of them, in [m]."""
    turned = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    off = turned @ (localizer.pose.x - truth.x, localizer.pose.y - truth.y)
    spread = np.sqrt(np.diag(turned @ localizer.covariance[:2, :2] @ turned.T))
    return abs(off[0]), abs(off[1]), float(spread[0]), float(spread[1])


@pytest.mark.slow
@pytest.mark.parametrize(("angle", "off"), [(0.0, 0.03), (0.02, 0.03), (0.3, -0.03), (math.pi / 4, 0.03)])
def test_along_a_corridor_the_claim_covers_the_error(scan: Scan, angle: float, off: float) -> None:
    """Raster walls that are not along the axes are staircases, whose steps say nothing either."""
    localizer, truth = drive(scan, angle, (12.0,), off, seed=1)
    along, across, sigma_along, sigma_across = by_direction(localizer, truth, angle)
    assert along < 3.0 * sigma_along
    assert across < 0.025
    assert sigma_across < 0.02
    assert 0.03 < sigma_along < 0.3


@pytest.mark.slow
def test_out_and_back_is_better_known_than_the_place(scan: Scan) -> None:
    """The wheels' error cancels: a Fail can be measured where the pose is not determined."""
    localizer, _ = drive(scan, 0.0, (12.0,), 0.02, seed=2)
    middle, truth = localizer.odometry, localizer.pose
    middle.set_origin()
    assert math.sqrt(middle.covariance[0, 0]) > 0.05
    for rolled in (*[STEP] * 100, *[-STEP] * 100):
        localizer.predict(rolled, rolled)
    assert localizer.pose.distance(truth) < 1e-6
    spread = localizer.odometry.displacement.covariance
    assert math.sqrt(spread[0, 0]) < 0.01


@pytest.mark.parametrize(("slip", "least", "most"), [(0.01, 1.0, 1.5), (0.1, 4.0, 60.0)])
def test_slip_beyond_what_is_claimed_is_learned(scan: Scan, slip: float, least: float, most: float) -> None:
    """Headings that the wheels miss show it, also where the position is not determined."""
    localizer, _ = drive(
        scan, 0.0, (9.0,), 0.0, seed=3, claimed=OdometryErrors(0.002, 0.005, 0.01), slip=slip
    )
    assert least <= localizer.slip.factor <= most


@pytest.mark.slow
def test_a_radius_far_from_its_claim_is_doubted(scan: Scan) -> None:
    """The end wall, while it is seen, contradicts what is claimed of the wheels."""
    claimed = OdometryErrors(radius=0.002, tread=0.005, slip=0.01)
    localizer, truth = drive(scan, 0.0, (12.0,), 0.05, seed=4, claimed=claimed)
    along, _, sigma, _ = by_direction(localizer, truth, 0.0)
    assert sigma > 0.05  # by the claim alone: 0.02
    assert along < 5.0 * sigma
