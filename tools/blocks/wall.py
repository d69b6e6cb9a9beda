"""`handcart wall`: from a robot and a drawing of a wall to a task that builds it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def wall(
    robot: Annotated[str, typer.Argument(help="a shipped robot's name, or a robot's YAML file")],
    drawing: Annotated[Path, typer.Argument(help="a drawing: YAML of the format handcart-drawing/1")],
    chart: Annotated[Path, typer.Option("--map", help="the map: YAML in ROS format")],
    output: Annotated[Path, typer.Option("-o", "--output", help="folder to write into")] = Path("wall"),
    world: Annotated[Path | None, typer.Option(help="simulated world (default: the drawn one)")] = None,
) -> None:
    """Plan how blocks of a drawing are taken and laid, and write a task and the picture wall.svg.

    The plan contains the places of the base and the order of the blocks.
    """
    import os

    from handcart.backends.loading.robot_loading import load_robot
    from handcart.evaluation.blocks.wall_files import write_wall
    from handcart.evaluation.blocks.wall_planning import plan_wall
    from handcart.evaluation.blocks.wall_plots import draw_wall
    from handcart.files.errors import InputError
    from handcart.files.models.loading import load_document
    from handcart.files.yaml.yaml_document import read_document
    from handcart.primitives.blocks.drawing import Drawing
    from handcart.primitives.knowledge.place import load_map
    from handcart.primitives.outcomes.discrepancy import Discrepancy
    from handcart.tools.terminal.first_use import announced
    from handcart.tools.terminal.writing import NotWritable, check_folder

    check_folder(output)
    loaded = load_document(read_document(drawing), Drawing)
    spec, (grid, _) = load_robot(robot), load_map(chart)
    try:
        with announced(f"planning how {drawing} is built"):
            plan = plan_wall(loaded, spec, grid)
    except Discrepancy as lacking:
        raise InputError(f"{robot} can't build walls: {lacking.reason}") from None
    own = robot.endswith((".yaml", ".yml"))
    named = Path(os.path.relpath(robot, output)).as_posix() if own else robot
    try:
        write_wall(plan, chart, named, output, world)
        draw_wall(plan, spec.footprint_radius_m, output / "wall.svg")
    except OSError as error:
        raise NotWritable(output, error.strerror) from None
    print(
        f"{len(plan.blocks)} blocks, {len(plan.trips)} trips, {len(plan.fetching)} + {len(plan.laying)} stops"
    )
    for stop in (*plan.fetching, *plan.laying):
        print(f"  {stop.words()}")
    print(f"run it: handcart run {output / 'task.yaml'}{f' --robot {robot}' if own else ''}")
