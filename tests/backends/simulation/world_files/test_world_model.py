"""The world's file as domains compose it."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar, Self

import numpy as np
import pytest
from pydantic import model_validator

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.rendering.renderer import Renderer
from handcart.backends.simulation.simulated_backend import build_scene
from handcart.backends.simulation.world.props import Props
from handcart.backends.simulation.world.solids import Solid
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.files.models.model import FileModel
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.tasks.domain import Domain, domains

ROOT = Path(__file__).resolve().parents[4]
SMALLEST = {"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}}


class Wanted(FileModel):
    tables: tuple[int, ...] = ()


class Alike(FileModel):
    @model_validator(mode="after")
    def _each_block_once(self) -> Self:
        return self


class Needed(FileModel):
    pots: int


class Rack(FileModel):
    rack_m: float = 1.0


class RackProps(Props[Rack]):
    section = Rack
    seen: ClassVar[list[str]] = []

    @classmethod
    def solids(cls, spec: Rack) -> list[Solid]:
        return [Solid(Box(transform((spec.rack_m, 0.0, 0.5)), (0.2, 0.2, 1.0), "rack"), grey=250)]


@pytest.fixture
def declare(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Adds a domain whose props have this section, or that has these props."""

    def add(section: type[FileModel], props: type[Props[Any]] | None = None) -> None:
        module: Any = ModuleType("outside_props")
        module.Found = props or type("Found", (Props,), {"section": section})
        monkeypatch.setitem(sys.modules, "outside_props", module)
        declared = (*domains(), Domain("outside", props="outside_props:Found"))
        monkeypatch.setattr("handcart.tasks.domain.domains", lambda: declared)

    return add


@pytest.mark.parametrize(
    ("section", "wrong"),
    [
        (Wanted, "the same name in their sections of a world: tables"),
        (Alike, "the same name in their sections of a world: _each_block_once"),
        (Needed, "a world can't be made to have pots; needed: a default"),
    ],
)
def test_a_section_that_cannot_stand_beside_the_others_is_refused(
    declare: Any, section: type[FileModel], wrong: str
) -> None:
    declare(section)
    with pytest.raises(ValueError, match=wrong):
        world_model()


def test_solids_of_a_domain_stand_in_the_way_and_are_seen(declare: Any) -> None:
    declare(Rack, RackProps)
    robot = load_robot("librarian")
    scene = build_scene(robot, world_model().model_validate(SMALLEST | {"rack_m": 2.0}), 0)
    away, name = scene.body_plan.clearance(1.0, 0.0, 0.0)
    assert away == pytest.approx(0.9)
    assert name == "rack"
    looks = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0.5], [0, 0, 0, 1.0]])
    picture = Renderer(_camera(), robot.errors, 0).ideal(scene, looks)
    assert picture[picture.shape[0] // 2, picture.shape[1] // 2] == 250


def _camera() -> Any:
    from handcart.backends.robot.mounted_camera import camera_model

    spec = load_robot("librarian").camera
    assert spec is not None
    return camera_model(spec)


@pytest.mark.parametrize("room", ["scene", "kinematic", "pybullet"])
def test_what_simulates_worlds_names_no_domain(room: str) -> None:
    """Domains have rooms of their own name in it."""
    words = re.compile(r"book|shel(f|ves)\b|\bblocks?\b|magazine|spine|\bseam|landmark", re.IGNORECASE)
    named = [
        f"{path.name}:{number}: {line.strip()}"
        for path in sorted((ROOT / "backends" / room).glob("*.py"))
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if words.search(line)
    ]
    assert named == []
