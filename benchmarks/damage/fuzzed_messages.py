"""Faulty and malicious messages to a run's operator line."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

import orjson

_WORDS = ("status", "permit", "refuse", "continue", "pause", "restore", "Status", "halt", "", "do")
_KEYS = ("do", "action", "Do", "dо", "", "\u202e", "x" * 300)
_RAW = (
    b"",
    b" ",
    b"{",
    b'{"do"',
    b'{"do":"status"',
    b"{}",
    b"[]",
    b'"status"',
    b"NaN",
    b"-",
    b"1e999",
    b"\xff\xfe\x00",
    b'{"do":"\xed\xa0\x80"}',
    b'{"do":"\\ud800"}',
    b'{"do":"status","do":["x"]}',
    b"GET / HTTP/1.1\r",
    b"\x00" * 100,
)


def fuzzed_messages(count: int, seed: int) -> Iterator[bytes]:
    """Lines without their ends: JSON of all types, huge, deep, binary, cut; none of them ends a run."""
    rng = random.Random(seed)
    kinds = (_typed, _typed, _object, _object, _raw, _deep, _huge, _binary, _cut)
    for _ in range(count):
        yield rng.choice(kinds)(rng).replace(b"\n", b"")


def _value(rng: random.Random, depth: int = 0) -> Any:
    plain = (None, True, False, 0, 1, -1, 2**63, -(2**63), 0.5, -1e308, "", "stop\x00", "é\u2028", *_WORDS)
    if depth < 3 and rng.random() < 0.4:
        inner = [_value(rng, depth + 1) for _ in range(rng.randrange(4))]
        return inner if rng.random() < 0.5 else {rng.choice(_KEYS): item for item in inner}
    return rng.choice(plain)


def _typed(rng: random.Random) -> bytes:
    return orjson.dumps({"do": _value(rng)})


def _object(rng: random.Random) -> bytes:
    return orjson.dumps({rng.choice(_KEYS): _value(rng) for _ in range(rng.randrange(1, 5))})


def _raw(rng: random.Random) -> bytes:
    return rng.choice(_RAW)


def _deep(rng: random.Random) -> bytes:
    depth = rng.choice((10, 500, 1024, 2000))
    return b'{"do":' + b"[" * depth + b"]" * depth + b"}"


def _huge(rng: random.Random) -> bytes:
    size = rng.choice((4000, 4095, 4096, 4097, 20_000, 300_000))
    return b'{"do":"' + b"s" * size + b'"}' if rng.random() < 0.5 else b"9" * size


def _binary(rng: random.Random) -> bytes:
    return rng.randbytes(rng.randrange(1, 300))


def _cut(rng: random.Random) -> bytes:
    whole = _object(rng)
    return whole[: rng.randrange(len(whole))]
