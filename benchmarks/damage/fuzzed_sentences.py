"""Sentences that no satellite receiver should send, and what becomes of them."""

from __future__ import annotations

import random
import traceback
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from handcart.backends.can.sensors.nmea_gps import NmeaGps
from handcart.backends.can.sensors.sensor_lines import checksum
from handcart.backends.capabilities.gps import Fix
from handcart.backends.description.can_sensor_spec import GpsSource
from handcart.backends.live.sensor_errors import StaleSensor

MAX_DELAY_S = 2.0  # [s] that a sentence may be late, or ahead
_BATCH = 1000  # sentences between two accounts
_PERIOD = 0.05  # [s]
_MOST = 20  # sentences of a period
_KINDS = ("GGA", "GST", "RMC", "GSV", "ZDA", "TXT", "UBX", "")
_PARTS = ("", "0", "1", "-1", "1_0", "nan", "inf", "1e999", "N", "E", "4800.1", "01100.1", "123519", "9" * 40,
          "\x00", "\xe9", "*", "$", ".", "0.0", "60.0")  # fmt: skip


@dataclass(frozen=True)
class Account:
    """Result of some sentences."""

    sentences: int
    fixes: int
    wrong: str
    """Violation: an error, a fix without a position, or a time of day that repeats or goes back."""


class _Fed:
    """A port that gives what it is given."""

    def __init__(self) -> None:
        self.waiting: list[bytes] = []

    def lines(self) -> Iterator[bytes]:
        given, self.waiting = self.waiting, []
        return iter(given)

    def close(self) -> None:
        self.waiting = []


def fuzzed_sentences(count: int, seed: int = 0) -> Iterator[Account]:
    """Let a receiver say so many sentences: sound, damaged, random, repeated, late.

    Args:
        count: of sentences; most of them have a right check sum.
        seed: the same one gives the same sentences.
    """
    rng, now = random.Random(seed), 100.0
    source = GpsSource(port="loop://", stale_ms=1e3 * MAX_DELAY_S, origin_lat_deg=48.0, origin_lon_deg=11.0)
    receiver, port = NmeaGps(source, lambda: now), _Fed()
    receiver.close()
    receiver._port = port  # type: ignore[assignment]
    said: list[bytes] = []
    last = now
    port.waiting = [_framed(_fix_of(rng, now))]
    receiver.advance()
    while count > 0:
        sentences, fixes, wrong = 0, 0, ""
        while sentences < min(_BATCH, count) and not wrong:
            now += _PERIOD
            given = port.waiting = [_sentence(rng, now, said) for _ in range(rng.randint(1, _MOST))]
            sentences += len(given)
            try:
                receiver.advance()
                fix = receiver.fix()
            except StaleSensor:  # nothing sound for a while
                fix = None
            except Exception:
                wrong = traceback.format_exc()
                break
            if fix is not None:
                fixes += 1
                times = _times_of(fix, given, receiver)
                sound = [utc for utc in times if abs(utc - now) <= MAX_DELAY_S + 0.01 and utc > last]
                if not sound:
                    wrong = f"{fix} of {times} at {now}, after {last}"
                last = min(sound, default=last)
        count -= sentences
        yield Account(sentences, fixes, wrong)


def _times_of(fix: Fix, given: list[bytes], receiver: NmeaGps) -> list[float]:
    """Return the times of day, in [s], of the sentences that a fix may be from."""
    times = []
    for line in given:
        fields = line.partition(b"*")[0].split(b",")
        try:
            clock, lat, lon = (float(fields[at]) for at in (1, 2, 4))
            north_south, east_west = fields[3], fields[5]
        except (ValueError, IndexError):
            continue
        north, east = (item // 100 + item % 100 / 60 for item in (lat, lon))
        place = receiver._plane.transform(
            east if east_west == b"E" else -east, north if north_south == b"N" else -north
        )
        if np.allclose(place, fix.position, atol=1e-6):
            hours, rest = divmod(clock, 10_000.0)
            times.append(3600.0 * hours + 60.0 * (rest // 100) + rest % 100)
    return times


def _sentence(rng: random.Random, now: float, said: list[bytes]) -> bytes:
    kind = rng.randrange(10)
    if kind < 4 or not said:
        body = _sound(rng, now)
    elif kind < 6:
        body = _damaged(rng, rng.choice(said))
    elif kind < 8:
        fields = [rng.choice(_PARTS) for _ in range(rng.randrange(20))]
        body = ",".join([f"GP{rng.choice(_KINDS)}", *fields]).encode("latin-1")
    elif kind < 9:
        body = rng.choice(said)
    else:
        return rng.randbytes(rng.randrange(90))
    said.append(body)
    del said[:-50]
    line = _framed(body)
    return _damaged(rng, line) if rng.random() < 0.1 else line


def _sound(rng: random.Random, now: float) -> bytes:
    """Return a sentence as a receiver sends it; in some of them its clock is wrong."""
    utc = now - rng.uniform(0.0, 4.0) if rng.random() < 0.5 else now
    if rng.random() < 0.05:
        utc += rng.uniform(-43000.0, 43000.0)
    time = _clock(utc)
    if rng.random() < 0.3:
        return f"GPGST,{time},0.5,,,,{rng.random():.2f},{rng.random():.2f},0.9".encode()
    return _fix_of(rng, utc)


def _fix_of(rng: random.Random, utc: float) -> bytes:
    time = _clock(utc)
    place = f"48{59.9 * rng.random():07.4f},N,011{59.9 * rng.random():07.4f},E"
    sentence = f"GPGGA,{time},{place},{rng.randrange(9)},08,{rng.random():.1f},545.4,M,46.9,M,,"
    return sentence.encode()


def _clock(utc: float) -> str:
    minutes, second = divmod(utc % 86400.0, 60.0)
    return f"{int(minutes) // 60:02d}{int(minutes) % 60:02d}{min(second, 59.99):05.2f}"


def _framed(body: bytes) -> bytes:
    return b"$%b*%02X" % (body, checksum(body))


def _damaged(rng: random.Random, body: bytes) -> bytes:
    """Bytes flipped, lost or put in; fields lost or doubled."""
    damaged = bytearray(body)
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(len(damaged) + 1)
        match rng.randrange(4):
            case 0 if at < len(damaged):
                damaged[at] ^= 1 << rng.randrange(8)
            case 1:
                del damaged[at : at + rng.randint(1, 5)]
            case 2:
                damaged[at:at] = rng.randbytes(rng.randint(1, 3))
            case _:
                fields = bytes(damaged).split(b",")
                fields[rng.randrange(len(fields))] = rng.choice(_PARTS).encode("latin-1")
                damaged = bytearray(b",".join(fields))
    return bytes(damaged).replace(b"\n", b"").strip()
