"""Random numbers that depend on what they are for, never on how many were drawn before."""

from __future__ import annotations

import zlib

import numpy as np


def keyed(seed: int, purpose: str, period: int = 0) -> np.random.Generator:
    """The generator of one purpose (a sensor, an error) in one period of the run with `seed`.

    Philox is counter based (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", 2011): the period
    is the high word of its counter, so streams of different periods don't overlap. A further reading
    thereby changes nothing that is drawn elsewhere.
    """
    key = np.array([seed % 2**64, zlib.crc32(purpose.encode())], dtype=np.uint64)
    counter = np.array([0, 0, 0, period], dtype=np.uint64)
    return np.random.Generator(np.random.Philox(key=key, counter=counter))
