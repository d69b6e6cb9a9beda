"""`handcart jog`: one axis, while a key is held."""

from __future__ import annotations

import math
from typing import Annotated

import typer


def jog(
    robot: Annotated[str, typer.Argument(help="the robot's YAML file, or a shipped robot")],
    axis: Annotated[str, typer.Argument(help="such as 'left wheel', 'joint 2', gripper")],
    way: Annotated[
        float,
        typer.Argument(
            help="at most: [mm], of joints that turn [deg]; below 0 the other way, after a --: -- -5"
        ),
    ],
    bench: Annotated[
        str | None,
        typer.Option(help="simulated drives before this simulated backend: kinematic, mujoco, pybullet"),
    ] = None,
    slower: Annotated[float, typer.Option(min=0.01, max=1.0, help="share of the hand's 250 mm/s")] = 1.0,
) -> None:
    """Move one axis of a robot while the space bar is pressed; releasing it stops the axis.

    The hand moves at 250 mm/s at most.
    """
    from pathlib import Path

    from handcart.backends.loading.robot_loading import load_robot
    from handcart.evaluation.bringup.jog import HAND_SPEED, Jogger, UnknownAxis, slides
    from handcart.evaluation.bringup.operator import BenchOperator, Operator
    from handcart.evaluation.bringup.site import Site
    from handcart.evaluation.trials.rig import LIBRARY_FOLDER
    from handcart.tools.terminal.terminal_operator import TerminalOperator

    if not math.isfinite(way):
        raise typer.BadParameter(f"the distance is {way:g}; allowed: a finite number")
    operator: Operator = TerminalOperator() if bench is None else BenchOperator()
    spec = load_robot(robot)
    site = Site(
        robot,
        spec,
        operator,
        Path(),
        LIBRARY_FOLDER / "task.yaml",
        bench or "",
        LIBRARY_FOLDER / "world.yaml",
    )
    turns = axis.startswith("joint") and not slides(spec, axis)
    wanted = math.radians(way) if turns else way / 1e3
    with site.backend() as backend:
        jogger = Jogger(backend, spec)
        if axis not in jogger.axes:
            raise UnknownAxis(axis, jogger.axes)  # before a person is asked to hold a key
        words = f"{axis}: hold the space bar; the hand runs at {1e3 * slower * HAND_SPEED:.0f} mm/s at most"
        with operator.hold(words) as held:
            done = jogger.jog(axis, wanted, held, slower)
    moved = math.degrees(done.way) if turns else 1e3 * done.way
    print(f"{axis}: moved by {moved:.2f} {'deg' if turns else 'mm'}, {done.ended}")
