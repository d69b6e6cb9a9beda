"""How much the force on a hand grows with its way, and the way that it may go in a period."""

from __future__ import annotations

MIN_STIFFNESS_N_M = 1000.0  # of an arm that holds its joints
MIN_STEP_M = 0.00005  # in a period: by less, the noise of the force hides its growth
FADES = 0.95  # of what was found, a period: a handle in motion resists unevenly
FIRST_PERIODS = 20  # in which the arm bends until the handle moves
SHARE = 0.6  # of the missing force that a step may add
MARGIN_N = 13.0  # below the largest force: a door in motion resists, and then jams within a period


class Stiffness:
    """Estimator of the stiffness of an arm that pulls a handle, used to limit the steps of its command.

    The stiffness is the increase of the force per length of a step.
    """

    def __init__(self, most: float, sudden: float) -> None:
        """Prepare for a pull with forces below `most` in [N], and below `sudden` in [N] if the handle stops
        abruptly.
        """
        self._most, self._sudden = most, sudden
        self._now = self._first = MIN_STIFFNESS_N_M
        self._before: float | None = None
        self._periods = 0

    def add(self, step: float, resistance: float) -> None:
        """Update the estimate of the stiffness; called once a period.

        Args:
            step: last step of the command along the path, in [m].
            resistance: force against the motion after this step, in [N].
        """
        before, self._before = self._before, resistance
        found = 0.0
        if before is not None and step >= MIN_STEP_M:
            found = (resistance - before) / step
        self._now = max(found, FADES * self._now, MIN_STIFFNESS_N_M)
        self._periods += 1
        if self._periods <= FIRST_PERIODS:
            self._first = max(found, self._first)

    def step(self, resistance: float) -> float:
        """Return the step along the path in [m] after which the hand pulls with no more than the allowed
        force.

        It is negative if the hand has to go back.

        Args:
            resistance: present resistance, in [N].
        """
        return SHARE * (self._most - resistance) / self._now

    def sudden_step(self) -> float:
        """Return the longest step of the arm's command, in [m], after which the force stays within its limit,
        even if the handle stops abruptly.
        """
        return (self._sudden - MARGIN_N) / self._first
