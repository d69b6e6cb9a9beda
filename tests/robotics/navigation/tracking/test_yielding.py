"""Speeds with which a base yields to people."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.tracking.people import People
from handcart.robotics.navigation.tracking.yielding import safe_share, yielding_speed

HERE = Pose2(0.0, 0.0, 0.0)


def somebody(x: float, y: float, vx: float, vy: float, stood_s: float = 0.0) -> People:
    """Return one person whose position is known to 5 cm."""
    covariance = np.diag([0.0025, 0.0025, 0.01, 0.01])[None]
    return People(np.array([[x, y]]), np.array([[vx, vy]]), covariance, np.array([0.25]), np.array([stood_s]))


@pytest.mark.parametrize(
    ("person", "low", "high"),
    [
        (somebody(1.0, 0.0, -1.2, 0.0), 0.0, 0.0),  # comes towards the base
        (somebody(0.8, -0.9, 0.0, 1.2), 0.0, 0.3),  # in front before the base can stop
        (somebody(-0.7, 0.0, 1.2, 0.0), 0.0, 0.0),  # comes from behind: stop
        (somebody(5.0, 0.0, -1.2, 0.0), 1.0, 1.0),
        (somebody(0.0, 2.5, 0.0, 1.2), 1.0, 1.0),  # walks away
        (somebody(-0.5, 0.0, 0.0, 0.0, 5.0), 0.1, 0.3),  # close behind, at rest: the base may leave
        (somebody(-0.5, 0.0, 0.0, 0.0, 2.0), 0.0, 0.0),  # at rest for a moment: may walk again at once
        (somebody(1.45, 0.0, 0.3, 0.0), 0.0, 0.7),  # walks away, and would be met if she turned back
    ],
)
def test_share_of_a_command_leads_into_nobody(person: People, low: float, high: float) -> None:
    assert low <= safe_share(HERE, (0.6, 0.0), person, 0.22, 0.6, 0.05) <= high


def test_speed_along_a_route_lets_the_crossing_pass() -> None:
    ahead = np.array([[0.0, 0.0], [6.0, 0.0]])
    crossing = somebody(1.5, -1.8, 0.0, 1.2)
    assert yielding_speed(ahead, 1.0, crossing, 0.22, 0.5) <= 0.45
    assert yielding_speed(ahead, 1.0, somebody(1.5, 1.2, 0.0, 1.2), 0.22, 0.5) == 1.0
