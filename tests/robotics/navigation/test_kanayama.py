import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.kanayama import KanayamaGains, Reference, StraightRun, kanayama

DT = 0.01


def moved(pose: Pose2, speed: float, turn_rate: float) -> Pose2:
    """Exact arc of one period."""
    turn = turn_rate * DT
    chord = speed * DT * (math.sin(turn / 2) / (turn / 2) if abs(turn) > 1e-9 else 1.0)
    return pose.compose(Pose2(chord * math.cos(turn / 2), chord * math.sin(turn / 2), turn))


def settling_time(start: Pose2, turn_rate: float = 0.0, gains: KanayamaGains = KanayamaGains()) -> float:
    """When the robot last was 1 mm or 1 mrad off a reference that runs at 0.3 m/s, in [s]."""
    target, pose, settled = Pose2(1.0, 2.0, 0.5), Pose2(1.0, 2.0, 0.5).compose(start), 0.0
    for step in range(1000):
        error = pose.relative_to(target)
        if math.hypot(error.x, error.y) > 1e-3 or abs(error.theta) > 1e-3:
            settled = step * DT
        pose = moved(pose, *kanayama(Reference(target, 0.3, turn_rate), pose, gains))
        target = moved(target, 0.3, turn_rate)
    return settled


def test_settles_as_fast_as_expected():
    assert settling_time(Pose2(-0.1, 0.05, 0.2)) == pytest.approx(3.5, abs=0.5)


@pytest.mark.parametrize("turn_rate", [-0.3, 0.0, 0.3])
def test_settles_from_anywhere_near(turn_rate):
    rng = np.random.default_rng(1)
    for start in rng.uniform((-0.15, -0.15, -0.6), (0.15, 0.15, 0.6), (40, 3)):
        assert settling_time(Pose2(*start), turn_rate) < 5.0


def test_on_the_reference_it_does_what_the_reference_does():
    pose = Pose2(0.4, -0.2, 2.0)
    assert kanayama(Reference(pose, 0.25, -0.1), pose) == pytest.approx((0.25, -0.1))


def test_it_steers_back():
    reference = Reference(Pose2(0.0, 0.0, 0.0), 0.3)
    assert kanayama(reference, Pose2(-0.1, 0.0, 0.0)) == pytest.approx((1.3, 0.0))
    assert kanayama(reference, Pose2(0.0, 0.1, 0.0))[1] == pytest.approx(-0.3 * 64 * 0.1)
    assert kanayama(reference, Pose2(0.0, 0.0, 0.1))[1] == pytest.approx(-0.3 * 16 * math.sin(0.1))


@pytest.mark.parametrize("length", [0.1, 2.0])
def test_a_straight_run_is_driven_to_its_end(length):
    start = Pose2(0.3, -0.1, -2.0)
    run = StraightRun(start, length)
    pose, distances = start, []
    for step in range(round(run.duration / DT) + 50):
        reference = run.at(step * DT)
        pose = moved(pose, *kanayama(reference, pose))
        distances.append(reference.pose.distance(start))
    assert pose == pytest.approx(start.compose(Pose2(length, 0.0, 0.0)), abs=1e-4)
    speeds = np.diff(distances) / DT
    assert speeds.min() >= -1e-9 and speeds.max() <= 0.3 + 1e-9
    assert np.abs(np.diff(speeds)).max() <= 0.3 * DT + 1e-9
    assert run.at(-1.0) == Reference(start, 0.0)
    assert run.at(1e3).speed == 0.0


def test_a_run_of_no_length_is_an_error():
    with pytest.raises(ValueError, match="above zero"):
        StraightRun(Pose2(0.0, 0.0, 0.0), 0.0)
