"""Numbers as sensors send them."""

from __future__ import annotations

import math
import re

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


def strict_number(text: str) -> float:
    """Parse a finite decimal number, more strictly than `float`.

    Python's `float` also accepts `1_0`, ` 7`, `nan` and digits of other scripts.

    Raises:
        ValueError: the text is not a finite decimal number in ASCII digits.
    """
    if not _NUMBER.fullmatch(text):
        raise ValueError(f"{text!r} is no number")
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text!r} is too large")
    return value
