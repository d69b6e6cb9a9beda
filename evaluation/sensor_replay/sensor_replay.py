"""Replay of a run on its recorded readings, which gives the recorded commands to the last bit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import backend_class
from handcart.files.errors import InputError
from handcart.files.printable import printable
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.day_clock import RehearsedDay
from handcart.networks.events.events import Ended, Event
from handcart.networks.operator.permits import Permits
from handcart.networks.past_runs.past_run import PastRun
from handcart.networks.runs.day_of_run import began_at
from handcart.networks.runs.run_header import robot_fingerprint
from handcart.networks.task.preparing import beginning_at, load_model, make_robot
from handcart.networks.task.task_file import Task, load_task
from handcart.primitives.outcomes.outcome import Success

from .replay_backend import Parted, ReplayBackend

REPLAY_KEYS = ("task_path", "settings", "start", "robot_sha256", "network", "backend", "errors")
"""Fields of a journal's header that a replay needs."""


class ChangedFiles(InputError):
    """Error for a run that cannot be replayed because its task's or robot's files were changed after it."""

    def __init__(self, run: PastRun, what: str) -> None:
        allowed = "allowed: the files as they were; `handcart replay` without --sensors needs none"
        super().__init__(printable(f"{run.folder}: {what}; {allowed}"))


@dataclass(frozen=True)
class SensorReplay:
    """Result of running the robot program again on a run's recorded readings, with its first difference from
    the run.
    """

    periods: int
    commands: int
    """Number of commands that equal the recorded ones, to the last bit."""
    readings: int
    """Number of readings that the program requested."""
    actions: int
    """Number of actions that ended as in the run."""
    difference: str
    """First difference in words, with its time and action; empty if the replay is equal."""


def replay_sensors(run: PastRun) -> SensorReplay:
    """Run the installed program again on the recorded sensor readings of a run, and compare both runs.

    Raises:
        NoRecording: the run has no recorded readings.
        ChangedFiles: the task's or the robot's file has changed since the run.
        FileError: a file of the task cannot be read.
    """
    backend = ReplayBackend(run.folder)
    task, errors = _task(run), bool(run.header["errors"])
    spec = load_robot(task.robot, backend_class(str(run.header["backend"])).has_drives)
    spec = spec if errors else spec.without_errors()
    if robot_fingerprint(spec) != run.header["robot_sha256"]:
        raise ChangedFiles(run, f"the robot's file {task.robot} has changed since")
    model, _ = load_model(task)
    ended: list[Ended] = []

    def hear(event: Event) -> None:
        if isinstance(event, Ended):
            ended.append(event)

    coordinator = None
    try:
        robot = make_robot(task, backend, spec, model)
        clock = RehearsedDay(robot, began_at(run.header))
        permits = Permits("always")
        coordinator = Coordinator(task.network, robot, model, None, [hear], permits, clock=clock)
        for _ in coordinator.run():
            robot.step()
        backend.check_at_end()
    except Parted as parted:
        started = coordinator.running if coordinator else 0
        doing = f", action {started}" if started > len(ended) else ""
        where = f"{backend.periods * backend.period:.3f} s (period {backend.periods})"
        return _result(backend, run, ended, f"at {where}{doing}: {parted}")
    return _result(backend, run, ended, "")


def _task(run: PastRun) -> Task:
    header = run.header
    if lacking := [key for key in REPLAY_KEYS if key not in header]:
        raise ChangedFiles(run, f"its journal does not name {', '.join(lacking)}")
    task = load_task(Path(header["task_path"]), header["settings"])
    if header["start"] != task.network.start:
        task = replace(task, network=beginning_at(task.network, str(header["start"])))
    if task.network.fingerprint() != header["network"]:
        raise ChangedFiles(run, f"the action network of {header['task_path']} has changed since")
    return task


def _result(backend: ReplayBackend, run: PastRun, ended: list[Ended], difference: str) -> SensorReplay:
    """Return the result; without a difference of commands, outcomes are compared."""
    same = 0
    for event, action in zip(ended, run.actions, strict=False):
        reason = "" if isinstance(event.outcome, Success) else event.outcome.reason
        now = event.action.index, type(event.outcome).__name__, reason
        if now != (action.index, action.outcome, action.reason):
            difference = difference or (
                f"action {action.number}, {action.do}, ends in {now[1]} {reason}".rstrip()
                + f"; the run: {action.outcome} {action.reason}".rstrip()
            )
            break
        same += 1
    counts = backend.periods, backend.commands, backend.readings
    return SensorReplay(*counts, same, difference)
