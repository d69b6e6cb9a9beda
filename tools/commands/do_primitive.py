"""`handcart do`: one primitive alone."""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.networks.task.task_file import Task
    from handcart.networks.task.task_knowledge import TaskKnowledge
    from handcart.primitives.contract.action_primitive import ActionPrimitive

DEFAULT_ROBOT = "librarian"
NO_MAP_PATH = Path("none")
OUTCOME_STATUS = {"Success": 0, "Fail": 3, "GiveUp": 4}


def do(
    primitive: Annotated[str, typer.Argument(help="its name, such as MOVE_TO")],
    parameters: Annotated[list[str] | None, typer.Argument(help="KEY=VALUE ...")] = None,
    knowledge: Annotated[
        Path | None, typer.Option(help="a task's file or name: its robot, world, map and other knowledge")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="KEY=VALUE: a parameter of the task given by --knowledge"),
    ] = None,
    robot: Annotated[str | None, typer.Option(help="a shipped robot, or the path of a robot's file")] = None,
    backend: Annotated[str, typer.Option(help="the backend of the robot")] = "kinematic",
    world: Annotated[Path | None, typer.Option(help="default: the library of return_book")] = None,
    map: Annotated[
        Path | None, typer.Option(help="a map in ROS format; none: the frame is that of the start")
    ] = None,
    places: Annotated[Path | None, typer.Option(help="the map's named places")] = None,
    start: Annotated[str | None, typer.Option(help="the place where the robot is put at first")] = None,
    seed: Annotated[int, typer.Option(help="of the simulated errors")] = 0,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="folder for pictures and maps (default: a new one for a map)"),
    ] = None,
) -> None:
    """Run a single primitive without a task, and print its outcome.

    The default world is the library of the task return_book.
    """
    from handcart.tools.terminal.first_use import announced

    with announced(f"running {primitive}"):
        from handcart.evaluation.trials.rig import RigFiles, build_rig
        from handcart.networks.runs.robot_claim import claimed
        from handcart.primitives.outcomes.outcome import Success

        made = _made(primitive, parameters or [])
        task = _task(knowledge, settings or [])
        own = RigFiles() if task is None else RigFiles.of(task)
        if map == NO_MAP_PATH or (made.draws_map and map is None and task is None):
            own, map = RigFiles.without_map(own.world), None
        given = {"world": world, "map": map, "places": places, "start": start}
        files = replace(own, **{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]
        whose = robot or (DEFAULT_ROBOT if task is None else task.robot)
        with (
            build_rig(files, whose, backend, seed, put_at_start=start is not None) as rig,
            claimed(rig.backend),
        ):
            _check_names(made, rig.knowledge)
            outcome = rig.do(made)
    _write_evidence(made, output)
    word = type(outcome).__name__
    print(word if isinstance(outcome, Success) else f"{word}: {outcome.reason}")
    facts = outcome.evidence if isinstance(outcome, Success) else {**made.facts, **outcome.residuals}
    for name, value in facts.items():
        print(f"  {name}: {value:.4g}" if isinstance(value, float) else f"  {name}: {value}")
    sys.exit(OUTCOME_STATUS[word])


def _write_evidence(made: ActionPrimitive, output: Path | None) -> None:
    """Write what a primitive has drawn into a folder, and print its name.

    Without a folder a map goes into a new one, which is named after it.
    """
    from handcart.networks.runs.evidence_files import write_evidence, write_map
    from handcart.tools.terminal.writing import NotWritable

    maps = made.evidence.maps
    if output is None and not maps:
        return
    folder = output or _new_folder(Path(next(iter(maps))))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_evidence(folder, made.label(), made.evidence)
        for name, drawn in maps.items():
            write_map(folder if len(maps) == 1 else folder / name, drawn)
    except OSError as error:
        raise NotWritable(folder, error.strerror, "a folder that exists or can be made") from None
    print(f"saved in {folder}", file=sys.stderr)


def _new_folder(folder: Path) -> Path:
    """Return a folder's name, with a number if there is one of that name."""
    names = (folder.with_name(f"{folder.name}-{number}") for number in count(2))
    return folder if not folder.exists() else next(name for name in names if not name.exists())


def _task(knowledge: Path | None, settings: list[str]) -> Task | None:
    """Load the task whose knowledge is used; None if none is given."""
    from handcart.files.models.settings import split_settings
    from handcart.networks.task.task_file import load_task
    from handcart.tasks.task_names import task_path

    if knowledge is None:
        if settings:
            raise typer.BadParameter("--set without --knowledge; needed: the task with that parameter")
        return None
    return load_task(task_path(knowledge), split_settings(settings))


def _made(name: str, parameters: list[str]) -> ActionPrimitive:
    """Return the primitive with its parameters, checked as in a task file."""
    from handcart.primitives.clock.wall_clock import ALLOWED_CLOCK, wall_clock_reads
    from handcart.primitives.registry import primitive_class
    from handcart.tools.terminal.typed_model import typed_model

    try:
        kind = primitive_class(name)
    except KeyError as unknown:
        raise typer.BadParameter(str(unknown.args[0])) from None
    if wrong := wall_clock_reads(kind):
        raise typer.BadParameter(f"{'; '.join(wrong)}; {ALLOWED_CLOCK}")
    return typed_model(kind, parameters, f"handcart do {name}")


def _check_names(made: ActionPrimitive, knowledge: TaskKnowledge) -> None:
    from handcart.files.suggest import suggest
    from handcart.networks.task.primitive_parameters import named_entry

    known = knowledge.names()
    for key, field in type(made).model_fields.items():
        name, entry = getattr(made, key), named_entry(field)
        if entry and name is not None and name not in (there := known.get(entry, ())):
            allowed = (
                suggest(str(name), [str(item) for item in there]) if there else f"; no {entry} are known"
            )
            raise typer.BadParameter(f"{key}={name}: unknown {entry[:-1]} {name!r}{allowed}")
