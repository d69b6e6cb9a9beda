"""The clock of a run's times of day."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, time
from typing import Any

from handcart.files.errors import InputError
from handcart.networks.coordination.day_clock import DayClock, LocalDay, RehearsedDay
from handcart.networks.task.preparing import Prepared

from .resuming import Past
from .run_options import RunOptions


class NoRehearsedDay(InputError):
    """Error, because the begin of a run is given as a time of day, which the run does not use.

    The run's robot is real, or its task has no times of day for rounds and interrupts.
    """


def check_begins_at(prepared: Prepared, options: RunOptions) -> None:
    """Check whether the option that a simulated run begins at a certain time of day is allowed.

    Raises:
        NoRehearsedDay: the option is given although the robot is real, or the task has no times of day.
    """
    if options.begins_at is None:
        return
    if not prepared.backend.simulated:
        wrong = f"a time of day for the backend {prepared.backend_name!r}"
        raise NoRehearsedDay(f"{wrong}, whose robot lives by this machine's clock; allowed: a simulated one")
    if prepared.task.network.aims.begins_at is None:
        wrong = "a time of day for a task whose rounds and interrupts have none"
        raise NoRehearsedDay(f"{wrong}; allowed: a task with `at`, in `rounds` or `interrupts`")


def rehearsed_time(prepared: Prepared, options: RunOptions) -> time | None:
    """Return the time of day at which a simulated run begins, from the run's options or the task's file.

    It is None if the robot is real, or if the task has no times of day for rounds or interrupts.
    """
    first = prepared.task.network.aims.begins_at
    if first is None or not prepared.backend.simulated:
        return None
    return options.begins_at or first


def day_clock(prepared: Prepared, options: RunOptions, past: Past | None) -> DayClock:
    """Return the clock for times of day of a run.

    It is this computer's clock for a real robot, and the robot's time for a simulated one. A simulated run
    that is resumed keeps the time of day at which it began.
    """
    if not prepared.backend.simulated:
        return LocalDay()
    begins = rehearsed_time(prepared, options) if past is None else rehearsed_of(past.contents.records[0])
    return RehearsedDay(prepared.robot, begins or time.min)


def began_at(header: Mapping[str, Any]) -> time:
    """Return the time of day at which a past run began.

    If a simulated run uses times of day, this is the time chosen for it. Otherwise it is the time of the wall
    clock, in this computer's time zone.

    Args:
        header: first record of the run's journal.
    """
    kept = rehearsed_of(header)
    if kept is not None:
        return kept
    unix_s = header.get("wall", {}).get("unix_s")
    return time.min if unix_s is None else datetime.fromtimestamp(float(unix_s)).time()


def rehearsed_of(header: Mapping[str, Any]) -> time | None:
    """Return the time of day chosen for the begin of a past simulated run; None if none was chosen."""
    kept = header.get("begins_at")
    return None if kept is None else time.fromisoformat(str(kept))
