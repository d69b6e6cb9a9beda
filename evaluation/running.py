"""Running a task once, with its metrics, into a folder of its own."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Protocol

import orjson

from handcart.backends.robot import Robot
from handcart.files.errors import HandcartError
from handcart.files.printable import printable
from handcart.networks.events import Event, Observer
from handcart.networks.interrupts import Interrupts
from handcart.networks.permits import Permits
from handcart.networks.preparing import Prepared, beginning_at, prepare
from handcart.networks.recon import gone_on, reconnoitre, standing_as_left
from handcart.networks.resuming import NothingToResume as NothingToResume
from handcart.networks.resuming import Past, read_past, task_of
from handcart.networks.retracing import NeedsOperator
from handcart.networks.robot_claim import claimed
from handcart.networks.run import Onlooker, execute
from handcart.networks.run_header import boot_id, robot_fingerprint
from handcart.networks.syncing import sync_for
from handcart.networks.task_file import load_task

from .judge import Judge


class NoFolder(HandcartError):
    """A run can't have a folder of its own; nothing has moved."""


class Teller(Protocol):
    """Tells a person, or a program, how a run gets on."""

    def say(self, words: str) -> None:
        """Something that should be known before anything moves."""

    def begin(self, prepared: Prepared, folder: Path) -> None:
        """What is about to start, and the run's folder."""

    def look(self, robot: Robot) -> None:
        """A period has passed."""

    def __call__(self, event: Event) -> None:
        """Something has happened."""


def run_task(
    task: Path,
    runs: Path,
    backend: str | None,
    settings: Mapping[str, str],
    seed: int,
    told: Teller | None = None,
    draw: bool = False,
    checkpoints: bool = False,
    permits: Permits | None = None,
    situation: str | None = None,
    video: Path | None = None,
    window: bool = False,
    sync: bool | None = None,
    errors: bool = True,
    bench: str | None = None,
    interrupts: Interrupts | None = None,
) -> tuple[dict[str, Any], int]:
    """Run a task once.

    Args:
        task: its file.
        runs: the run's folder is made in there.
        backend: another one than the task names.
        settings: parameters of the task, values unparsed.
        seed: of the simulated errors.
        told: hears of all that happens.
        draw: whether `overview.svg` is drawn.
        checkpoints: whether `handcart resume` can go on with it in a simulated world.
        permits: who permits actions that need it; left out: all are permitted.
        situation: where the run begins, instead of the task's start.
        video: where the run is recorded, as MP4.
        window: whether robot and world are shown.
        sync: whether the journal is brought to the disk; None: as the backend needs it.
        errors: whether the simulated robot errs.
        bench: simulated drives are put before the simulated backend of that name.
        interrupts: who hears of Ctrl-C; left out: somebody of its own, until the folder is whole.

    Returns:
        The summary that also stands in the run's folder, and the exit status.

    Raises:
        FileError: something in the task or a file that it names is wrong; nothing has moved.
        NoBench, NoWindow, NoVideo: there are no drives to simulate; it can't be shown, or recorded.
        NeedsOperator: a real robot's last run waits for a person.
        RobotBusy: it is in another run.
    """
    observers: list[Observer] = [] if told is None else [told]
    onlookers: list[Onlooker] = [] if told is None else [told.look]
    with ExitStack() as stack:
        heard = interrupts or stack.enter_context(Interrupts())
        prepared = stack.enter_context(
            prepare(
                task, backend, settings, seed, window=window, situation=situation, errors=errors, bench=bench
            )
        )
        claim = stack.enter_context(claimed(prepared.backend))
        if video is not None:
            from .video import Video

            film = stack.enter_context(Video(video, prepared.robot))
            observers.append(film.note)
            onlookers.append(film.look)
        folder = new_folder(runs, f"{task.resolve().parent.name}-{seed}")
        judge = Judge(prepared, folder)
        if told is not None:
            told.begin(prepared, folder)
        if claim is not None:
            claim.begin(folder)
        end = execute(
            prepared,
            folder,
            [judge, *observers],
            metrics=judge.metrics,
            permits=permits or Permits("always"),
            onlookers=[*onlookers, judge.look],
            checkpoints=checkpoints,
            sync=sync_for(prepared.backend.simulated, sync),
            interrupts=heard,
        )
        _report(prepared, folder, judge, told)
        if draw:
            _draw(prepared, folder, judge, told)
    return orjson.loads((folder / "summary.json").read_bytes()), end.exit_status


def _report(prepared: Prepared, folder: Path, judge: Judge, told: Teller | None) -> None:
    """What the surveys write and draw; a disk that takes no more doesn't change how the run ended."""
    try:
        judge.surveys.report(prepared, folder)
    except OSError as error:
        if told is not None:
            told.say(f"{folder} can't be written: {error.strerror}; what was surveyed isn't reported whole")


def _draw(prepared: Prepared, folder: Path, judge: Judge, told: Teller | None) -> None:
    """Draw the overview; a disk that takes no more doesn't change how the run ended."""
    from .overview import draw_overview

    model, radius = prepared.model, prepared.robot.spec.footprint_radius_m
    try:
        draw_overview(folder, model.map, model.places, radius, judge.surveys.shown)
    except OSError as error:
        if told is not None:
            told.say(f"{folder} can't be written: {error.strerror}; there is no overview.svg")


def resume_task(
    folder: Path,
    confirm: int | None,
    told: Teller,
    permits: Permits | None = None,
    sync: bool | None = None,
    interrupts: Interrupts | None = None,
) -> tuple[dict[str, Any], int]:
    """Go on with a run that broke off; a simulated world is put back to its last checkpoint.

    Args:
        folder: the run's.
        confirm: the journal's last record, as a person has seen it; needed where a real robot moves.
        told: hears what is known, and what happens.
        permits: who permits actions that need it; left out: all are permitted.
        sync: whether the journal is brought to the disk; None: as the backend needs it.
        interrupts: who hears of Ctrl-C; left out: somebody of its own, until the folder is whole.

    Returns:
        The summary that also stands in the run's folder, and the exit status.

    Raises:
        NoRun: it is no run's folder.
        JournalError: the journal can't be read, or is damaged inside.
        NotAState: the checkpoint, or what was noted to judge the run by, is damaged or of something else.
        RunAlive: the run still goes on.
        NothingToResume: the run came to its end.
        NeedsOperator: a person has to decide something first.
        FileError: the task or a file that it names is wrong by now.
    """
    header, made = prepare_again(folder)
    with ExitStack() as stack:
        heard = interrupts or stack.enter_context(Interrupts())
        prepared = stack.enter_context(made)
        claim = stack.enter_context(claimed(prepared.backend, folder))
        past = put_back(folder, header, prepared, told)
        if not prepared.backend.simulated:
            prepared = standing_as_left(prepared, past)
            recon = reconnoitre(prepared.robot, past)
            for words in (*recon.words(), past.next_words()):
                told.say(words)
            past = gone_on(past, recon, confirm)
        judge = Judge(prepared, folder)
        told.begin(prepared, folder)
        if claim is not None:
            claim.begin(folder)
        end = execute(
            prepared,
            folder,
            [judge, told],
            metrics=judge.metrics,
            permits=permits or Permits("always"),
            onlookers=[told.look, judge.look],
            checkpoints=True,
            past=past,
            sync=sync_for(prepared.backend.simulated, sync),
            interrupts=heard,
        )
        _report(prepared, folder, judge, told)
    return orjson.loads((folder / "summary.json").read_bytes()), end.exit_status


def prepare_again(folder: Path) -> tuple[Mapping[str, Any], Prepared]:
    """The header of a run that broke off, and its task prepared as then.

    Its journal is read first: no robot is woken for one that can't be gone on with. Raises as `resume_task`.
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
        header["seed"],
        situation=begun,
        errors=header["errors"],
        bench=header["bench"],
        resumed=True,
    )
    return header, prepared


def put_back(folder: Path, header: Mapping[str, Any], prepared: Prepared, told: Teller) -> Past:
    """Put a run, prepared anew, where it stood when it broke off; of a real robot only what it knew.

    Args:
        folder: the run's.
        header: of its journal.
        prepared: from the files that it names.
        told: hears what is known.

    Raises:
        NoRun, JournalError, NotAState, NeedsOperator: see `resume_task`.
    """
    past = read_past(folder, prepared.task.network)
    if header["robot_sha256"] != robot_fingerprint(prepared.robot.spec):
        words = f"the robot is not the one that was run: the file {header['robot']} has changed"
        raise NeedsOperator(printable(words))
    past.check_robot(prepared.robot)
    for words in past.words(time.time(), boot_id()):
        told.say(words)
    if past.checkpoint is not None:
        past.checkpoint.put_back(prepared)
    if prepared.backend.simulated:
        _check_world(past, told)
    return past


def _check_world(past: Past, told: Teller) -> None:
    """Whether a simulated world could be put back to where the run may go on from (R10)."""
    for words in past.doubts():
        told.say(f"unknown: {words}")
    told.say(past.next_words())
    if past.standing.done and past.checkpoint is None:
        raise NeedsOperator(f"{past.folder} holds no checkpoint of the simulated world")


def new_folder(runs: Path, name: str) -> Path:
    """Make a folder that didn't exist yet: NAME, NAME.2, NAME.3 ...

    Raises:
        NoFolder: it can't be made, or its name is no text.
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
        raise NoFolder(f"the name of {shown} is no UTF-8; allowed: a folder whose name is") from None
    except OSError as error:
        raise NoFolder(f"no folder can be made in {runs}: {error.strerror}") from None
