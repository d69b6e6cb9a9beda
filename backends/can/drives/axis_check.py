"""Check that a drive follows its commands."""

from __future__ import annotations

import math
from collections import deque

from handcart.backends.can.bus.errors import DriveNotReady, LostAnswers, OffDemand, SilentDrive
from handcart.backends.can.bus.pdo_layout import Pdo

from .axis import ENABLED, Axis

STATUS_TIMEOUT_S = 0.1
"""Maximum age of a statusword, in [s]; two periods if those are longer."""
_NAMES = {
    0x6041: "statusword",
    0x6064: "position",
    0x606C: "velocity",
    0x6077: "torque",
    0x603F: "error code",
}
_KEPT, _LOST = 100, 5  # answers to so many SYNCs are looked back on, of which so many may be lost
_IGNORED = 3  # set-points in a row that a drive may not take
_ODD = 2  # positions in a row that can't be
_LOOKS_BACK = 0.5  # [s] in which a wheel has to roll as it should
_EXPLAINS = 0.5  # of a deviation
_LATE_PERIODS = 2.0  # that a command may take to act


class AxisCheck:
    """Monitor that checks after each SYNC that an axis' drive answers, is enabled, and moves as commanded."""

    def __init__(self, axis: Axis) -> None:
        """Begin with a drive that has just been enabled."""
        self._axis, self._period = axis, axis.period
        self._missed: deque[bool] = deque(maxlen=_KEPT)
        self._off_for = 0.0
        self._rolled, self._due = axis.travel, 0.0
        self._drift: deque[float] = deque(maxlen=max(1, round(_LOOKS_BACK / axis.period)))
        """Travel of a wheel less its expected travel, in [m], for each of the last periods."""
        self._contradictions: deque[float] = deque([axis.contradiction], maxlen=self._drift.maxlen)
        """The axis' `contradiction` in the last periods, in [m] or [rad]."""

    def check(self) -> None:
        """Check the axis after a period.

        Raises:
            SilentDrive: the drive has not answered for 0.1 s, or for two periods if two periods are longer.
            LostAnswers: more than 5 of the drive's last 100 answers were lost.
            DriveNotReady: the drive is not in OPERATION ENABLED, or not in its mode of operation.
            OffDemand: the drive does not follow its commands.
        """
        axis = self._axis
        axis.advance()
        self._due += axis.expected.way
        self._missed.append(not axis.answered)
        self._check_answers()
        if not axis.answered:
            return
        state, mode = axis.drive_state, axis.mode_display
        if mode != axis.mode:
            state = f"{state}, in the mode {mode} (6061h), not {axis.mode}"
        if state != ENABLED:
            raise DriveNotReady(axis.name, state, axis.fault)
        if axis.odd >= _ODD:
            raise OffDemand(axis.name, f"its position (6064h) jumps {axis.jump}")
        if axis.ignored >= _IGNORED:
            raise OffDemand(axis.name, f"{axis.ignored} set-points in a row were not taken")
        self._check_motion()

    def _check_answers(self) -> None:
        axis = self._axis
        age = axis.unanswered * self._period
        if age >= max(STATUS_TIMEOUT_S, 2 * self._period) - 1e-9:
            missing = " and no ".join(_names(pdo) for pdo in axis.missing)
            raise SilentDrive(axis.name, missing, age if axis.ever_answered else None)
        lost = sum(self._missed)
        if lost > _LOST:
            raise LostAnswers(axis.name, lost, len(self._missed), f"{_LOST} of {_KEPT}")

    def _check_motion(self) -> None:
        axis = self._axis
        self._contradictions.append(axis.contradiction)
        window = axis.limits.window + _LATE_PERIODS * self._period * abs(axis.expected.speed)
        if axis.positioned:
            off = abs(axis.position - axis.expected.position)
            self._off_for = self._off_for + self._period if off > window else 0.0
        else:
            self._drift.append(axis.travel - self._rolled - self._due)
            self._rolled, self._due = axis.travel, 0.0
            off = abs(sum(self._drift))
            self._off_for = math.inf if off > window else 0.0
        if 1e3 * self._off_for > axis.spec.following_ms - 1e-6:
            deviation = f"it is {off:.3g} away from where it should be"
            raise OffDemand(
                axis.name, f"{deviation}; allowed: {window:.3g} (in m or rad){self._contradiction(off)}"
            )

    def _contradiction(self, off: float) -> str:
        """Return, as text, by how much the drive's position and its velocity contradict each other.

        Args:
            off: size of the axis' deviation from its expected motion, in [m] or [rad].

        Returns:
            The text; "" if the contradiction is too small to explain the deviation.
        """
        between = max(self._contradictions) - min(self._contradictions)
        if between < _EXPLAINS * off:
            return ""
        what = f"its position (6064h) and its velocity (606Ch) differ by {between:.3g}"
        return f"; {what}: does its encoder wrap, or does counts_per_rev differ from the drive's?"


def _names(pdo: Pdo) -> str:
    """Return the names of a PDO's readings, such as "statusword and position (6041h, 6064h)"."""
    indices = [index for index in pdo.objects if index in _NAMES]
    *first, last = (_NAMES[index] for index in indices)
    names = f"{', '.join(first)} and {last}" if first else last
    return f"{names} ({', '.join(f'{index:04X}h' for index in indices)})"
