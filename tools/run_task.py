"""`handcart run`: run a task to its end."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from datetime import time

    from handcart.networks.events.run_observer import RunObserver
    from handcart.networks.runs.run_options import RunOptions
    from handcart.tools.terminal.progress import Progress

Permit = Literal["ask", "always", "never"]
PolicyName = Literal["rule", "expected_cost", "goal_probability"]


def run(
    task: Annotated[Path, typer.Argument(help="a task's file, or its name (`handcart list tasks`)")],
    backend: Annotated[str | None, typer.Option(help="another backend than the task names")] = None,
    robot: Annotated[
        str | None, typer.Option(help="another robot than the task names, or the path of its file")
    ] = None,
    policy: Annotated[
        PolicyName | None, typer.Option(help="another policy than the task names; all but `rule` need p")
    ] = None,
    seed: Annotated[int, typer.Option(help="of the simulated errors")] = 0,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE: a parameter that the task declares")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
    video: Annotated[Path | None, typer.Option(help="record the run into this file, *.mp4")] = None,
    permit: Annotated[Permit, typer.Option(help="actions with `permit: operator`")] = "ask",
    step: Annotated[bool, typer.Option("--step", help="ask before every action")] = False,
    breaks: Annotated[
        list[str] | None, typer.Option("--break", help="ask before actions from this situation")
    ] = None,
    situation: Annotated[
        str | None, typer.Option("--from", help="begin in this situation; you vouch for it")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="check and plan, print, move nothing")] = False,
    script: Annotated[
        Path | None, typer.Option(help="outcomes from a file instead of a robot's: try the network alone")
    ] = None,
    no_errors: Annotated[
        bool, typer.Option("--no-errors", help="the simulated robot errs nowhere, whatever its file says")
    ] = False,
    bench: Annotated[
        str | None, typer.Option(help="with --backend can: simulated drives before this simulated backend")
    ] = None,
    begins_at: Annotated[
        str | None,
        typer.Option("--begins-at", help="time of day at which a simulated run begins, HH:MM"),
    ] = None,
    gui: Annotated[bool, typer.Option("--gui", help="show robot and world in a window")] = False,
    view: Annotated[
        bool, typer.Option("--view", help="show it in the browser while it runs; simulated: in real time")
    ] = False,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="port of --view (default: 8080 or the next free one)"),
    ] = None,
    node: Annotated[
        bool,
        typer.Option("--node", help="publish it in ROS 2 and take commands there; simulated: in real time"),
    ] = False,
    node_namespace: Annotated[str, typer.Option(help="namespace of --node's topics and services")] = "",
    report: Annotated[
        bool, typer.Option("--report/--no-report", help="write report.html into the run's folder")
    ] = True,
    record_sensors: Annotated[
        bool,
        typer.Option(
            "--record-sensors", help="keep all readings and commands, for `handcart replay --sensors`"
        ),
    ] = False,
    sync: Annotated[
        bool | None,
        typer.Option(
            "--sync/--no-sync", help="whether the journal waits for the disk; a real robot's does by default"
        ),
    ] = None,
    runs: Annotated[Path, typer.Option(help="where the run's folder is made")] = Path("runs"),
) -> None:
    """Check a task with all its files, run it, and report how it ended."""
    from handcart.files.printable import composed
    from handcart.files.shown_path import shown_path
    from handcart.tasks.task_names import task_path

    task = task_path(task)
    if port is not None and not view:
        raise typer.BadParameter("--port without --view; needed: both")
    if node_namespace and not node:
        raise typer.BadParameter("--node-namespace without --node; needed: both")
    situation = None if situation is None else composed(situation)
    breaks = [composed(name) for name in breaks or ()]
    settings = _with_choices(settings or [], robot=robot, policy=policy)
    if dry_run or script is not None:
        sys.exit(_dry_run(task, backend, settings, seed, situation, script, as_json))
    from handcart.tools.terminal.first_use import first_words

    with first_words(f"loading {shown_path(task)}") as progress_begins:
        from handcart.files.models.settings import split_settings
        from handcart.networks.operator.permits import Permits
        from handcart.networks.runs.run_options import RunOptions
        from handcart.tools.terminal.writing import check_folder

        check_folder(runs)
        options = RunOptions(
            *(backend, split_settings(settings), seed, situation),
            errors=not no_errors,
            bench=bench,
            window=gui,
            video=video,
            draw=True,
            report=report,
            playback=True,
            checkpoints=True,
            record_sensors=record_sensors,
            sync=sync,
            begins_at=None if begins_at is None else _time_of_day(begins_at),
            permits=Permits(permit, step, breaks),
        )
        namespace = node_namespace if node else None
        status = _run_watched(task, runs, options, (view, port, as_json), namespace, progress_begins)
    sys.exit(status)


def _time_of_day(text: str) -> time:
    """Return the time of day of `--begins-at`; raises `FileError`."""
    from handcart.files.errors import FileError, Finding
    from handcart.networks.entries.aims_entry import read_time_of_day

    try:
        return read_time_of_day(text)
    except ValueError as wrong:
        raise FileError([Finding(f"--begins-at {text}", 0, 0, str(wrong))]) from None


def _run_watched(
    task: Path,
    runs: Path,
    options: RunOptions,
    shows: tuple[bool, int | None, bool],
    node: str | None,
    begins: Callable[[], None],
) -> int:
    """Run a task beside its progress, report how it ended, and return the exit status.

    Args:
        task: the task's file.
        runs: where the run's folder is made.
        options: of the run, without observers.
        shows: whether to show it in the browser, the port, and whether to end with JSON.
        node: namespace of its node in ROS 2; None for no node.
        begins: called before the first progress.
    """
    from dataclasses import replace

    from handcart.evaluation.trials.running import run_task
    from handcart.networks.coordination.interrupts import Interrupts
    from handcart.robotics.numerics.compiling_ahead import compiling_ahead
    from handcart.tools.terminal.progress import Progress

    view, port, as_json = shows
    with Interrupts() as interrupts, Progress(begins) as progress, ExitStack() as stack:
        stack.enter_context(compiling_ahead())
        if options.permits:
            options.permits.asking, options.permits.typed = progress.ask, progress.typed
        shown = [stack.enter_context(_shown(port, progress))] if view else []
        if node is not None:
            from handcart.tools.node.open_node import opened_node

            shown.append(stack.enter_context(opened_node(node, progress.say)))
        options = replace(options, interrupts=interrupts, observers=(progress, *shown))
        summary, status = run_task(task, runs, options)
        progress.end()
        _tell(summary, as_json, progress)
    return status


def _with_choices(settings: list[str], **choices: str | None) -> list[str]:
    """Return settings extended by the values of parameters that have their own options."""
    return [*settings, *(f"{key}={value}" for key, value in choices.items() if value)]


def _dry_run(task: Path, *options: Any) -> int:
    """Check and plan a task without a robot, and return the exit status.

    Args:
        task: the task's file.
        *options: the further arguments of `dry_run`: backend, settings, seed, situation, script, as JSON.
    """
    from handcart.files.shown_path import shown_path
    from handcart.tools.checks.dry_run import dry_run
    from handcart.tools.terminal.first_use import announced

    with announced(f"checking {shown_path(task)}"):
        return dry_run(task, *options)


def _tell(summary: dict[str, Any], as_json: bool, progress: Progress) -> None:
    """Print how the run ended, and which commands may be next.

    Args:
        summary: content of the run's `summary.json`.
        as_json: True to print it as JSON on stdout.
        progress: output for a person.
    """
    if as_json:
        import orjson

        print(orjson.dumps(summary).decode(), flush=True)
        return
    from handcart.tools.terminal.next_steps import ended_words, next_steps

    print(ended_words(summary), flush=True)
    progress.offer(next_steps(summary))


@contextmanager
def _shown(port: int | None, progress: RunObserver) -> Iterator[RunObserver]:
    """Yield an observer that shows the run in the browser."""
    from handcart.evaluation.viewing.view.live_view import LiveView
    from handcart.evaluation.viewing.view.serving.server import open_server

    with open_server(port, "handcart run --view") as opened:
        progress.say(f"{opened.address} shows it")
        yield LiveView(opened.server, opened.address)
