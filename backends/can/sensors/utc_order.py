"""Test whether a satellite receiver's sentences are current."""

from __future__ import annotations

from collections import deque

_DAY = 86400.0  # [s]
_SAME = 1e-3  # [s]: nearer than that it is the same time
_BEARS_OUT = 4  # times that have to follow one that is ahead
_DRIFT = 1e-4  # by which this machine's clock may run slower or faster than UTC


class UtcOrder:
    """Filter that rejects repeated and old times of day of a satellite receiver, by this machine's clock.

    The delay between receiver and clock is unknown, but it grows by no more than the clocks' drift. A time of
    day that is ahead of what this clock and the delay allow is accepted only after four more times confirm
    it, as after a sleep of the machine. A time of day that is too far behind is never accepted: if a
    receiver's clock was set back, the program has to be restarted.
    """

    def __init__(self, late: float) -> None:
        """Begin without a time.

        Args:
            late: how much later than usual a time may arrive, in [s]; one that is earlier by more has to be
                confirmed.
        """
        self._late = late
        self._last: tuple[float, float] | None = None
        """Time of day and time of this machine's clock of the last reading that counted, in [s]."""
        self._behind = 0.0
        """Least delay of the time of day behind this machine's clock, in [s]."""
        self._sooner: deque[float] = deque(maxlen=_BEARS_OUT + 1)
        """Time by which each of the last counted times arrived earlier than the delay allows, in [s]."""
        self._ahead: list[tuple[float, float]] = []
        """Last times that did not count because they were early, but advance with the machine's clock."""

    def is_new(self, utc: float, now: float) -> bool:
        """Return True if a received time of day is new; if so, it becomes the reference for the times after
        it.

        Args:
            utc: received time of day, in [s].
            now: time of this machine's clock [s].
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
        """Reduce the least known delay by the smallest lead of the last sentences, once enough of them came
        early.

        A single early sentence may be wrong.

        Args:
            by: time by which this sentence came earlier than the least delay, in [s]; negative if later.
        """
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
    """Return a difference of times of day, wrapped to half a day either way, in [s]."""
    return (seconds + _DAY / 2) % _DAY - _DAY / 2
