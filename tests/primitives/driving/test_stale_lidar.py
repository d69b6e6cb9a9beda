"""A lidar that gives its last scan again and again: the base waits, and drives on once new scans come."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import GiveUp, Success
from handcart.primitives.restoring.snapshot import settle
from tests.primitives.conftest import Rig

AHEAD = Place(x_m=1.0, y_m=4.0, heading_deg=90.0)


def frozen(rig: Rig, begin_s: float, seconds: float) -> list[tuple[float, float]]:
    """Freeze the lidar for a while; return its list of times and of y by the ground truth, in [s] and [m]."""
    sensor: Any = rig.robot.lidar._sensor  # type: ignore[union-attr]
    take = sensor.scan
    kept: list[Any] = []
    rows: list[tuple[float, float]] = []

    def scan() -> Any:
        if not begin_s <= rig.robot.time < begin_s + seconds:
            kept[:] = [take()]
        else:
            rows.append((rig.robot.time, rig.scene.base.y))
        return kept[0]

    sensor.scan = scan
    return rows


@pytest.mark.slow
@pytest.mark.parametrize("localizer", ["scan", "odometry"])
def test_a_lidar_stale_for_three_seconds_only_delays(make_rig: Callable[..., Rig], localizer: str) -> None:
    rig = make_rig(localizer=localizer, robot="cart")
    rig.model.places = {**rig.model.places, "ahead": AHEAD}
    rows = frozen(rig, 3.5, 3.0)
    assert isinstance(rig.run(MoveTo(place="ahead")), Success)
    first, last = rows[0], rows[-1]
    assert last[1] - first[1] < 0.6 * 0.3 + 0.6**2 / 0.8 + 0.05  # until it notices, and brakes
    assert all(y == pytest.approx(last[1], abs=0.005) for time, y in rows if time > first[0] + 2.0)


def test_a_lidar_that_stays_stale_is_named(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(robot="cart")
    rig.model.places = {**rig.model.places, "ahead": AHEAD}
    rows = frozen(rig, 3.5, 1e9)
    given_up = rig.run(MoveTo(place="ahead"))
    assert isinstance(given_up, GiveUp)
    assert given_up.cause is causes.SENSOR_FAULT
    assert given_up.reason == "the lidar repeats its last scan"
    assert 5.0 < rows[-1][0] - rows[0][0] < 8.0


@pytest.mark.parametrize("seconds", [1.0, 5.5])
@pytest.mark.parametrize("localizer", ["scan", "odometry"])
def test_base_that_stops_before_a_stalled_lidar_settles_later(
    make_rig: Callable[..., Rig], localizer: str, seconds: float
) -> None:
    """It is at rest once a new scan has been compared with the map."""
    rig = make_rig(localizer=localizer, robot="cart")
    for _ in range(20):
        rig.robot.step()
    begin = rig.robot.time + 0.9
    frozen(rig, begin, seconds)
    for _ in range(20):
        rig.robot.base.drive(0.3, 0.0)
        rig.robot.step()
    waits = settle(rig.robot)
    with pytest.raises(StopIteration) as end:
        while next(waits) is None:
            rig.robot.step()
    assert end.value.value is True
    assert rig.robot.time >= begin + seconds
    assert rig.robot.localization.stale_s == 0.0
    assert rig.robot.localization.added_sigma == 0.0
