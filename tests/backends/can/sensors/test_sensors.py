"""Sensors beside the drives: on a pseudo-terminal, from files."""

from __future__ import annotations

import fcntl
import os
import pty
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from benchmarks.damage.fuzzed_sentences import fuzzed_sentences
from handcart.backends.can.sensors.line_imu import LineImu
from handcart.backends.can.sensors.line_range_sensor import LineRangeSensor
from handcart.backends.can.sensors.live_sensors import await_first, open_sensors, sensor_kinds
from handcart.backends.can.sensors.nmea_gps import NmeaGps
from handcart.backends.can.sensors.range_server import RangeServer
from handcart.backends.can.sensors.sensor_lines import checksum, read_line, sensor_line
from handcart.backends.can.sensors.strict_number import strict_number
from handcart.backends.can.sensors.utc_order import UtcOrder
from handcart.backends.can.sensors.video_camera import VideoCamera
from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.can_sensor_spec import CameraSource, GpsSource, LineSource, SensorsSpec
from handcart.backends.description.sensor_specs import CameraSpec, RangeSpec
from handcart.backends.live.sensor_errors import NoSensor, StaleSensor
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.mounted_camera import MountedCamera, camera_model
from handcart.robotics.geometry.pose2 import Pose2

RANGE = RangeSpec(beams=4, reach_m=5.0, sigma_mm=10.0)
CAMERA = CameraSpec(width_px=64, height_px=48, focal_px=60.0)


class Device:
    """Device at the other end of a pseudo-terminal."""

    def __init__(self) -> None:
        self._ours, theirs = pty.openpty()
        tty.setraw(theirs)
        self.port = os.ttyname(theirs)
        self._theirs = theirs

    def say(self, line: bytes) -> None:
        waiting = self._waiting() + len(line)
        os.write(self._ours, line)
        while self._waiting() < waiting:  # the system hands it over by and by
            time.sleep(0.001)

    def _waiting(self) -> int:
        return int.from_bytes(fcntl.ioctl(self._theirs, termios.FIONREAD, bytes(4)), "little")

    def unplug(self) -> None:
        for each in (self._ours, self._theirs):
            if each >= 0:
                os.close(each)
        self._ours = self._theirs = -1


@pytest.fixture
def device() -> Iterator[Device]:
    made = Device()
    yield made
    made.unplug()


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


def nmea(body: str) -> bytes:
    return f"${body}*{checksum(body.encode()):02X}\r\n".encode()


def test_a_receiver(device: Device, clock: Any) -> None:
    """10 arc seconds north are 308.9 m in the middle latitudes, 10 east of them at 48 degrees 207 m."""
    source = GpsSource(port=device.port, origin_lat_deg=48.0, origin_lon_deg=11.0)
    receiver = NmeaGps(source, clock)
    gga = "GPGGA,{},4800.16667,N,01100.16667,E,{},08,0.9,545.4,M,46.9,M,,"
    device.say(nmea(gga.format(123519, 1)))
    receiver.advance()
    fix = receiver.fix()
    assert fix is not None
    np.testing.assert_allclose(fix.position, [207.2, 308.9], atol=0.3)
    assert fix.sigma == pytest.approx(2.5 * 0.9)
    receiver.advance()
    assert receiver.fix() is None  # none came in this period
    device.say(nmea("GPGST,123520,0.5,,,,0.30,0.40,0.9") + nmea(gga.format("123520.00", 4)))
    receiver.advance()
    fix = receiver.fix()
    assert fix is not None
    assert fix.sigma == pytest.approx(np.hypot(0.3, 0.4) / np.sqrt(2))
    device.say(
        nmea(gga.format(123521, 0))
        + b"$GPGGA,1*00\r\n"
        + b"\xff\xfe$!!\r\n"
        + nmea("GPGGA,1,x,N,y,E,1,,,,,,,,")
    )
    receiver.advance()
    assert receiver.fix() is None
    assert receiver.rejected == 3
    receiver.close()


def test_a_receiver_that_isnt_good_enough(device: Device, clock: Any) -> None:
    source = GpsSource(port=device.port, origin_lat_deg=48.0, origin_lon_deg=11.0, quality=4)
    receiver = NmeaGps(source, clock)
    for quality, good in ((1, False), (5, False), (4, True)):
        device.say(nmea(f"GPGGA,123519,4800.1,N,01100.1,E,{quality},08,0.9,545.4,M,46.9,M,,"))
        receiver.advance()
        assert (receiver.fix() is not None) is good
    receiver.close()


@pytest.mark.parametrize(
    ("needed", "taken"), [(1, {1, 2, 3, 4, 5}), (3, {2, 3, 4, 5}), (2, {2, 4, 5}), (5, {4, 5}), (4, {4})]
)
def test_qualities_of_fixes_rank_as_the_standard_says(
    device: Device, clock: Any, needed: Any, taken: set[int]
) -> None:
    """All ten digits; 0, 6, 7, 8 and 9 aren't satellite fixes."""
    receiver = NmeaGps(GpsSource(port=device.port, **ORIGIN, quality=needed), clock)
    found = set()
    for quality in range(10):
        device.say(nmea(f"GPGGA,12351{quality},4800.1,N,01100.1,E,{quality},08,0.9,545.4,M,46.9,M,,"))
        receiver.advance()
        clock.now += 1.0
        found |= {quality} if receiver.fix() is not None else set()
    receiver.close()
    assert found == taken


def test_stale_receiver_says_that_it_sends_dead_reckoning(device: Device, clock: Any) -> None:
    receiver = NmeaGps(GpsSource(port=device.port, **ORIGIN), clock)
    device.say(nmea("GPGGA,123519,4800.1,N,01100.1,E,6,08,0.9,545.4,M,46.9,M,,"))
    receiver.advance()
    with pytest.raises(StaleSensor, match="places of quality 6, estimated by dead reckoning"):
        receiver.check_fresh()
    receiver.close()


ORIGIN: dict[str, Any] = {"origin_lat_deg": 48.0, "origin_lon_deg": 11.0}


@pytest.fixture
def receiver(device: Device, clock: Any) -> Iterator[NmeaGps]:
    made = NmeaGps(GpsSource(port=device.port, **ORIGIN), clock)
    yield made
    made.close()


def gga(utc: str, **fields: str) -> bytes:
    fields = {"lat": "4800.1", "lon": "01100.1", "quality": "1", "hdop": "0.9"} | fields
    place = f"{fields['lat']},N,{fields['lon']},E,{fields['quality']},08,{fields['hdop']}"
    return nmea(f"GPGGA,{utc},{place},545.4,M,46.9,M,,")


@pytest.mark.parametrize(
    "sentence",
    [
        b"$GPGGA*56\r\n",
        b"$GPGST,1*4A\r\n",
        b"$PUBX*1F\r\n",
        nmea(""),
        nmea("G"),
        nmea("GPGGA,,,"),
        nmea("GPGGA,123519,,,,,0,00,99.99,,,,,,"),
        nmea("GPGST,123519,,,,,,,"),
        nmea("GPTXT,01,01,02,\x7f"),
        nmea("GPZZZ,1"),
        gga("123519", lat="4860.0"),
        gga("123519", lat="9100.0"),
        gga("123519", lon="18100.0"),
        gga("123519", lat="48_0.1"),
        gga("123519", hdop="1_0"),
        gga("123519", hdop=""),
        gga("123519", hdop="0.0"),
        gga("123519", quality="7"),
        gga("123519", quality=""),
        gga("243519"),
        gga("126019"),
        gga("123562"),
        gga(""),
        nmea("GPGGA,123519,4800.1,N,01100.1,E,1,08,0.9,545.4,M,46.9"),
        gga("123519").replace(b"*", b"*+"),
        gga("123519")[1:],
        b"$\xff\xfe*01\r\n",
    ],
)
def test_s3_sentences_that_tell_no_place_end_nothing(
    device: Device, receiver: NmeaGps, sentence: bytes
) -> None:
    """S3: damaged, cut off, of other kinds, of places and times that there aren't."""
    device.say(sentence)
    receiver.advance()
    assert receiver.fix() is None
    device.say(gga("123519"))
    receiver.advance()
    assert receiver.fix() is not None


def test_s5_a_sentence_counts_once(device: Device, receiver: NmeaGps, clock: Any) -> None:
    """S5: the same time of day again, 50 times; then the receiver is stale."""
    taken = 0
    for _ in range(50):
        device.say(gga("123519.00"))
        receiver.advance()
        taken += receiver.fix() is not None
        clock.now += 0.1
    assert taken == 1
    assert receiver.rejected == 49
    assert receiver.age == pytest.approx(4.9)


@pytest.mark.parametrize("old", ["003519", "123518", "123459", "113520"])
def test_s5_an_old_sentence_does_not_count(device: Device, receiver: NmeaGps, clock: Any, old: str) -> None:
    """S5: a second sentence, twelve hours old, though its time advances with the clock."""
    device.say(gga("123519"))
    receiver.advance()
    for second in range(3):
        clock.now += 1.0
        device.say(gga(str(int(old) + second).zfill(6)))
        receiver.advance()
        assert (receiver.fix() is not None) == (old == "123518" and second == 2), second


def test_s5_what_was_held_back_does_not_count(device: Device, receiver: NmeaGps, clock: Any) -> None:
    """S1 S5: sentences some seconds old, each newer than the last, from a buffer."""
    device.say(gga("123500"))
    receiver.advance()
    clock.now += 10.0
    for second in range(1, 11):
        device.say(gga(f"1235{second:02d}"))
        receiver.advance()
        # 2 s are allowed
        assert (receiver.fix() is not None) is (second >= 8)


def test_a_jump_ahead_counts_when_more_bear_it_out(device: Device, receiver: NmeaGps, clock: Any) -> None:
    """One damaged time of day doesn't make all that follow old; after a sleep of the machine they count."""
    seen = []
    for utc in (120000, 120001, 180002, 120003, *range(130004, 130010), 120010):
        device.say(gga(str(utc)))
        receiver.advance()
        seen.append(receiver.fix() is not None)
        clock.now += 1.0
    assert seen == [True, True, False, True, False, False, False, False, True, True, False]


def test_one_that_came_sooner_makes_the_others_no_later() -> None:
    """Five in a row that come sooner than usual are the usual from then on, by the least of them."""
    order = UtcOrder(2.0)
    assert order.is_new(100.0, 10.0)
    for second, sooner in enumerate((1.0, 0.1, 0.1, 0.1, 0.1), 1):
        order.is_new(100.0 + 2.0 * second, 10.0 + 2.0 * second - sooner)
    assert order.is_new(120.0, 30.0 + 1.8)
    assert not order.is_new(130.0, 40.0 + 1.95)


def test_south_and_west(device: Device, receiver: NmeaGps) -> None:
    device.say(gga("123519", lat="4800.0", lon="01100.0"))
    receiver.advance()
    here = receiver.fix()
    assert here is not None
    np.testing.assert_allclose(here.position, [0.0, 0.0], atol=1e-6)
    device.say(nmea("GPGGA,123520,4800.0,S,01100.0,W,1,08,0.9,545.4,M,46.9,M,,"))
    receiver.advance()
    there = receiver.fix()
    assert there is not None
    assert there.position[1] < -1e6
    assert there.position[0] < -1e5


def test_midnight_and_clocks_that_drift(device: Device, receiver: NmeaGps, clock: Any) -> None:
    """Three days, a sentence each ten minutes, by a clock that is 50 ppm fast, or slow."""
    for rate in (1.00005, 0.99995):
        begun = UtcOrder(2.0)
        assert all(begun.is_new(600.0 * n % 86400.0, 5.0 + rate * 600.0 * n) for n in range(432))


def test_how_sure_a_fix_is_is_of_its_time(device: Device, receiver: NmeaGps, clock: Any) -> None:
    """S1: a GST that stays away isn't the one of now."""
    device.say(nmea("GPGST,120000,0.5,,,,0.02,0.02,0.9") + gga("120000"))
    receiver.advance()
    first = receiver.fix()
    clock.now += 10.0
    device.say(gga("120010"))
    receiver.advance()
    second = receiver.fix()
    assert first is not None
    assert second is not None
    assert (first.sigma, second.sigma) == pytest.approx((0.02, 2.5 * 0.9))


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


def test_random_sentences_end_nothing() -> None:
    """S3 S5: 1,000,000 by `python -m benchmarks.hostile.gps_fuzz`."""
    seen = list(fuzzed_sentences(4000, seed=1))
    assert [each.wrong for each in seen if each.wrong] == []
    assert 0 < sum(each.fixes for each in seen) < 4000


@pytest.mark.parametrize("port", ["/dev/none", "socket://127.0.0.1:1", "nonsense://x"])
def test_a_port_that_isnt_there(port: str) -> None:
    with pytest.raises(NoSensor, match=r"the inertial unit: .* can't be opened"):
        LineImu(LineSource(port=port))


@pytest.fixture
def make_camera(clock: Any) -> Iterator[Callable[..., VideoCamera]]:
    made: list[VideoCamera] = []

    def make(source: Path, spec: CameraSpec = CAMERA) -> VideoCamera:
        made.append(
            VideoCamera(CameraSource(source=str(source)), MountedCamera(camera_model(spec), np.eye(4)), clock)
        )
        return made[-1]

    yield make
    for each in made:
        each.close()


def picture(grey: int) -> np.ndarray:
    return np.full((48, 64, 3), grey, np.uint8)


def test_a_picture_stays(tmp_path: Path, clock: Any, make_camera: Callable[..., VideoCamera]) -> None:
    path = tmp_path / "picture.png"
    cv2.imwrite(str(path), picture(77))
    camera = make_camera(path)
    for _ in range(5):
        clock.now += 1.0
        camera.advance()
        image = camera.image()
        assert image.shape == (48, 64)
        assert image.dtype == np.uint8
        assert int(image[0, 0]) == 77
    assert camera.model.width == 64


def test_a_video_goes_on_a_picture_a_period(tmp_path: Path, make_camera: Callable[..., VideoCamera]) -> None:
    path = tmp_path / "video.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10, (64, 48))
    for grey in (40, 120, 200):
        writer.write(picture(grey))
    writer.release()
    camera, seen = make_camera(path), []
    for _ in range(4):
        camera.advance()
        assert camera.image() is camera.image()
        seen.append(int(camera.image().mean()))
    np.testing.assert_allclose(seen, [40, 120, 200, 200], atol=3)


def test_a_picture_of_another_size_is_refused(
    tmp_path: Path, make_camera: Callable[..., VideoCamera]
) -> None:
    cv2.imwrite(str(tmp_path / "picture.png"), picture(77)[:40])
    with pytest.raises(NoSensor, match="the camera gives 64 x 40 pixels; the robot's file says 64 x 48"):
        make_camera(tmp_path / "picture.png")
    (tmp_path / "empty.png").write_bytes(b"")
    with pytest.raises(NoSensor, match=r"can't be opened|gives no picture"):
        make_camera(tmp_path / "empty.png")


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
