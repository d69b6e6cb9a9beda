"""`handcart conformance`: whether a backend, a robot and the primitives on it keep what they promise."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from handcart.evaluation.conformance.kit import KitSetting

BROKEN_PROMISE = 5
PROGRESS_INTERVAL_S = 30.0  # minimum, between two lines


def conformance(
    backend: Annotated[str, typer.Option(help="its name")] = "kinematic",
    robot: Annotated[
        str | None,
        typer.Option(
            help="a shipped robot, or the path of a robot's file (default: librarian, or that of --rehearse)"
        ),
    ] = None,
    bench: Annotated[
        str | None, typer.Option(help="with --backend can or ros2: simulated drives before this backend")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick/--full", help="few faults and no complete tasks; full: everything")
    ] = True,
    parts: Annotated[
        list[str] | None,
        typer.Option("--part", help="checks, faults, mutants or tasks (default: all; quick: not tasks)"),
    ] = None,
    primitives: Annotated[
        list[str] | None, typer.Option("--primitive", help="faults in this one alone, such as MOVE_TO")
    ] = None,
    instants: Annotated[
        int | None, typer.Option(min=1, help="of each primitive's run in which faults are injected")
    ] = None,
    rehearse: Annotated[
        list[Path] | None,
        typer.Option(help="inject faults in the actions of this task of yours, in place of shipped ones"),
    ] = None,
    tasks: Annotated[
        list[str] | None, typer.Option("--task", help="this whole task alone, such as return_book")
    ] = None,
    seeds: Annotated[int | None, typer.Option(min=1, help="with which each whole task is run")] = None,
    jobs: Annotated[int, typer.Option(min=1, help="processes side by side")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
) -> None:
    """Test whether a backend and the primitives keep their contracts; the exit status is 0 if they do.

    The backend's declarations are checked, faults are injected into runs, and deliberately faulty primitives
    (mutants) have to be detected.
    """
    from handcart.evaluation.conformance.kit import KitSetting, default_robot, run_kit
    from handcart.tasks.task_names import task_path

    faults = {"--primitive": primitives, "--rehearse": rehearse, "--instants": instants}
    chosen = _chosen(parts or [], faults, {"--task": tasks, "--seeds": seeds})
    own = [task_path(path) for path in rehearse or []]
    robot = robot or default_robot(own)
    setting = KitSetting(
        backend, robot, quick, chosen, primitives or (), instants, seeds, tasks or (), own, bench
    )
    _check(setting)
    for name, why in sorted(setting.left_out.items()):
        print(f"left out: {name}: {why}", file=sys.stderr)
    if quick:
        print("quick: few faults and no complete tasks; --full tries everything", file=sys.stderr)
    with _progress() as tell:
        report = run_kit(setting, jobs, tell)
    if as_json:
        import orjson

        print(orjson.dumps(report.as_dict(), option=orjson.OPT_SERIALIZE_NUMPY).decode())
    else:
        for line in report.lines():
            print(line)
    sys.exit(0 if report.ok else BROKEN_PROMISE)


@contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """Yield a function that reports finished jobs: in a bar, or without a terminal in an occasional line."""
    from rich.console import Console
    from rich.progress import Progress, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield _seldom(console)
        return
    with Progress(*Progress.get_default_columns(), TimeElapsedColumn(), console=console) as progress:
        task = progress.add_task("conformance", total=None)
        yield lambda done, count: progress.update(task, completed=done, total=count)


def _seldom(console: Console) -> Callable[[int, int], None]:
    """Return a function that prints a line at the beginning, at the end, and from time to time in between."""
    start, last = time.monotonic(), -math.inf

    def tell(done: int, count: int) -> None:
        nonlocal last
        now = time.monotonic()
        if done == count or now - last >= PROGRESS_INTERVAL_S:
            last = now
            console.print(f"{done} of {count} jobs done after {now - start:.0f} s")

    return tell


def _chosen(parts: list[str], faults: Mapping[str, object], tasks: Mapping[str, object]) -> tuple[str, ...]:
    """Return the named parts, or the parts that the other options concern.

    Args:
        parts: parts that the user names.
        faults: values of the options that concern the faults alone, by their names.
        tasks: likewise of those that concern whole tasks.

    Raises:
        typer.BadParameter: a part is unknown, or an option concerns none of the named parts.
    """
    from handcart.evaluation.conformance.kit import KIT_PARTS
    from handcart.files.suggest import suggest

    for part in parts:
        if part not in KIT_PARTS:
            raise typer.BadParameter(f"unknown part {part!r}{suggest(part, KIT_PARTS)}")
    given = {"faults": [name for name, value in faults.items() if value]}
    given["tasks"] = [name for name, value in tasks.items() if value]
    if not parts:
        return tuple(part for part, names in given.items() if names and names != ["--instants"])
    for part, names in given.items():
        if names and part not in parts:
            raise typer.BadParameter(f"{', '.join(names)} without --part {part}; needed: both")
    return tuple(parts)


def _check(setting: KitSetting) -> None:
    """Reject options that cannot be tested, before any test."""
    from handcart.backends.registry import backend_class, bench_class
    from handcart.files.errors import FileError
    from handcart.files.suggest import suggest
    from handcart.networks.task.preparing import check

    backend_class(setting.backend)
    if setting.simulated is not None:
        bench_class(setting.simulated, setting.backend)
    for task in setting.own_tasks:
        if errors := check(task, setting.backend, {"robot": setting.robot}).errors:
            raise FileError(errors)
    tried, left = setting.tried(), setting.left_out
    for name in setting.primitives:
        if name in left:
            raise typer.BadParameter(f"no fault can be tried in {name!r}: {left[name]}")
        if name not in tried:
            raise typer.BadParameter(f"no fault can be tried in {name!r}{suggest(name, tried)}")
    whole = [task.parent.name for task in setting.tasks]
    for name in setting.only_tasks:
        if name not in whole:
            raise typer.BadParameter(f"the robot can't do a whole task {name!r}{suggest(name, whole)}")
