"""When a lidar says that it is blocked, or sees next to nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.capabilities.scan import Validity
from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.lidar import Lidar
from handcart.robotics.geometry.pose2 import Pose2

BEAMS = 40
CLOSE, INVALID = -math.inf, math.nan


class Raw(RangeSensor):
    """A driver that delivers what it is given; the first beam looks backwards."""

    def __init__(self) -> None:
        self.ranges, self.made = np.full(BEAMS, 2.0), 0

    def scan(self) -> Scan:
        self.made += 1
        angles = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
        return Scan(angles, self.ranges, Pose2(0.0, 0.0, 0.0))


def lidar_of(raw: Raw, *masked: tuple[float, float]) -> Lidar:
    spec = RangeSpec(beams=BEAMS, reach_m=8.0, sigma_mm=10.0, masked_deg=masked)
    return Lidar(raw, load_robot("cart").model_copy(update={"range_sensor": spec}))


@pytest.mark.parametrize(("close", "invalid", "blocked"), [(12, 8, False), (13, 8, True), (0, 21, True)])
def test_a_lidar_is_blocked_where_most_beams_see_nothing(close: int, invalid: int, blocked: bool) -> None:
    raw = Raw()
    raw.ranges = np.array([CLOSE] * close + [INVALID] * invalid + [2.0] * (BEAMS - close - invalid))
    lidar = lidar_of(raw)
    assert lidar.blind_share == pytest.approx((close + invalid) / BEAMS)
    beams = f"of 40 beams {close} are too close and {invalid} give no reading"
    words = f"the lidar is blocked or dirty: {beams}" if blocked else ""
    assert lidar.blockage == words
    assert (words in lidar.silence) if blocked else lidar.silence == ""


def test_masked_beams_do_not_count_as_blocked() -> None:
    """Nine beams from -180 to -108 degrees; of the 31 others 16 are more than half."""
    raw = Raw()
    raw.ranges = np.array([CLOSE] * 9 + [INVALID] * 15 + [2.0] * 16)
    lidar = lidar_of(raw, (-180.0, -108.0))
    assert lidar.blind_share == pytest.approx(15 / 31)
    assert lidar.blockage == ""
    raw.ranges = np.array([CLOSE] * 10 + [INVALID] * 15 + [2.0] * 15)
    assert "of 31 beams 1 are too close and 15 give no reading" in lidar.blockage


def test_a_lidar_that_is_masked_all_round_is_blind() -> None:
    assert lidar_of(Raw(), (-180.0, 180.0), (0.0, 359.0)).blind_share == 1.0


@pytest.mark.parametrize(("echoes", "silent"), [(20, False), (19, True), (0, True)])
def test_fewer_than_twenty_echoes_are_next_to_none(echoes: int, silent: bool) -> None:
    raw = Raw()
    raw.ranges = np.array([2.0] * echoes + [math.inf] * (BEAMS - echoes))
    words = f"the lidar gets next to no echoes: {echoes} of 40 beams return" if silent else ""
    assert lidar_of(raw).silence == words


def test_a_raw_scan_is_read_once_and_the_next_one_anew() -> None:
    raw = Raw()
    lidar, one = lidar_of(raw), raw.scan()
    raw.scan = lambda: one  # type: ignore[method-assign]
    first = lidar.scan()
    assert first is lidar.scan()
    assert first.validity.tolist() == [Validity.RETURN] * BEAMS
    raw.scan = lambda: one._replace(ranges=np.full(BEAMS, 9.0))  # type: ignore[method-assign]
    assert lidar.scan().validity.tolist() == [Validity.NO_RETURN] * BEAMS
    assert lidar.scan_later()().validity.tolist() == [Validity.NO_RETURN] * BEAMS


def test_silence_and_beams_are_those_of_the_newest_scan() -> None:
    raw = Raw()
    lidar = lidar_of(raw)
    assert lidar.silence == ""
    assert lidar.beams().ranges.tolist() == [2.0] * BEAMS
    raw.ranges = np.full(BEAMS, math.inf)
    assert lidar.silence == f"the lidar gets next to no echoes: 0 of {BEAMS} beams return"
    assert lidar.beams().ranges.tolist() == [math.inf] * BEAMS


def test_beams_of_one_scan_are_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = Raw()
    lidar, one = lidar_of(raw), raw.scan()
    monkeypatch.setattr(raw, "scan", lambda: one)
    assert lidar.beams() is lidar.beams()
