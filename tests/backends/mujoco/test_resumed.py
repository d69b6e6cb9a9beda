"""A restored world in MuJoCo continues as the saved one, to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.backends.mujoco.mujoco_backend import MujocoBackend
from handcart.backends.saved_state import NotAState, pack, unpack
from handcart.backends.simulation.blocks.block_props import BlockProps
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.loading import load

WORLD = """
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0}
tables:
  - {name: table, x_m: 0.08, y_m: 0.65, size_m: [0.66, 0.76, 0.4], foot_m: [0.3, 0.2]}
surprises:
  - {name: visitor, x_m: 2.0, y_m: 2.0, size_m: [0.3, 0.3, 1.7], appears_s: 0.5}
blocks:
  - {name: "1", on: robot, x_m: -0.26, y_m: 0.0, height_m: 0.45}
  - {name: "2", x_m: 0.15, y_m: 0.45, height_m: 0.4}
  - {name: "3", x_m: 0.168, y_m: 0.45, height_m: 0.44}
"""


@pytest.fixture
def backends(tmp_path: Path) -> Iterator[tuple[Any, Any]]:
    path = tmp_path / "world.yaml"
    path.write_text(WORLD, encoding="utf-8")
    made = [MujocoBackend(load_robot("toyama"), load(path, world_model()), 3) for _ in range(2)]
    yield made[0], made[1]
    for backend in made:
        backend.close()


def move(backend: Any, number: int) -> None:
    """A period of driving, and of an arm that swings."""
    base, arm = backend.capabilities()[:2]
    if number % 50 < 25:
        base.drive(0.1, 0.2)
    arm.move(arm.command() + 0.01 * np.sin(number / 10))
    backend.step()


@pytest.mark.slow
def test_it_goes_on_to_the_last_bit(backends: tuple[Any, Any]) -> None:
    first, again = backends
    for number in range(60):
        move(first, number)
        if number % 12:
            continue
        kept = pack(first.state())
        again.set_state(unpack(kept))
        assert pack(again.state()) == kept
        for later in range(number + 1, number + 6):
            move(again, later)
        then = pack(again.state())
        again.set_state(unpack(kept))
        for later in range(number + 1, number + 6):
            move(again, later)
        assert pack(again.state()) == then


@pytest.mark.slow
def test_a_run_that_was_kept_is_the_one_that_goes_on(backends: tuple[Any, Any]) -> None:
    """Sleepers stay asleep where they are, and whoever keeps a state changes nothing."""
    first, again = backends
    for number in range(40):
        move(first, number)
    assert (first.state()["engine"]["asleep"] >= 0).any()
    again.set_state(unpack(pack(first.state())))
    for number in range(40, 70):
        move(first, number)
        move(again, number)
        assert pack(first.state()) == pack(again.state())
    assert first.scene.of(BlockProps).blocks["2"].pose[2, 3] == pytest.approx(0.4, abs=1e-3)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("mujoco", np.zeros(3)),
        ("asleep", np.zeros(2, np.int64)),
        ("mujoco", None),
        ("asleep", np.array([0, 0, 0, -11])),
        ("pinned", {"body": 1}),
    ],
)
def test_anything_else_is_refused(backends: tuple[Any, Any], key: str, value: object) -> None:
    first, _ = backends
    state = first.state()
    with pytest.raises(NotAState):
        first.set_state({**state, "engine": {**state["engine"], key: value}})


def test_a_number_that_is_none_is_refused(backends: tuple[Any, Any]) -> None:
    first, _ = backends
    state = first.state()
    state["engine"]["mujoco"][5] = np.nan
    with pytest.raises(NotAState, match="isn't a number"):
        first.set_state(state)


def test_what_sleeps_where_the_arm_would_be_at_its_zero_sleeps_on() -> None:
    """MuJoCo, starting anew, has joints at their zero; nothing is woken by that."""
    table = {"name": "table", "x_m": 0.9, "y_m": 0.2, "size_m": [0.3, 0.3, 0.84], "foot_m": [0.2, 0.2]}
    blocks = [
        {"name": f"{number}", "x_m": x, "y_m": y, "height_m": 0.84}
        for number, (x, y) in enumerate(((0.84, 0.21), (0.92, 0.21), (0.84, 0.28)))
    ]
    start = {"x_m": 0.0, "y_m": 0.0}
    world = {"format": "handcart-world/1", "start": start, "tables": [table], "blocks": blocks}
    made = [MujocoBackend(load_robot("librarian"), world_model().model_validate(world), 0) for _ in range(2)]
    first, again = made
    for _ in range(20):
        first.step()
    again.set_state(unpack(pack(first.state())))
    engine = again._engine
    sleepers = engine.data.tree_asleep >= 0
    assert sleepers.sum() == len(blocks)
    mujoco().mj_step(engine.model, engine.data)
    assert (engine.data.tree_asleep[sleepers] >= 0).all()
    for backend in made:
        backend.close()
