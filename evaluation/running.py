"""Running a task once, with its metrics, into a folder of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import orjson

from networks.events import Observer
from networks.permits import Permits
from networks.preparing import Prepared, prepare
from networks.run import Onlooker, execute

from .judge import Judge


def run_task(
    task: Path,
    runs: Path,
    backend: str | None,
    settings: Mapping[str, str],
    seed: int,
    observers: Sequence[Observer] = (),
    draw: bool = False,
    begin: Callable[[Prepared, Path], None] | None = None,
    permits: Permits | None = None,
    situation: str | None = None,
    onlookers: Sequence[Onlooker] = (),
    video: Path | None = None,
    window: bool = False,
) -> tuple[dict[str, Any], int]:
    """Run a task once.

    Args:
        task: its file.
        runs: the run's folder is made in there.
        backend: another one than the task names.
        settings: parameters of the task, values unparsed.
        seed: of the simulated errors.
        observers: told of all that happens.
        draw: whether `overview.svg` is drawn.
        begin: called with what is about to start, and the run's folder.
        permits: who permits actions that need it; left out: all are permitted.
        situation: where the run begins, instead of the task's start.
        onlookers: called after each period.
        video: where the run is recorded, as MP4.
        window: whether robot and world are shown.

    Returns:
        The summary that also stands in the run's folder, and the exit status.

    Raises:
        FileError: something in the task or a file that it names is wrong; nothing has moved.
        NoWindow, NoVideo: the run can't be shown or recorded; nothing has moved.
    """
    with ExitStack() as stack:
        prepared = stack.enter_context(
            prepare(task, backend, settings, seed, window=window, situation=situation)
        )
        if video is not None:
            from .video import Video

            film = stack.enter_context(Video(video, prepared.robot))
            observers, onlookers = [*observers, film.note], [*onlookers, film.look]
        folder = new_folder(runs, f"{task.resolve().parent.name}-{seed}")
        judge = Judge(prepared)
        if begin is not None:
            begin(prepared, folder)
        end = execute(
            prepared,
            folder,
            [*observers, judge],
            metrics=judge.metrics,
            permits=permits or Permits("always"),
            onlookers=onlookers,
        )
        if draw:
            from .overview import draw_overview

            model, radius = prepared.model, prepared.robot.spec.footprint_radius_m
            draw_overview(folder, model.map, model.places, radius)
    return orjson.loads((folder / "summary.json").read_bytes()), end.exit_status


def new_folder(runs: Path, name: str) -> Path:
    """A folder that doesn't exist yet: NAME, NAME.2, NAME.3 ..."""
    number, folder = 1, runs / name
    while folder.exists():
        number += 1
        folder = runs / f"{name}.{number}"
    return folder
