"""Random numbers that depend on what they are for, never on how many were drawn before."""

from __future__ import annotations

import hashlib
import zlib
from functools import lru_cache
from typing import Any

import numpy as np

from handcart.backends.description.sensor_table import OLD_KEYS
from handcart.robotics.numerics.arrays import FloatArray

from .split_seed import SplitSeed


def keyed(seed: int, purpose: str, period: int = 0) -> np.random.Generator:
    """Return the generator of one purpose (a sensor, an error) in one period of the run with `seed`.

    Philox is counter based (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", 2011): the
    period is the high word of its counter, so streams of different periods do not overlap. An additional
    reading therefore changes no other draw. The next lower word of the counter separates the branches of a
    `SplitSeed`.
    """
    key = np.array([seed % 2**64, zlib.crc32(purpose.encode())], dtype=np.uint64)
    counter = np.array([0, 0, _branch(seed, purpose, period), period], dtype=np.uint64)
    return np.random.Generator(np.random.Philox(key=key, counter=counter))


def keyed_normal(seed: int, purpose: str, period: int, size: int) -> FloatArray:
    """Return standard normal random numbers (size,) that depend only on the arguments.

    They are the first numbers of the generator that `keyed` returns, computed fast enough for every period.

    Args:
        seed: seed of the run.
        purpose: name of the sensor or error.
        period: number of the period.
        size: how many numbers.
    """
    rng, begun = _stream(int(seed), purpose)
    counter = begun["state"]["counter"]  # of whole numbers: an array's are unpacked twice as slowly
    counter[2], counter[3] = _branch(seed, purpose, period), period
    rng.bit_generator.state = begun
    return rng.standard_normal(size)


def sensor_seed(seed: int, name: str) -> int:
    """Return the seed of the errors of one sensor, by its name in the robot's file.

    A sensor with one of the names in `OLD_KEYS`, such as `camera`, has the run's `seed` itself, so that runs
    of earlier versions are reproduced.
    """
    if name in OLD_KEYS:
        return seed
    other = int.from_bytes(hashlib.blake2b(f"{int(seed)} {name}".encode(), digest_size=7).digest(), "big")
    return seed.named(name, other) if isinstance(seed, SplitSeed) else other


def _branch(seed: int, purpose: str, period: int) -> int:
    return seed.branch(purpose, period) if isinstance(seed, SplitSeed) else 0


@lru_cache(maxsize=64)
def _stream(seed: int, purpose: str) -> tuple[np.random.Generator, dict[str, Any]]:
    """Return a generator, and its state before anything is drawn: setting it is faster than making
    another.
    """
    rng = keyed(seed, purpose)
    begun = dict(rng.bit_generator.state)
    begun["state"] = {name: words.tolist() for name, words in begun["state"].items()}
    begun["buffer"] = begun["buffer"].tolist()
    return rng, begun
