"""Whether what a satellite receiver sends is of now."""

from __future__ import annotations

_DAY = 86400.0  # [s]
_SAME = 1e-3  # [s]: nearer than that it is the same time
_BEARS_OUT = 4  # times that have to follow one that is ahead
_DRIFT = 1e-4  # by which this machine's clock may run slower or faster than UTC


class UtcOrder:
    """Holds times of day against this machine's clock: none counts twice, and none that is old.

    How far the receiver is behind the clock nobody knows; but it isn't further behind than it was, but for
    what clocks drift. Times that are ahead of their turn count when four more bear them out: after a sleep of
    the machine. One that is behind never does: a receiver whose clock is put back is believed when the
    program is begun anew.
    """

    def __init__(self, late: float) -> None:
        """Nothing has come yet; `late` is how much later than usual a time may come, in [s]."""
        self._late = late
        self._last: tuple[float, float] | None = None
        """Of the last that counted: UTC and the clock."""
        self._behind = 0.0
        """The least that UTC was behind the clock."""
        self._ahead: list[tuple[float, float]] = []
        """The last that didn't count because they were ahead, and go on as the clock does."""

    def is_new(self, utc: float, now: float) -> bool:
        """Whether a time of day that has come counts; then it is the last.

        Args:
            utc: in [s].
            now: by this machine's clock, in [s].
        """
        if self._last is None:
            self._take(utc, now, now - utc)
            return True
        last, when = self._last
        expected = now - self._behind
        utc = expected + _wrapped(utc - expected)
        late = expected - utc
        if utc < last + _SAME or late > self._late:
            return False
        if late < -self._late and not self._borne_out(utc, now):
            return False
        self._take(utc, now, now - utc if late < 0.0 else self._behind + min(late, _DRIFT * (now - when)))
        return True

    def _borne_out(self, utc: float, now: float) -> bool:
        before, when = self._ahead[-1] if self._ahead else (utc, now)
        goes_on = utc > before and abs((utc - before) - (now - when)) <= self._late
        self._ahead = [*(self._ahead if goes_on else ()), (utc, now)]
        return len(self._ahead) > _BEARS_OUT

    def _take(self, utc: float, now: float, behind: float) -> None:
        self._last, self._behind, self._ahead = (utc, now), behind, []


def _wrapped(seconds: float) -> float:
    """Within half a day."""
    return (seconds + _DAY / 2) % _DAY - _DAY / 2
