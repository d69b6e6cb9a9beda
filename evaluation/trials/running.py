"""Execution of one run of a task, with its metrics, in a folder of its own."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from handcart.evaluation.judging.judge import Judge
from handcart.evaluation.offline_localization.drive_recorder import DriveRecorder
from handcart.evaluation.sensor_replay.sensor_recorder import SensorRecorder
from handcart.files.errors import HandcartError, InputError
from handcart.files.printable import printable
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.journal.retracing import NeedsOperator
from handcart.networks.run_files.run_names import name_of, point_latest
from handcart.networks.runs.day_of_run import check_begins_at
from handcart.networks.runs.resuming import NothingToResume as NothingToResume
from handcart.networks.runs.resuming import Past, read_past, task_of
from handcart.networks.runs.robot_claim import claimed
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_header import boot_id, robot_fingerprint
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.runs.state_check import check_state, gone_on, standing_as_left
from handcart.networks.task.preparing import Prepared, beginning_at, make_robot, prepare
from handcart.networks.task.task_file import load_task


class NoFolder(HandcartError):
    """Error for a run whose folder cannot be created; raised before the robot moves."""


class FaultsNotSimulated(InputError):
    """Error for faults that are to be injected on a robot that is not simulated; raised before it moves."""

    def __init__(self, backend: str) -> None:
        super().__init__(f"faults on purpose on the backend {backend!r}; allowed: a simulated one")


def run_task(task: Path, runs: Path, options: RunOptions | None = None) -> tuple[dict[str, Any], int]:
    """Run a task once.

    Args:
        task: the task's file.
        runs: folder in which the run's folder is created.
        options: options of the run.

    Returns:
        The summary, which is also written to the run's folder, and the exit status.

    Raises:
        FileError: the task or a file that it names has a fault; nothing has moved.
        NoBench: the robot's drives cannot be simulated.
        NoWindow: the run cannot be shown.
        NoVideo: the run cannot be recorded.
        NeedsOperator: the last run of a real robot waits for a person.
        FaultsNotSimulated: faults are requested for a real robot.
        RobotBusy: the robot is in another run.
    """
    options = options or RunOptions()
    with ExitStack() as stack:
        heard = options.interrupts or stack.enter_context(Interrupts())
        prepared = stack.enter_context(_prepared(task, options))
        recorder = prepared.backend if isinstance(prepared.backend, SensorRecorder) else None
        claim = stack.enter_context(claimed(prepared.backend))
        observers = list(options.observers)
        if options.video is not None:
            from .video import Video

            video = stack.enter_context(Video(options.video, prepared.robot))
            for words in video.remarks():
                _say(options.observers, words)
            observers.append(video)
        folder = new_folder(runs, name_of(task, options.seed))
        point_latest(folder)
        if recorder is not None:
            recorder.open(folder)
        judge = Judge(prepared, folder)
        if claim is not None:
            claim.begin(folder)
        chosen = replace(options, observers=(judge, *_recorders(options), *observers), interrupts=heard)
        ran = execute(prepared, folder, chosen)
        _write_up(prepared, folder, judge, options)
    return ran.summary, ran.end.exit_status


def _recorders(options: RunOptions) -> Iterator[RunObserver]:
    yield DriveRecorder()
    if options.playback:
        from handcart.evaluation.viewing.playback.recorder import PlaybackRecorder

        yield PlaybackRecorder()


def _prepared(task: Path, options: RunOptions) -> Prepared:
    prepared = prepare(
        task,
        options.backend,
        options.settings,
        options.seed,
        window=options.window,
        situation=options.situation,
        errors=options.errors,
        bench=options.bench,
    )
    try:
        check_begins_at(prepared, options)
    except InputError:
        prepared.backend.close()
        raise
    if options.around is None and not options.record_sensors:
        return prepared
    if options.around is not None and not prepared.backend.simulated:
        prepared.backend.close()
        raise FaultsNotSimulated(prepared.backend_name)
    backend = prepared.backend if options.around is None else options.around(prepared.backend)
    backend = SensorRecorder(backend) if options.record_sensors else backend
    robot = make_robot(prepared.task, backend, prepared.robot.spec, prepared.model)
    return replace(prepared, backend=backend, robot=robot)


def _write_up(prepared: Prepared, folder: Path, judge: Judge, options: RunOptions) -> None:
    """Write reports, pictures and page of a run; a failed write is reported and does not change the
    outcome.
    """

    def drawn() -> None:
        from .overview import draw_overview

        model, radius = prepared.model, prepared.robot.spec.footprint_radius_m
        draw_overview(folder, model.map, model.places, radius, judge.surveys.shown)

    def page() -> None:
        from handcart.evaluation.viewing.report.report import write_report

        write_report(folder)

    steps: list[tuple[bool, str, Callable[[], object]]] = [
        (True, "no report of the surveys is whole", lambda: judge.surveys.report(prepared, folder)),
        (options.draw, "the surveys' pictures are missing", lambda: judge.surveys.draw(folder)),
        (options.draw, "there is no overview.svg", drawn),
        (options.report, "there is no report.html", page),
    ]
    for wanted, missing, write in steps:
        try:
            if wanted:
                write()
        except Exception as error:
            reason = error.strerror if isinstance(error, OSError) else error
            _say(options.observers, f"{folder} can't be written: {reason}; {missing}")


def _say(observers: Sequence[RunObserver], words: str) -> None:
    for observer in observers:
        observer.say(words)


def resume_task(
    folder: Path, confirm: int | None, options: RunOptions | None = None, seed: int | None = None
) -> tuple[dict[str, Any], int]:
    """Continue a run that was interrupted; a simulated world is restored from its last checkpoint.

    Args:
        folder: the run's folder.
        confirm: number of the journal's last record, as a person has seen it; required where a real
            robot moves.
        options: options of the continuation. Only `permits`, `interrupts`, `sync`, `draw`, `report`,
            `playback` and `observers` are used; the other options are read from the run's journal.
        seed: seed of random numbers from now on; None: the run's original seed.

    Returns:
        The summary, which is also written to the run's folder, and the exit status.

    Raises:
        NoRun: the folder is not a run's folder.
        JournalError: the journal cannot be read, or is damaged inside.
        NotAState: the checkpoint or the judge's notes are damaged, or belong to another run.
        RunAlive: the run is still going.
        NothingToResume: the run has ended.
        NeedsOperator: a person has to decide something first.
        FileError: the task, or a file that it names, now has a fault.
    """
    options = options or RunOptions()
    observers = options.observers
    header, made = prepare_again(folder, seed)
    with ExitStack() as stack:
        heard = options.interrupts or stack.enter_context(Interrupts())
        prepared = stack.enter_context(made)
        claim = stack.enter_context(claimed(prepared.backend, folder))
        past = put_back(folder, header, prepared, observers)
        if not prepared.backend.simulated:
            prepared = standing_as_left(prepared, past)
            check = check_state(prepared.robot, past)
            for words in (*check.words(), past.next_words()):
                _say(observers, words)
            past = gone_on(past, check, confirm)
        judge = Judge(prepared, folder)
        judge.go_on()
        if claim is not None:
            claim.begin(folder)
        heard_by = (judge, *_recorders(options), *observers)
        chosen = replace(options, observers=heard_by, interrupts=heard, checkpoints=True)
        ran = execute(prepared, folder, chosen, past)
        _write_up(prepared, folder, judge, options)
    return ran.summary, ran.end.exit_status


def prepare_again(folder: Path, seed: int | None = None) -> tuple[Mapping[str, Any], Prepared]:
    """Return the journal header of an interrupted run, and its task prepared as at its start.

    The journal is read first, so that no robot is switched on for a run that cannot be continued. `seed`
    replaces the run's original seed. Raises the errors of `task_of` for a folder or a journal that cannot be
    used, and `FileError` for a task's file with faults.
    """
    header = task_of(folder)
    task_path = Path(header["task_path"])
    network = load_task(task_path, header["settings"]).network
    begun = None if header["start"] == network.start else header["start"]
    read_past(folder, network if begun is None else beginning_at(network, begun))
    prepared = prepare(
        task_path,
        header["backend"],
        header["settings"],
        header["seed"] if seed is None else seed,
        situation=begun,
        errors=header["errors"],
        bench=header["bench"],
        resumed=True,
    )
    return header, prepared


def put_back(
    folder: Path, header: Mapping[str, Any], prepared: Prepared, observers: Sequence[RunObserver] = ()
) -> Past:
    """Restore an interrupted run: the simulated world from its checkpoint, and the robot's knowledge.

    For a real robot only the knowledge is restored.

    Args:
        folder: the run's folder.
        header: header of the run's journal.
        prepared: the run, prepared from the files that the header names.
        observers: observers of the run, which receive messages about the restored state.

    Raises:
        NoRun, JournalError: the journal is missing or damaged.
        NotAState: the checkpoint is damaged.
        NeedsOperator: journal, checkpoint and files do not belong together, or a GiveUp was not
            acknowledged.
    """
    past = read_past(folder, prepared.task.network)
    if header["robot_sha256"] != robot_fingerprint(prepared.robot.spec):
        words = f"the robot is not the one that was run: the file {header['robot']} has changed"
        raise NeedsOperator(printable(words))
    past.check_robot(prepared.robot)
    for words in past.words(time.time(), boot_id()):
        _say(observers, words)
    if past.checkpoint is not None:
        past.checkpoint.put_back(prepared)
    if prepared.backend.simulated:
        _check_world(past, observers)
    return past


def _check_world(past: Past, observers: Sequence[RunObserver]) -> None:
    """Raise NeedsOperator if a simulated world could not be restored to the point of continuation (R10)."""
    for words in past.doubts():
        _say(observers, f"unknown: {words}")
    _say(observers, past.next_words())
    if past.standing.done and past.checkpoint is None:
        raise NeedsOperator(f"{past.folder} holds no checkpoint of the simulated world")


def new_folder(runs: Path, name: str) -> Path:
    """Create a folder with the first free name of NAME, NAME.2, NAME.3 ...

    Raises:
        NoFolder: the folder cannot be created, or its name is not valid text.
    """
    number, folder = 1, runs / name
    try:
        str(folder.absolute()).encode()
        runs.mkdir(parents=True, exist_ok=True)
        while True:
            try:
                folder.mkdir()
                return folder
            except FileExistsError:
                number += 1
                folder = runs / f"{name}.{number}"
    except UnicodeEncodeError:
        shown = str(folder.absolute()).encode(errors="backslashreplace").decode()
        raise NoFolder(f"the name of {shown} is not UTF-8; allowed: a folder whose name is") from None
    except OSError as error:
        raise NoFolder(f"no folder can be made in {runs}: {error.strerror}") from None
