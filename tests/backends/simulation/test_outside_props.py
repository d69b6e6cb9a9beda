"""An outside domain has its own things in simulated worlds, on both backends: docs/how_to/domains.md."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import check_world, make_backend
from handcart.backends.saved_state import pack, unpack
from handcart.backends.simulation.world.thing import Rest
from handcart.files.errors import FileError
from handcart.robotics.geometry.transform import inverse, transform
from handcart.tasks.domain import Domain, domains

CODE = next(
    match
    for match in re.findall(
        r"```python\n(.*?)```",
        (Path(__file__).parents[3] / "docs" / "how_to" / "domains.md").read_text(encoding="utf-8"),
        re.DOTALL,
    )
    if "class PotProps" in match
)
WORLD = """\
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0}
tables:
  - {name: table, x_m: 0.08, y_m: 0.65, size_m: [0.66, 0.76, 0.4], foot_m: [0.3, 0.2]}
pots:
  - {name: basil, on: robot, x_m: -0.26, y_m: 0.0, height_m: 0.45, size_mm: [40, 40, 50]}
  - {name: mint, x_m: 0.15, y_m: 0.45, height_m: 0.4, size_mm: [40, 40, 50], level_ml: 0}
"""
ROBOT = load_robot("toyama").without_errors()
DOWN = transform(rpy=(0.0, np.pi / 2, 0.0)) @ transform(rpy=(-np.pi / 2, 0.0, 0.0))
OVER = 0.165  # [m] from the foot of what is gripped up to the hand


@pytest.fixture(autouse=True)
def plants(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The module that the document shows, and its domain declared."""
    module: Any = ModuleType("plants_props")
    monkeypatch.setitem(sys.modules, "plants_props", module)
    exec(compile(CODE, "docs/how_to/domains.md", "exec"), vars(module))
    declared = (*domains(), Domain("plants", props="plants_props:PotProps"))
    monkeypatch.setattr("handcart.tasks.domain.domains", lambda: declared)
    return module


@pytest.fixture
def world(tmp_path: Path) -> Path:
    path = tmp_path / "world.yaml"
    path.write_text(WORLD, encoding="utf-8")
    return path


@pytest.fixture(params=["kinematic", "mujoco", "pybullet"])
def make(request: pytest.FixtureRequest, world: Path, plants: Any) -> Iterator[Callable[[], Any]]:
    if request.param == "pybullet":
        pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    made: list[Backend] = []

    def build() -> Any:
        made.append(make_backend(request.param, ROBOT, world, 0))
        return made[-1]

    yield build
    for backend in made:
        backend.close()


def go(backend: Any, x: float, y: float, z: float, speed: float = 0.3) -> None:
    """Move the hand straight, pointing down, its fingers closing along x."""
    arm, model = backend.get(Arm), backend.scene.arm
    start = model.forward(arm.command())[:3, 3]
    goal = np.array([x, y, z])
    count = max(2, int(np.linalg.norm(goal - start) / speed / backend.period))
    for share in np.linspace(0.0, 1.0, count + 1)[1:]:
        joints = arm.command()
        near = model.inverse(transform(tuple(start + share * (goal - start))) @ DOWN, joints)
        while not np.allclose(joints, near):
            joints = joints + np.clip(near - joints, -0.09, 0.09)
            arm.move(joints)
            backend.step()


def grip(backend: Any, width: float) -> None:
    backend.get(Gripper).move(width)
    for _ in range(24):
        backend.step()


def weight(backend: Any) -> float:
    """Felt in the hand, which points down, in [N]."""
    readings = []
    for _ in range(4):
        backend.step()
        readings.append(backend.get(Arm).hand_force()[0])
    return float(np.mean(readings))


@pytest.mark.slow
def test_it_is_gripped_weighed_and_let_go(make: Callable[[], Any], plants: Any) -> None:
    backend = make()
    pot = backend.scene.of(plants.PotProps).pots["basil"]
    assert pot.rest is Rest.TRAY
    go(backend, -0.26, 0.0, 0.45 + OVER)
    empty = weight(backend)
    grip(backend, 0.0)
    assert backend.scene.held is pot
    assert pot.rest is Rest.HAND  # type: ignore[comparison-overlap]
    go(backend, -0.26, 0.0, 0.45 + OVER + 0.05)
    assert pot.pose[2, 3] == pytest.approx(0.5, abs=2e-3)
    full = weight(backend)
    assert full - empty == pytest.approx(9.81 * pot.mass, abs=0.1)
    pot.level_ml = 10.0
    assert full - weight(backend) == pytest.approx(9.81 * 0.09, abs=0.1)
    go(backend, -0.26, 0.0, 0.45 + OVER + 0.001)
    grip(backend, 0.05)
    assert backend.scene.held is None
    assert pot.rest is Rest.TRAY
    assert pot.pose[2, 3] == pytest.approx(0.45, abs=1e-3)


def test_the_camera_sees_how_full_it_is(make: Callable[[], Any], plants: Any) -> None:
    backend = make()
    pot = backend.scene.of(plants.PotProps).pots["basil"]
    go(backend, -0.26, 0.0, 0.75)
    greys = []
    for level in (100.0, 40.0):
        pot.level_ml = level
        backend.step()
        camera = backend.get(Camera)
        world_T_camera = backend.scene.world_T("hand") @ camera.hand_T_camera
        top = inverse(world_T_camera) @ pot.pose @ (0.0, 0.0, 0.05, 1.0)
        column, row = np.rint((camera.model.K @ (top[:3] / top[2]))[:2]).astype(int)
        greys.append(float(camera.image()[row - 3 : row + 4, column - 3 : column + 4].mean()))
    assert greys[0] - greys[1] == pytest.approx(120.0, abs=15.0)


def test_it_changes_each_period_and_is_kept(make: Callable[[], Any], plants: Any) -> None:
    backend = make()
    pot = backend.scene.of(plants.PotProps).pots["basil"]
    for _ in range(10):
        backend.get(Base).drive(0.2, 0.0)
        backend.step()
    assert pot.level_ml == pytest.approx(100.0 - 10 * plants.DRIES)
    base_T_pot = inverse(backend.scene.world_T_base) @ pot.pose
    assert base_T_pot[:3, 3] == pytest.approx((-0.26, 0.0, 0.45), abs=2e-3)
    again = make()
    again.set_state(unpack(pack(backend.state())))
    kept, now = again.scene.of(plants.PotProps).pots, backend.scene.of(plants.PotProps).pots
    assert {name: pot.level_ml for name, pot in kept.items()} == {
        name: pot.level_ml for name, pot in now.items()
    }
    assert np.abs(kept["basil"].pose - now["basil"].pose).max() < 1e-9


def test_its_keys_are_checked_with_the_rest_of_the_world(world: Path) -> None:
    check_world(world, ROBOT)
    world.write_text(WORLD.replace("level_ml: 0", "levl_ml: 0").replace("tables", "tabels"), encoding="utf-8")
    with pytest.raises(FileError) as wrong:
        check_world(world, ROBOT)
    assert [str(finding).split(":", 1)[1].split(";")[0] for finding in wrong.value.findings] == [
        "3:1: unknown key 'tabels'",
        "7:78: unknown key 'levl_ml'",
    ]
