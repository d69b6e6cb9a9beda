"""Rate at which a bench makes its periods, on a machine that may be too slow."""

from __future__ import annotations

WINDOW_S = 5.0  # over which the rate is measured
MIN_RATE_SHARE = 0.8  # of the wanted rate, below which a warning is due


class BenchRate:
    """Rate of a bench's periods, which says once that the machine is too slow for it."""

    def __init__(self, period_s: float) -> None:
        """Begin without a period; `period_s` is its duration in [s]."""
        self._period_s, self._begun, self._count = period_s, -1.0, 0
        self._is_said = False

    def note(self, now: float) -> str:
        """Note the end of a period at a time in [s]; return a warning, "" if there is nothing to say."""
        if self._begun < 0.0:
            self._begun = now
            return ""
        self._count += 1
        if now - self._begun < WINDOW_S:
            return ""
        rate, wanted = self._count / (now - self._begun), 1.0 / self._period_s
        self._begun, self._count = now, 0
        if self._is_said or rate >= MIN_RATE_SHARE * wanted:
            return ""
        self._is_said = True
        return (
            f"warning: the bench makes {rate:.1f} periods a second; needed: {wanted:g}. This machine is too"
            " slow or too busy for it, and a program may call its topics late"
        )
