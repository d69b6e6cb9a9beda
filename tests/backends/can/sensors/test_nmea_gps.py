"""Receiver of a satellite system on a serial line: sentences, qualities, times of day."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from benchmarks.damage.fuzzed_sentences import fuzzed_sentences
from handcart.backends.can.sensors.nmea_gps import NmeaGps
from handcart.backends.can.sensors.sensor_lines import checksum
from handcart.backends.can.sensors.utc_order import UtcOrder
from handcart.backends.capabilities.gps import Fix
from handcart.backends.description.can_sensor_spec import GpsSource
from handcart.backends.live.sensor_errors import StaleSensor

from .serial_device import Device

ORIGIN: dict[str, Any] = {"origin_lat_deg": 48.0, "origin_lon_deg": 11.0}


def nmea(body: str) -> bytes:
    return f"${body}*{checksum(body.encode()):02X}\r\n".encode()


def gga(utc: str, **fields: str) -> bytes:
    fields = {"lat": "4800.1", "lon": "01100.1", "quality": "1", "hdop": "0.9"} | fields
    place = f"{fields['lat']},N,{fields['lon']},E,{fields['quality']},08,{fields['hdop']}"
    return nmea(f"GPGGA,{utc},{place},545.4,M,46.9,M,,")


def read(receiver: NmeaGps) -> Fix | None:
    """Return the fix of this period; None also if the receiver is silent."""
    try:
        return receiver.fix()
    except StaleSensor:
        return None


@pytest.fixture
def receiver(device: Device, clock: Any) -> Iterator[NmeaGps]:
    made = NmeaGps(GpsSource(port=device.port, **ORIGIN), clock)
    yield made
    made.close()


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
        taken += read(receiver) is not None
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
        assert (read(receiver) is not None) == (old == "123518" and second == 2), second


def test_s5_what_was_held_back_does_not_count(device: Device, receiver: NmeaGps, clock: Any) -> None:
    """S1 S5: sentences some seconds old, each newer than the last, from a buffer."""
    device.say(gga("123500"))
    receiver.advance()
    clock.now += 10.0
    for second in range(1, 11):
        device.say(gga(f"1235{second:02d}"))
        receiver.advance()
        # 2 s are allowed
        assert (read(receiver) is not None) is (second >= 8)


def test_a_jump_ahead_counts_when_more_bear_it_out(device: Device, receiver: NmeaGps, clock: Any) -> None:
    """One damaged time of day doesn't make all that follow old; after a sleep of the machine they count."""
    seen = []
    for utc in (120000, 120001, 180002, 120003, *range(130004, 130010), 120010):
        device.say(gga(str(utc)))
        receiver.advance()
        seen.append(read(receiver) is not None)
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


NO_FIXES = (gga("123519", quality="0"), gga("123519", quality="6"), nmea("GPGGA,123519,,,,,0,00,99.99,,,,,,"))


@pytest.mark.parametrize("sentence", NO_FIXES)
def test_a_receiver_without_a_fix_is_no_fault_and_a_silent_one_is(
    device: Device, receiver: NmeaGps, clock: Any, sentence: bytes
) -> None:
    for _ in range(60):
        clock.now += 1.0
        device.say(sentence)
        receiver.advance()
        assert receiver.fix() is None
    clock.now += 2.1
    device.say(nmea("GPZZZ,1"))
    receiver.advance()
    with pytest.raises(StaleSensor, match="the satellite receiver: its last reading is 2100 ms old"):
        receiver.fix()


def test_a_receiver_that_never_says_anything_is_silent(receiver: NmeaGps, clock: Any) -> None:
    clock.now += 2.0
    receiver.advance()
    assert receiver.fix() is None
    clock.now += 0.1
    receiver.advance()
    with pytest.raises(StaleSensor, match="no reading has come yet; allowed: 2000 ms"):
        receiver.fix()


def test_a_frozen_receiver_is_stale_with_the_reason(device: Device, receiver: NmeaGps, clock: Any) -> None:
    for _ in range(3):
        device.say(gga("123519"))
        receiver.advance()
        assert receiver.rejected < 3
        clock.now += 1.0
    device.say(gga("123519"))
    receiver.advance()
    with pytest.raises(StaleSensor, match="its times of day do not advance"):
        receiver.fix()


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


def test_random_sentences_end_nothing() -> None:
    """S3 S5: 1,000,000 by `python -m benchmarks.hostile.gps_fuzz`."""
    seen = list(fuzzed_sentences(4000, seed=1))
    assert [account.wrong for account in seen if account.wrong] == []
    assert 0 < sum(account.fixes for account in seen) < 4000
