"""Sensors beside the drives on serial lines, and how the sensors of a robot are opened."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from handcart.backends.can.sensors.line_imu import LineImu
from handcart.backends.can.sensors.line_range_sensor import LineRangeSensor
from handcart.backends.can.sensors.live_sensors import await_first, open_sensors, sensor_kinds
from handcart.backends.can.sensors.range_server import RangeServer
from handcart.backends.can.sensors.sensor_lines import checksum, read_line, sensor_line
from handcart.backends.can.sensors.strict_number import strict_number
from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.can_sensor_spec import LineSource, SensorsSpec
from handcart.backends.description.sensor_specs import RangeSpec
from handcart.backends.live.sensor_errors import NoSensor, StaleSensor
from handcart.backends.loading.robot_loading import load_robot
from handcart.robotics.geometry.pose2 import Pose2

from .serial_device import Device

RANGE = RangeSpec(beams=4, reach_m=5.0, sigma_mm=10.0)


@pytest.fixture
def scanner(device: Device, clock: Any) -> Iterator[LineRangeSensor]:
    sensor = LineRangeSensor(LineSource(port=device.port), RANGE, np.eye(4), clock)
    yield sensor
    sensor.close()


def ranges(stamp: int, *values: float) -> bytes:
    return sensor_line("RANGE", stamp, np.array(values))


def test_lines_come_back_as_they_were_sent() -> None:
    read = read_line(ranges(1250, 0.5, np.inf, 2.25, 3.0).strip())
    assert read is not None
    assert (read.kind, read.stamp) == ("RANGE", 1250)
    np.testing.assert_array_equal(read.values, [0.5, np.inf, 2.25, 3.0])
    for sentence in (b"$RANGE,1250,0.512,0.514,,0.52*6A", b"$IMU,1250,0.001,0.0,-0.02,0.1,0.0,9.81*54"):
        assert read_line(sentence) is not None
    assert checksum(b"") == 0


@pytest.mark.parametrize(
    "line",
    [b"", b"$", b"*", b"$RANGE,1,2*00", b"RANGE,1*00", b"$RANGE,x,1*4C", b"\xff" * 9, b"$RANGE,1,2*zz"],
)
def test_damaged_lines_are_none(line: bytes) -> None:
    assert read_line(line) is None


def test_a_scan(device: Device, scanner: LineRangeSensor) -> None:
    device.say(ranges(10, 1.0, 2.0, np.inf, 7.0))
    scanner.advance()
    scan = scanner.scan()
    np.testing.assert_array_equal(scan.ranges, [1.0, 2.0, np.inf, np.inf])  # 7 m is beyond its reach
    np.testing.assert_allclose(scan.angles, np.radians([-180, -90, 0, 90]))
    np.testing.assert_allclose(scan.points(), [[-1.0, 0.0], [0.0, -2.0]], atol=1e-12)
    scanner.advance()
    assert scanner.scan() is scan  # as no other has arrived
    device.say(ranges(20, 1.0, 2.0, np.inf, 7.0))
    scanner.advance()
    assert scanner.scan() is not scan


def test_halves_of_lines_wait_for_the_rest(device: Device, scanner: LineRangeSensor) -> None:
    whole = ranges(10, 1.0, 2.0, 3.0, 4.0)
    device.say(whole[:9])
    scanner.advance()
    with pytest.raises(StaleSensor, match="the range sensor: no reading has come yet; allowed: 200 ms"):
        scanner.scan()
    device.say(whole[9:])
    scanner.advance()
    assert scanner.scan().ranges[0] == 1.0


def test_s1_stale(device: Device, scanner: LineRangeSensor, clock: Any) -> None:
    """S1: no new reading for 200 ms."""
    device.say(ranges(10, 1.0, 2.0, 3.0, 4.0))
    scanner.advance()
    clock.now += 0.19
    scanner.advance()
    scanner.scan()
    clock.now += 0.02
    scanner.advance()
    with pytest.raises(StaleSensor, match="its last reading is 210 ms old; allowed: 200 ms"):
        scanner.scan()


def test_s3_s5_what_is_no_reading_is_dropped(device: Device, scanner: LineRangeSensor, clock: Any) -> None:
    """S3: no number, another size; S5: a stamp again, or backwards. They count, and the last grows old."""
    device.say(ranges(10, 1.0, 2.0, 3.0, 4.0))
    scanner.advance()
    clock.now += 0.15
    body = b"RANGE,20,1.0,NaN,3.0,4.0"
    device.say(b"$%b*%02X\n" % (body, checksum(body)) + ranges(30, 1.0) + ranges(10, 9.0, 9.0, 9.0, 9.0))
    device.say(ranges(5, 9.0, 9.0, 9.0, 9.0) + b"$RANGE,40,1,1,1,1*00\n")
    scanner.advance()
    assert scanner.rejected == 5
    assert scanner.scan().ranges[0] == 1.0
    assert scanner.age == pytest.approx(0.15)


def test_s6_a_sensor_that_is_unplugged(device: Device, scanner: LineRangeSensor, clock: Any) -> None:
    """S6: `advance` doesn't raise; reading raises an error with the reason."""
    device.unplug()
    for _ in range(3):
        clock.now += 1.0
        scanner.advance()
    with pytest.raises(StaleSensor, match="the range sensor: no reading has come yet"):
        scanner.scan()


def test_an_inertial_unit_is_averaged_over_the_period(device: Device, clock: Any) -> None:
    unit = LineImu(LineSource(port=device.port), clock)
    for stamp, rate in ((1, 0.1), (2, 0.3), (3, 500.0)):
        device.say(sensor_line("IMU", stamp, np.array([0.0, 0.0, rate, 0.0, 0.0, 9.81])))
    unit.advance()
    np.testing.assert_allclose(unit.rates(), [0.0, 0.0, 0.2])
    np.testing.assert_allclose(unit.accelerations(), [0.0, 0.0, 9.81])
    assert unit.rejected == 1
    clock.now += 1.0
    unit.rates()  # in one period the same
    unit.advance()
    with pytest.raises(StaleSensor):
        unit.rates()
    unit.close()


def test_range_lines_carry_what_a_driver_delivers(device: Device, scanner: LineRangeSensor) -> None:
    """REP 117: -inf too close, NaN invalid; and zeros, as many drivers send them for no return."""
    device.say(ranges(10, -np.inf, np.nan, 0.0, np.inf))
    scanner.advance()
    np.testing.assert_array_equal(scanner.scan().ranges, [-np.inf, np.nan, 0.0, np.inf])
    body = b"RANGE,20,inf,,-0.5,nan"
    device.say(b"$%b*%02X\n" % (body, checksum(body)))
    scanner.advance()
    np.testing.assert_array_equal(scanner.scan().ranges, [np.inf, np.inf, -0.5, np.nan])
    assert read_line(sensor_line("IMU", 1, np.array([np.nan]))) is None


def test_a_scan_covers_the_field_of_view_of_the_robots_file(device: Device, clock: Any) -> None:
    half = RangeSpec(beams=3, reach_m=5.0, sigma_mm=10.0, start_deg=-90.0, end_deg=90.0)
    sensor = LineRangeSensor(LineSource(port=device.port), half, np.eye(4), clock)
    device.say(ranges(10, 1.0, 2.0, 3.0))
    sensor.advance()
    np.testing.assert_allclose(sensor.scan().angles, np.radians([-90.0, 0.0, 90.0]))
    np.testing.assert_allclose(sensor.scan().points(), [[0.0, -1.0], [2.0, 0.0], [0.0, 3.0]], atol=1e-12)
    sensor.close()


@pytest.mark.parametrize(
    "field",
    ["1_0.5", " 1.5", "1.5 ", "NaN", "Infinity", "+inf", "1e999", "0x1", "\u0661", "--1", "1e", ".", "+"],
)
def test_s3_numbers_are_decimal(field: str) -> None:
    """S3: texts that Python would accept as numbers, in ranges and in readings of an inertial unit."""
    for kind, values in (("RANGE", f"1.0,{field},2.0"), ("IMU", f"{field},0.0,0.0,0.0,0.0,9.81")):
        body = f"{kind},1250,{values}".encode()
        read = read_line(b"$%b*%02X" % (body, checksum(body)))
        assert read is None
    for stamp in ("1_0", "+5", " 5", "-5", "5.0", ""):
        body = f"RANGE,{stamp},1.0".encode()
        assert read_line(b"$%b*%02X" % (body, checksum(body))) is None
    assert strict_number("-1.5e-3") == -0.0015
    assert read_line(b"$RANGE,1,2*0x1") is None


@pytest.mark.parametrize("port", ["/dev/none", "socket://127.0.0.1:1", "nonsense://x"])
def test_a_port_that_isnt_there(port: str) -> None:
    with pytest.raises(NoSensor, match=r"the inertial unit: .* can't be opened"):
        LineImu(LineSource(port=port))


def test_sensors_of_a_robot(device: Device) -> None:
    cart = load_robot("cart")
    sensors = SensorsSpec(range_sensor=LineSource(port=device.port))
    assert sensor_kinds(sensors) == (RangeSensor,)
    before = threading.active_count()
    (scanner,) = open_sensors(cart, sensors)
    with pytest.raises(NoSensor, match=r"the range sensor gave no reading in 0\.05 s"):
        await_first([scanner], 0.05)
    device.say(ranges(1, *[1.0] * 360))
    await_first([scanner])
    scanner.close()
    with pytest.raises(NoSensor, match="needed: the section 'imu'"):
        open_sensors(
            cart, SensorsSpec(range_sensor=LineSource(port=device.port), imu=LineSource(port="/dev/x"))
        )
    assert threading.active_count() == before


class Walls(RangeSensor):
    """Range sensor with given ranges."""

    def __init__(self) -> None:
        self.ranges = np.array([1.0, np.inf, 2.5, 3.0])

    def scan(self) -> Scan:
        return Scan(np.zeros(4), self.ranges, Pose2(0.0, 0.0, 0.0))


def test_scans_of_a_bench_in_another_process(clock: Any) -> None:
    """Scans as `handcart bench --range-port` sends them; clients that don't read, or hang up, are
    disconnected.
    """
    walls = Walls()
    server = RangeServer(walls, 0)
    scanner = LineRangeSensor(LineSource(port=f"socket://127.0.0.1:{server.port}"), RANGE, np.eye(4), clock)
    for number in range(200):
        walls.ranges = walls.ranges + 0.001
        server.send(0.05 * number)
        time.sleep(0.001)
        scanner.advance()
        if scanner.age == 0.0 and number > 5:
            break
    np.testing.assert_allclose(scanner.scan().ranges, walls.ranges, atol=2e-3)
    scanner.close()
    for number in range(200, 210):
        server.send(0.05 * number)
    server.close()
