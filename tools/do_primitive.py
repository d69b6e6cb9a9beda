"""`handcart do`: one primitive alone."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

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
    start: Annotated[str, typer.Option(help="the place where the robot stands at first")] = "home",
    seed: Annotated[int, typer.Option(help="of the simulated errors")] = 0,
) -> None:
    """Run one primitive alone, and tell its outcome."""
    from evaluation.stage import StageFiles, set_stage
    from primitives.outcome import Success

    made = _make(primitive, parameters or [])
    given = {"world": world, "map": map, "places": places, "catalogue": catalogue, "start": start}
    files = StageFiles(**{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]
    with set_stage(files, robot, backend, seed) as stage:
        outcome = stage.do(made)
    word = type(outcome).__name__
    print(word if isinstance(outcome, Success) else f"{word}: {outcome.reason}")
    told = outcome.evidence if isinstance(outcome, Success) else {**made.facts, **outcome.residuals}
    for name, value in told.items():
        print(f"  {name}: {value:.4g}" if isinstance(value, float) else f"  {name}: {value}")
    sys.exit(STATUS[word])


def _make(name: str, parameters: list[str]) -> Any:
    """The primitive with its parameters, checked as in a task file."""
    from files.loading import load_part
    from files.settings import split_setting
    from files.yaml_document import parse_document
    from primitives.registry import primitive_class

    try:
        kind = primitive_class(name)
    except KeyError as unknown:
        raise typer.BadParameter(str(unknown.args[0])) from None
    pairs = [split_setting(each) for each in parameters]
    text = "".join(f"{key}: {value}\n" for key, value in pairs) or "{}\n"
    return load_part(parse_document(text.encode(), f"handcart do {name}"), (), kind)
