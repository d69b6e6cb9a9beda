"""`handcart do`: one primitive alone."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from handcart.primitives.action_primitive import ActionPrimitive

STATUS = {"Success": 0, "Fail": 3, "GiveUp": 4}


def do(
    primitive: Annotated[str, typer.Argument(help="its name, such as MOVE_TO")],
    parameters: Annotated[list[str] | None, typer.Argument(help="KEY=VALUE ...")] = None,
    robot: Annotated[str, typer.Option(help="a shipped robot, or the path of a robot's file")] = "librarian",
    backend: Annotated[str, typer.Option(help="what stands for the robot")] = "kinematic",
    world: Annotated[Path | None, typer.Option(help="default: the library of return_book")] = None,
    map: Annotated[Path | None, typer.Option(help="a map in ROS format")] = None,
    places: Annotated[Path | None, typer.Option(help="the map's named places")] = None,
    catalogue: Annotated[Path | None, typer.Option(help="of books")] = None,
    start: Annotated[str, typer.Option(help="the place at which the world starts the robot")] = "home",
    seed: Annotated[int, typer.Option(help="of the simulated errors")] = 0,
) -> None:
    """Run one primitive alone, and tell its outcome."""
    from handcart.evaluation.stage import StageFiles, set_stage
    from handcart.networks.robot_claim import claimed
    from handcart.primitives.outcome import Success

    made = _made(primitive, parameters or [])
    given = {"world": world, "map": map, "places": places, "catalogue": catalogue, "start": start}
    files = StageFiles(**{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]
    with set_stage(files, robot, backend, seed) as stage, claimed(stage.backend):
        _check_places(made, stage.model.places)
        outcome = stage.do(made)
    word = type(outcome).__name__
    print(word if isinstance(outcome, Success) else f"{word}: {outcome.reason}")
    told = outcome.evidence if isinstance(outcome, Success) else {**made.facts, **outcome.residuals}
    for name, value in told.items():
        print(f"  {name}: {value:.4g}" if isinstance(value, float) else f"  {name}: {value}")
    sys.exit(STATUS[word])


def _made(name: str, parameters: list[str]) -> ActionPrimitive:
    """The primitive with its parameters, checked as in a task file."""
    from handcart.files.errors import FileError
    from handcart.primitives.registry import primitive_class

    try:
        kind = primitive_class(name)
    except KeyError as unknown:
        raise typer.BadParameter(str(unknown.args[0])) from None
    try:
        return _read(name, kind, parameters)
    except FileError as error:
        raise FileError(_as_typed(error)) from None


def _read(name: str, kind: type[ActionPrimitive], parameters: list[str]) -> ActionPrimitive:
    from handcart.files.loading import load_part
    from handcart.files.settings import setting_value, split_setting
    from handcart.files.yaml_document import Document
    from handcart.files.yaml_node import Node

    content = {}
    for key, value in map(split_setting, parameters):
        content[key] = setting_value(key, value)
    command = f"handcart do {name}"
    return load_part(Document(command, b"", Node(content, command, 0, 0, 0, 0)), (), kind)


def _as_typed(error: Any) -> list[Any]:
    """Findings without the `--set` that a task's parameters have."""
    from dataclasses import replace

    return [replace(each, file=each.file.removeprefix("--set ")) for each in error.findings]


def _check_places(made: ActionPrimitive, places: Any) -> None:
    from handcart.files.suggest import suggest
    from handcart.primitives.place_name import Names

    for key, field in type(made).model_fields.items():
        name = getattr(made, key)
        if any(isinstance(mark, Names) for mark in field.metadata) and name not in places:
            raise typer.BadParameter(f"{key}={name}: unknown place {name!r}{suggest(name, places)}")
