"""Watch over a run's time-out, interrupts and rounds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from datetime import time

from handcart.backends.capabilities.battery import Battery
from handcart.backends.robot.robot import Robot
from handcart.networks.graph.aims import NO_AIMS, Aims, Interrupt
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.journal.retracing import RunPosition

from .day_clock import DayClock, RehearsedDay, after

CHARGE_HYSTERESIS = 2.0
"""Rise of the charge above an interrupt's limit after which the interrupt may come again, in [%]."""
CHARGE_TIMEOUT_S = 300.0
"""Time without a rise of the charge after which a robot no longer waits for it, in [s]."""


class AimWatch:
    """Monitor of times and conditions: the time-out of a round, the begin of the next round, and due
    interrupts.

    A round is one run of a task that repeats; an interrupt is a goal that comes before the task's goal, for
    example while the battery is low. Times are in the robot's time, except times of day, for which there is
    a `DayClock`. No round begins for a time of day that passed during another round, or while no program ran.
    """

    def __init__(
        self,
        robot: Robot,
        aims: Aims,
        began: float,
        handled: Mapping[int, float],
        clock: DayClock,
        waits: bool = False,
        charging: int | None = None,
    ) -> None:
        """Begin to watch.

        Args:
            robot: the robot.
            aims: aims of the network.
            began: when the round began, in [s].
            handled: time of each interrupt's last occurrence, in [s], by its number; missing for one that
                has not occurred: its time counts from `began`.
            clock: clock of the times of day.
            waits: True if the round waits for its time of day.
            charging: number of the interrupt at whose goal the battery is to be charged; None: none.
        """
        self._robot, self._aims, self._clock = robot, aims, clock
        self._is_timed = aims != NO_AIMS
        self._round_began = began
        self._round_due: float | None = None
        if waits and aims.rounds is not None and aims.rounds.at:
            self._wait(aims.rounds.at, clock.now())
        self._times = self._next_times()
        self._handled = {number: handled.get(number, began) for number in range(len(aims.interrupts))}
        self._is_low: dict[int, bool] = {}
        self._charging = None if charging is None else aims.interrupts[charging]
        self._charged, self._rose = -1.0, 0.0
        self._battery: Battery | None = robot.backend.get(Battery)  # type: ignore[type-abstract]

    def begin_round(self, missed: Iterable[int] = ()) -> float:
        """Begin to watch the next round (repetition of the task); return the time at which it may begin, in
        [s] of the robot's time.

        The time-out of the round counts from that time.

        Args:
            missed: numbers of the interrupts whose goals no route led to. For a low battery, they are due
                again.
        """
        for number in missed:
            self._is_low.pop(number, None)
        rounds = self._aims.rounds
        if rounds is not None and rounds.at:
            return self._wait(rounds.at, after(self._clock.now()))
        every = 0.0 if rounds is None else rounds.every_s
        self._round_began = max(self._robot.time, self._round_began + every)
        return self._round_began

    def _wait(self, times: Sequence[time], since: float) -> float:
        """Wait for a time of day; return the robot's time at which it is expected, in [s]."""
        self._round_due = self._clock.next(times, since)
        self._round_began = self._robot.time + max(0.0, self._round_due - self._clock.now())
        return self._round_began

    @property
    def left_s(self) -> float | None:
        """Time left until the time-out of the present round of a repeated task, in [s] of the robot's time.

        None if the task has no time-out.
        """
        limit = self._aims.time_out_s
        if limit is None or self._round_due is not None:
            return limit
        return limit - (self._robot.time - self._round_began)

    @property
    def expected(self) -> tuple[float, str] | None:
        """Expected start of the task's next round, if the task waits for a time of day between rounds;
        otherwise None.

        It is a pair of the expected instant, in [s] of the robot's time, and the time of day "HH:MM:SS".
        """
        if self._round_due is None:
            return None
        return self._round_began, self._clock.time_of_day(self._round_due).isoformat("seconds")

    def is_early(self) -> bool:
        """Return whether the start of the task's next round, computed by `begin_round`, is still in the
        future.
        """
        self._look_at_clock()
        if self._round_due is None:
            return self._robot.time < self._round_began
        if self._clock.now() < self._round_due:
            return True
        self._round_began, self._round_due = self._robot.time, None
        return False

    def waits(self, situation: str) -> bool:
        """Return whether a run waits in a situation for its next round, or for its battery's charge."""
        return self._is_timed and (self.is_early() or self.is_charging(situation))

    def due(self, priority: int | None, situation: str) -> int | None:
        """Return the number of an interrupt (goal to pursue first) whose condition has come true; None if
        there is none.

        An interrupt is returned once each time that its condition comes true, and again if its wait for the
        battery's charge was broken off. Of several interrupts, it is the one of the highest priority.

        Args:
            priority: priority of the interrupt that the run pursues now; only a higher one is returned. None:
                no interrupt is pursued.
            situation: the present situation. While the robot waits there for its battery's charge, only
                interrupts of a higher priority than that of the wait are returned.
        """
        self._look_at_clock()
        charging = self._charging
        if priority is None and charging is not None and situation in charging.goals:
            priority = charging.priority
        numbered = sorted(enumerate(self._aims.interrupts), key=lambda interrupt: -interrupt[1].priority)
        for number, item in numbered:
            above = priority is None or item.priority > priority
            if above and (self._is_due(number, item) or self._was_left(item, situation)):
                self._handled[number] = self._robot.time
                if item.battery_until is not None:
                    self._charging, self._charged = item, -1.0
                return number
        return None

    def _was_left(self, interrupt: Interrupt, situation: str) -> bool:
        """Return whether the robot has left the place where it was charged for an interrupt too early."""
        return interrupt is self._charging and self._charged >= 0.0 and situation not in interrupt.goals

    def is_charging(self, situation: str) -> bool:
        """Return whether the robot has to wait in a situation until its battery is charged.

        It waits at the goal of an interrupt (goal pursued before the task's own) that has a `battery_until`,
        up to that charge. The wait ends early if the charge does not rise for `CHARGE_TIMEOUT_S`, or is not
        known.
        """
        wanted = self._charging
        if wanted is None or wanted.battery_until is None or self._battery is None:
            return False
        if situation not in wanted.goals:
            return False
        charge, now = self._battery.charge_percent(), self._robot.time
        if charge > self._charged:
            self._charged, self._rose = charge, now
        if charge < wanted.battery_until and now - self._rose < CHARGE_TIMEOUT_S:
            return True
        self._charging = None
        return False

    def _is_due(self, number: int, interrupt: Interrupt) -> bool:
        if interrupt.at:
            return self._is_time(number, interrupt.at)
        if interrupt.every_s is not None:
            return self._robot.time - self._handled[number] >= interrupt.every_s
        if self._battery is None or interrupt.battery_below is None:
            return False
        charge, was_low = self._battery.charge_percent(), self._is_low.get(number, False)
        limit = interrupt.battery_below + (CHARGE_HYSTERESIS if was_low else 0.0)
        self._is_low[number] = charge < limit
        return self._is_low[number] and not was_low

    def _next_times(self) -> dict[int, float]:
        """Return the next instant of each interrupt with times of day, by its number."""
        numbered, now = enumerate(self._aims.interrupts), self._clock.now()
        return {number: self._clock.next(item.at, now) for number, item in numbered if item.at}

    def _look_at_clock(self) -> None:
        """Compute the expected times of day again if somebody has set the clock."""
        if not self._clock.was_set():
            return
        self._times = self._next_times()
        rounds = self._aims.rounds
        if self._round_due is not None and rounds is not None:
            self._wait(rounds.at, self._clock.now())

    def _is_time(self, number: int, times: Sequence[time]) -> bool:
        now = self._clock.now()
        if now < self._times[number]:
            return False
        self._times[number] = self._clock.next(times, after(now))
        return True


def aim_watch(
    robot: Robot, network: ActionNetwork, standing: RunPosition | None, clock: DayClock | None
) -> AimWatch:
    """Return the watch over a run's aims; a run that is resumed has used up some of its time."""
    clock = clock or RehearsedDay(robot, network.aims.begins_at or time.min)
    if standing is None:
        return AimWatch(robot, network.aims, robot.time, {}, clock, waits=True)
    shift = robot.time - standing.last_t
    handled = {number: instant + shift for number, instant in standing.interrupted.items()}
    began = standing.round_began + shift
    return AimWatch(robot, network.aims, began, handled, clock, standing.round_waits, standing.charging)
