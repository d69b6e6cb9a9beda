"""Executing a prepared run: the outermost loop, and the run's folder."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import orjson

from handcart.backends.backend import RobotFault
from handcart.backends.recording import Recording
from handcart.backends.robot.robot import Robot
from handcart.files.errors import HandcartError
from handcart.files.whole_file import write_whole
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.coordination.run_life import RunState
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.run_end import RunEnd
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import JournalError
from handcart.networks.journal.syncing import Sync
from handcart.networks.operator.operation import Operation
from handcart.networks.operator.permits import Permits
from handcart.networks.run_files.run_names import FILES_OF_AN_END, SUMMARY_FILE
from handcart.networks.run_files.telemetry import Telemetry
from handcart.networks.task.preparing import Prepared
from handcart.networks.task.preparing import prepare as prepare

from .calibration import keep_calibrated
from .checkpoint import keep_checkpoint
from .day_of_run import day_clock, rehearsed_time
from .evidence_files import EvidenceFiles
from .flight_recorder import FlightRecorder
from .recording_keeper import RecordingKeeper
from .resuming import Past
from .run_header import header, process_facts
from .run_options import RunOptions
from .steady_memory import SteadyMemory


class Executed(NamedTuple):
    """Result of a run that has ended, with its summary."""

    end: RunEnd
    summary: dict[str, Any]
    """Content of the run's `summary.json`."""


class NotKept(HandcartError):
    """Error of a run that has ended, but whose summary or telemetry cannot be written."""

    def __init__(self, run_dir: Path, end: RunEnd, error: OSError) -> None:
        ended = f"{end.outcome} in situation {end.situation}{': ' if end.reason else ''}{end.reason}"
        super().__init__(f"{run_dir} can't be written: {error.strerror}; the run itself ended with {ended}")


def execute(
    prepared: Prepared,
    run_dir: Path,
    options: RunOptions | None = None,
    past: Past | None = None,
    clock: Callable[[], float] = time.monotonic,
) -> Executed:
    """Execute a run until it ends. An interrupt (Ctrl-C) stops the robot, which then holds its position.

    During the run, the operator's commands are received on the socket `control` in `run_dir`. The files
    `journal.jsonl`, `telemetry.npz`, `summary.json` and the pictures and data that primitives keep as
    evidence are written into `run_dir`; after a fault of the program also `error.txt`.

    Args:
        prepared: the prepared task, robot and backend.
        run_dir: the run's folder; made if it is missing.
        options: options of the run; those that concern only the preparation are ignored.
        past: a run to resume; None for a new run.
        clock: clock for the wall time of the run, in [s].

    Raises:
        JournalError: no journal can be created in `run_dir`; nothing has moved.
        NotKept: the run has ended, but its summary or telemetry cannot be written.
    """
    began, options = clock(), options or RunOptions()
    options = replace(options, permits=_permits(prepared, options))
    run_dir.mkdir(parents=True, exist_ok=True)
    telemetry = Telemetry()
    with ExitStack() as whole:
        heard = options.interrupts or whole.enter_context(Interrupts())
        observers = [*_recorders(prepared, run_dir), *options.observers]
        with ExitStack() as stack:
            coordinator = _coordinator(stack, prepared, run_dir, options, past, observers)
            heard.stop_by(lambda: coordinator.request(Request.INTERRUPT))
            permits = _permits(prepared, options)  # those that the coordinator asks
            operation = stack.enter_context(Operation(run_dir, coordinator, permits, prepared.robot))
            for observer in observers:
                observer.begin(prepared, run_dir)
                stack.callback(observer.end)
            end = _guarded(coordinator, prepared.robot, telemetry, run_dir, [*observers, operation])
        figures = {name: value for observer in observers for name, value in observer.figures(end).items()}
        try:
            written = _write(
                run_dir / SUMMARY_FILE, summary(prepared, end, run_dir, clock() - began, figures)
            )
            telemetry.save(run_dir / "telemetry.npz")
        except OSError as error:
            raise NotKept(run_dir, end, error) from None
    return Executed(end, written)


def _permits(prepared: Prepared, options: RunOptions) -> Permits:
    """Return the permissions; by default a simulated robot may do all, a real one nothing with a permit."""
    return options.permits or Permits("always" if prepared.backend.simulated else "never")


def _sync(prepared: Prepared, options: RunOptions) -> Sync:
    """Return how the journal is brought to the disk: by default only that of a real robot is."""
    simulated = prepared.backend.simulated
    if not (options.sync or (options.sync is None and not simulated)):
        return "never"
    return "always" if simulated else "beside"


def _coordinator(
    stack: ExitStack,
    prepared: Prepared,
    run_dir: Path,
    options: RunOptions,
    past: Past | None,
    observers: Sequence[RunObserver],
) -> Coordinator:
    """Return the coordinator with its journal, which is closed with `stack`."""
    sync = _sync(prepared, options)
    return Coordinator(
        prepared.task.network,
        prepared.robot,
        prepared.model,
        stack.enter_context(_journal(prepared, run_dir, options, past)),
        [observer.event for observer in observers],
        _permits(prepared, options),
        standing=past.standing if past else None,
        keep=partial(keep_checkpoint, run_dir, prepared, sync == "always") if options.checkpoints else None,
        clock=day_clock(prepared, options, past),
    )


def _recorders(prepared: Prepared, run_dir: Path) -> Iterator[RunObserver]:
    """Yield the observers of every run, which come before the requested ones."""
    robot = prepared.task.robot, prepared.backend_name
    yield EvidenceFiles(run_dir, partial(keep_calibrated, run_dir, *robot))
    yield FlightRecorder(run_dir, prepared.robot)
    if prepared.backend.recording is not None:
        yield RecordingKeeper(prepared.backend.recording)
    if not prepared.backend.simulated:
        yield SteadyMemory()


def _journal(prepared: Prepared, run_dir: Path, options: RunOptions, past: Past | None) -> Journal:
    """Return a new journal with its header, or the past one with what is known of the crash."""
    path, sync = run_dir / "journal.jsonl", _sync(prepared, options)
    facts = process_facts(_permits(prepared, options).mode)
    if past is None:
        journal = Journal(path, sync)
        begins = rehearsed_time(prepared, options)
        journal.append("RUN", prepared.robot.time, header(prepared, begins), facts)
        return journal
    journal = Journal.go_on(path, past.contents, sync)
    for kind, fields, wall in past.resume_records:
        journal.append(kind, prepared.robot.time, fields, facts if kind == "EPOCH" else wall)
    for name in FILES_OF_AN_END:
        with suppress(OSError):
            (run_dir / name).unlink()  # of an earlier end, which no longer is the run's
    return journal


def step_until_end(
    coordinator: Coordinator, robot: Robot, telemetry: Telemetry, observers: Sequence[RunObserver] = ()
) -> RunEnd:
    """Run the coordinator and the robot in turn, a control period each, and return the run's end.

    Args:
        coordinator: coordinator of the run.
        robot: the robot, which is also stepped during a pause.
        telemetry: recorder of the robot's poses, except during a pause.
        observers: notified after each period.
    """
    run = coordinator.run()
    while True:
        try:
            next(run)
        except StopIteration as end:
            ended: RunEnd = end.value
            return ended
        paused = coordinator.life.paused
        robot.step(paused)
        if not paused:
            restoring = coordinator.life.state is RunState.RESTORING
            telemetry.record(robot, coordinator.running, restoring)
        for observer in observers:
            observer.period(robot)


def summary(
    prepared: Prepared, end: RunEnd, run_dir: Path, wall_time_s: float, metrics: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the content of a run's `summary.json`: outcome, situation, reason, counts, times and metrics.

    `wall_time_s` is the duration of the run by the wall clock, in [s].
    """
    return {
        "outcome": end.outcome,
        "situation": end.situation,
        "reason": end.reason,
        "actions": end.actions,
        "fails": end.fails,
        "replans": end.replans,
        "cause": end.cause,
        "skipped": list(end.skipped),
        **({"otherwise": end.otherwise or None} if prepared.task.network.otherwise else {}),
        **({"rounds": end.rounds} if prepared.task.network.aims.rounds else {}),
        "sim_time_s": round(prepared.robot.time, 3),
        "wall_time_s": round(wall_time_s, 3),
        "seed": prepared.seed,
        "backend": prepared.backend_name,
        "run_dir": str(run_dir),
        **prepared.backend.figures(),
        **_lost(prepared.backend.recording),
        "metrics": dict(metrics),
    }


def _lost(recording: Recording | None) -> dict[str, str]:
    """Return why the traffic with the robot was not kept completely; empty if it was."""
    return {} if recording is None or recording.lost is None else {"recording_lost": recording.lost}


def _guarded(
    coordinator: Coordinator,
    robot: Robot,
    telemetry: Telemetry,
    run_dir: Path,
    observers: Sequence[RunObserver],
) -> RunEnd:
    try:
        return step_until_end(coordinator, robot, telemetry, observers)
    except Exception as error:
        robot.stop()
        known = isinstance(error, HandcartError)
        if not isinstance(error, JournalError):
            with suppress(OSError):  # a disk that takes no more doesn't keep the run from ending (row D6)
                write_whole(run_dir / "error.txt", traceback.format_exc())
        reason = str(error) if known else f"{type(error).__name__}: {error}"
        return coordinator.broken_off(reason, "GiveUp" if isinstance(error, RobotFault) else "Error")


def _write(path: Path, content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content as a reader of the file gets it: NumPy's numbers and tuples become plain."""
    options = orjson.OPT_INDENT_2 | orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_APPEND_NEWLINE
    written = orjson.dumps(content, option=options)
    write_whole(path, written)
    plain: dict[str, Any] = orjson.loads(written)
    return plain
