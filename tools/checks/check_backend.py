"""Checks that simulated backends can be built with a robot."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from handcart.files.errors import FileError, InputError
from handcart.files.extras import is_there

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import RobotFile

EMPTY_WORLD = "format: handcart-world/1\nstart: {x_m: 0.0, y_m: 0.0}\n"


def engine_remarks(robot: RobotFile) -> list[str]:
    """Return the reasons for which MuJoCo cannot load a robot; empty if it can, or is not installed."""
    if not is_there("mujoco"):
        return []
    from handcart.backends.mujoco.body.building import model_refusal

    error = model_refusal(robot)
    if error is None:
        return []
    return list(map(str, error.findings)) if isinstance(error, FileError) else [str(error)]


def build_in_empty_world(robot: RobotFile, backend: str) -> None:
    """Build a simulated backend with a robot on an empty floor, and close it.

    Raises:
        InputError: the backend is not a simulated one, or refuses the robot.
    """
    from handcart.backends.registry import backend_class, make_backend

    kind = backend_class(backend)
    if kind.has_drives or not kind.simulated:
        raise InputError(f"the backend {backend!r} moves real drives; allowed with check: simulated backends")
    with TemporaryDirectory() as folder:
        world = Path(folder) / "world.yaml"
        world.write_text(EMPTY_WORLD, encoding="utf-8")
        make_backend(backend, robot, world, seed=0).close()
