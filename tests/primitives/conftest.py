"""A robot on the kinematic backend in a small world, with what it knows of it."""

from __future__ import annotations

import re
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.robot.robot import Robot
from handcart.backends.simulation.books.book_props import BookProps
from handcart.primitives.books.book_boxes import held_box
from handcart.primitives.books.books import Books, Slot
from handcart.primitives.books.catalogue import Book
from handcart.primitives.books.pick_up import PickUp
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.knowledge.place import Place, Shelf
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.motions.arm_motion import move_to_pose
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Outcome, Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse, transform
from handcart.robotics.navigation.maps.grid_map import FloorBox, from_boxes

WORLD = """\
format: handcart-world/1
start: {x_m: 1.0, y_m: 1.0, heading_deg: 90}
walls:
  - {from_m: [0, 0], to_m: [8, 0]}
  - {from_m: [8, 0], to_m: [8, 6]}
  - {from_m: [8, 6], to_m: [0, 6]}
  - {from_m: [0, 6], to_m: [0, 0]}
furniture:
  - {name: desk, x_m: 3, y_m: 3, heading_deg: 0, size_m: [1.2, 1.6, 0.75]}
shelves:
  - name: shelf_1
    x_m: 6.5
    y_m: 5.4
    heading_deg: 90
    books:
      - {accession: 3, call: "512.2 ABE", thickness_mm: 25, height_mm: 210, depth_mm: 150}
"""
MAPPED = (
    FloorBox(4.0, 0.0, 0.0, 8.1, 0.1),
    FloorBox(4.0, 6.0, 0.0, 8.1, 0.1),
    FloorBox(0.0, 3.0, 0.0, 0.1, 6.1),
    FloorBox(8.0, 3.0, 0.0, 0.1, 6.1),
    FloorBox(3.0, 3.0, 0.0, 1.2, 1.6),
    FloorBox(6.5, 5.525, 0.0, 1.04, 0.25),
)
HOME = Place(x_m=1.0, y_m=1.0, heading_deg=90.0)
SHELF = Place(
    x_m=6.5,
    y_m=4.93,
    heading_deg=90.0,
    shelf=Shelf(distance_m=0.47, width_m=1.0, board_m=0.7, front_m=1.04),
)

TRAY_BOOK = Book(
    accession=117,
    call="512.7 NAG",
    title="",
    shelf="shelf_1",
    thickness_mm=25.0,
    height_mm=210.0,
    depth_mm=150.0,
)
TRAY = "tray: {accession: 117, call: 512.7 NAG, thickness_mm: 25, height_mm: 210, depth_mm: 150, grey: 115}\n"
GAP_MM = 31
GAP_MIDDLE = 0.5 - 8 * 0.04 - GAP_MM / 2e3  # y in the shelf frame of the gap's middle, in [m]


def row() -> str:
    """Return eight books of 40 mm, a gap and two more books, as lines of the shelf's list in the world
    file.
    """
    book = "      - {{accession: {0}, call: 51{1} ABE, thickness_mm: 40, height_mm: 210, depth_mm: 150}}"
    calls = [f"0.{number}" for number in range(8)], ["2.8", "3.1"]
    left, right = ([book.format(10 + i + 10 * k, c) for i, c in enumerate(calls[k])] for k in (0, 1))
    return "\n".join([*left, f"      - {{gap_mm: {GAP_MM}}}", *right]) + "\n"


@dataclass
class Rig:
    """Robot, its world model, and the truth of its simulated world (for tests alone)."""

    robot: Robot
    model: WorldModel
    scene: Any
    restored: list[str] = field(default_factory=list)

    def run(self, primitive: ActionPrimitive, cancel: Callable[[], bool] = lambda: False) -> Outcome:
        """One attempt to its outcome; cancelled in the first period in which `cancel` holds."""
        periods = attempt(primitive, self.robot, self.model, self.restored.append)
        outcome: Outcome = self.drive(periods, cancel)
        return outcome

    def drive(self, periods: Generator[None, None, Any], cancel: Callable[[], bool] = lambda: False) -> Any:
        """Step the robot until the generator ends; gives its value."""
        cancelled = False
        while True:
            try:
                if not cancelled and cancel():
                    cancelled = True
                    periods.throw(Discrepancy("cancelled by the operator"))
                else:
                    next(periods)
            except StopIteration as end:
                return end.value
            self.robot.step()

    def book_is_recognized(self) -> None:
        """Put the book on the tray and its true pose into the model, without RECOGNIZE's errors."""
        pose = self.scene.of(BookProps).tray_book().base_T_thing
        self.model.of(Books).book = TRAY_BOOK
        self.model.of(Books).book_pose = Pose2(
            pose[0, 3], pose[1, 3], float(np.arctan2(pose[1, 0], pose[0, 0]))
        )


@pytest.fixture
def make_rig(tmp_path: Path) -> Callable[..., Rig]:
    """Builds a rig: more lines for the world's file, a seed, other keys of the lidar and of errors."""

    def make(
        more: str = "",
        seed: int = 0,
        walls: tuple[FloorBox, ...] = (),
        furniture: str = "",
        start_y: float = 1.0,
        localizer: str = "scan",
        lidar: Mapping[str, Any] | None = None,
        errors: Mapping[str, Any] | None = None,
        robot: str = "librarian",
    ) -> Rig:
        world = tmp_path / "world.yaml"
        text = WORLD.replace("shelves:\n", furniture + "shelves:\n").replace(
            "y_m: 1.0,", f"y_m: {start_y},", 1
        )
        world.write_text(text + more, encoding="utf-8")
        spec = load_robot(robot).model_copy(update={"localizer": localizer})
        assert spec.range_sensor is not None
        sensor = RangeSpec.model_validate({**spec.range_sensor.model_dump(), **(lidar or {})})
        erring = spec.errors.model_copy(update=dict(errors or {}))
        spec = spec.model_copy(update={"range_sensor": sensor, "errors": erring})
        backend = make_backend("kinematic", spec, world, seed)
        grid = from_boxes(MAPPED + walls, 0.02, (-0.3, -0.3), (8.6, 6.6))
        model = WorldModel(grid, {"home": HOME, "shelf_1": SHELF})
        start = HOME.pose._replace(y=start_y) if start_y != 1.0 else HOME.pose
        return Rig(Robot(backend, spec, start, grid), model, backend.scene)  # type: ignore[attr-defined]

    return make


@pytest.fixture
def at_slot(make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch) -> Callable[..., Rig]:
    """Return a maker of rigs docked at the shelf, with the held book 50 mm before its slot, 5 mm above the
    board.

    `aside` in [m]: offset of the book to the left of the slot's middle; `shelf`: more lines about the
    shelf.
    """
    here = f"start: {{x_m: {SHELF.x_m}, y_m: {SHELF.y_m}, heading_deg: 90}}"
    docked = re.sub(r"start: .*", here, re.sub(r" +- \{accession: 3,.*\n", "", WORLD))
    monkeypatch.setitem(globals(), "WORLD", docked)
    monkeypatch.setitem(globals(), "HOME", SHELF)

    def make(aside: float = 0.0, seed: int = 0, shelf: str = "") -> Rig:
        rig = make_rig(row() + shelf + TRAY, seed=seed)
        rig.book_is_recognized()
        assert isinstance(rig.run(PickUp()), Success)
        base_T_shelf = inverse(rig.scene.world_T_base) @ rig.scene.of(BookProps).shelves["shelf_1"].pose
        before = transform((-0.05 - 0.12 - 0.15, GAP_MIDDLE + aside, 0.125))
        rig.drive(move_to_pose(rig.robot, base_T_shelf @ before, held_box(rig.robot, TRAY_BOOK)))
        half = GAP_MM / 2e3
        rig.model.of(Books).slot = Slot(
            "shelf_1", GAP_MIDDLE + half, GAP_MIDDLE - half, 0.001, "510.7 ABE", "512.8 ABE"
        )
        return rig

    return make
