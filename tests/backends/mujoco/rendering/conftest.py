"""A table with blocks on it in MuJoCo, and OpenGL to look at it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.mujoco.mujoco_backend import MujocoBackend
from handcart.backends.mujoco.rendering.gl_context import NoPictures, make_context
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.loading import load

WORLD = """
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0}
tables:
  - {name: table, x_m: 0.08, y_m: 0.65, size_m: [0.66, 0.76, 0.4], foot_m: [0.3, 0.2]}
marks:
  - {x_m: 0.0, y_m: 0.5, height_m: 0.4, kind: landmark, size_mm: 40}
blocks:
  - {name: "1", x_m: 0.15, y_m: 0.45, height_m: 0.4}
"""

Make = Callable[..., MujocoBackend]


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    """Makes the world; `more` is added to its file."""
    made: list[MujocoBackend] = []

    def it(more: str = "", seed: int = 3) -> MujocoBackend:
        path = tmp_path / "world.yaml"
        path.write_text(WORLD + more, encoding="utf-8")
        made.append(MujocoBackend(load_robot("toyama"), load(path, world_model()), seed))
        return made[-1]

    yield it
    for backend in made:
        backend.close()


@pytest.fixture
def gl() -> None:
    """OpenGL without a display; without that no test of pictures can run."""
    try:
        make_context(16, 16).free()
    except NoPictures as error:
        pytest.skip(str(error))
