"""Whether what a satellite receiver sends is of now."""

from __future__ import annotations

from collections import deque

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
        """How much UTC is behind the clock, if a time comes as soon as it ever does."""
        self._sooner: deque[float] = deque(maxlen=_BEARS_OUT + 1)
        """Of the last that counted: how much sooner than that they came, in [s]."""
        self._ahead: list[tuple[float, float]] = []
        """The last that didn't count because they were ahead, and go on as the clock does."""

    def is_new(self, utc: float, now: float) -> bool:
        """Whether a time of day that has come counts; then it is the last.

        Args:
            utc: in [s].
            now: by this machine's clock, in [s].
        """
        if self._last is None:
            self._begin(utc, now)
            return True
        last, when = self._last
        expected = now - self._behind
        utc = expected + _wrapped(utc - expected)
        late = expected - utc
        if utc < last + _SAME or late > self._late:
            return False
        if late < -self._late:
            if self._borne_out(utc, now):
                self._begin(utc, now)
                return True
            return False
        self._last, self._ahead = (utc, now), []
        self._behind += max(0.0, min(late, _DRIFT * (now - when)))
        self._come_sooner(-late)
        return True

    def _come_sooner(self, by: float) -> None:
        """What all of the last came sooner they may not come later any more: one alone may be wrong."""
        self._sooner.append(by)
        least = min(self._sooner)
        if len(self._sooner) > _BEARS_OUT and least > 0.0:
            self._behind -= least
            self._sooner.clear()

    def _borne_out(self, utc: float, now: float) -> bool:
        before, when = self._ahead[-1] if self._ahead else (utc, now)
        goes_on = utc > before and abs((utc - before) - (now - when)) <= self._late
        self._ahead = [*(self._ahead if goes_on else ()), (utc, now)]
        return len(self._ahead) > _BEARS_OUT

    def _begin(self, utc: float, now: float) -> None:
        self._last, self._behind, self._ahead = (utc, now), now - utc, []
        self._sooner.clear()


def _wrapped(seconds: float) -> float:
    """Within half a day."""
    return (seconds + _DAY / 2) % _DAY - _DAY / 2
