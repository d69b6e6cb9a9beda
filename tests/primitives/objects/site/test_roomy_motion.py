"""Room that the arm keeps from walls, and parts of a bottom that an object stands on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.evaluation.trials.rig import Rig
from handcart.primitives.motions.arm_motion import collision_model
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.knowledge.objects import WALL_NAME, Objects
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.site.roomy_motion import (
    MAX_ROOM_M,
    certain_walls,
    move_straight_with_room,
    move_with_room,
    rooms,
    surroundings_to_try,
)
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause_kind import CauseKind
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box, bottom, top

from ..fetching import changed, rig_with

BOX = "surfaces:\n  box: {x_m: 4.0, y_m: 1.0, height_m: 0.3, size_m: [0.3, 0.3], walls: [+x], wall_m: 0.2}\n"


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Rig:
    folder = tmp_path_factory.mktemp("box")
    return rig_with(changed(folder, "objects.yaml", ("surfaces:\n", BOX)))


def view_of(rig: Rig) -> Any:
    return rig.model.view(LookFor(object="parcel_1"))  # type: ignore[arg-type]


@pytest.mark.parametrize(("sigma", "room"), [(0.004, 0.008), (0.5, MAX_ROOM_M)])
def test_room_at_walls_grows_with_the_uncertainty_of_the_base(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, sigma: float, room: float
) -> None:
    known = np.diag([sigma**2, 1e-8, 0.0])
    monkeypatch.setattr(type(rig.robot.localization), "covariance", property(lambda _: known))
    assert rooms(rig.robot, view_of(rig)) == pytest.approx((room, 0.0))


def test_without_walls_no_room_is_kept() -> None:
    plain = rig_with()
    assert rooms(plain.robot, view_of(plain)) == (0.0,)


def test_map_is_a_wall_in_what_is_tried_first(rig: Rig) -> None:
    """The robot is 1.0 m from two walls of the room; the map doesn't show how high they are."""
    tried = surroundings_to_try(rig.robot, view_of(rig))
    assert [any(body.name == WALL_NAME for body in bodies) for bodies in tried] == [True, True, True]
    map_T_base = rig.robot.pose.lift()
    walls = [body.seen_from(map_T_base) for body in tried[0] if body.name == WALL_NAME]
    assert all(top(body) > 2.0 and bottom(body) < 0.01 for body in walls)
    grid = rig.model.map
    shown = grid.to_point(np.argwhere(grid.occupied))
    near = shown[np.abs(shown - rig.robot.pose[:2]).max(axis=1) < 1.3]
    for cell in near:
        assert any((np.abs(body.pose[:2, 3] - cell) <= 0.5 * np.array(body.size[:2])).all() for body in walls)  # type: ignore[union-attr]


def test_unmapped_post_that_the_lidar_sees_is_a_wall_first(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Postures that the post blocks are tried among the walls of the map alone."""
    post = rig.robot.pose.apply(np.array([[0.6, 0.3]]))[0]
    monkeypatch.setattr(rig.model, "sensed_cells", np.array([[*post, 50.0, 0.0]]))
    tried = surroundings_to_try(rig.robot, view_of(rig))
    map_T_base = rig.robot.pose.lift()
    found = [
        any(
            (np.abs(body.seen_from(map_T_base).pose[:2, 3] - post) < 0.05).all()
            for body in bodies
            if body.name == WALL_NAME
        )
        for bodies in tried
    ]
    assert found == [True, True, False, False, False]
    assert all(any(body.name == WALL_NAME for body in bodies) for bodies in tried)


def test_walls_that_are_certain_end_within_their_cells(rig: Rig) -> None:
    """Where a lidar met a wall within a cell isn't known."""
    grid, objects = rig.model.map, rig.model.of(Objects)
    drawn, certain = (objects.walls_near(grid, rig.robot.pose, certain=certain) for certain in (False, True))
    assert len(drawn) == len(certain) > 0
    for box, core in zip(drawn, certain, strict=True):
        assert core.pose == pytest.approx(box.pose)
        thinner = np.array(box.size) - core.size
        assert thinner == pytest.approx([0.9 * grid.resolution, 0.9 * grid.resolution, 0.0])


@pytest.mark.parametrize(("over_m", "is_wall"), [(0.02, True), (-0.02, False)])
def test_what_the_arm_is_in_already_is_no_wall(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, over_m: float, is_wall: bool
) -> None:
    """It is low, or not where the map shows it; other walls are kept."""
    tip = (rig.robot.base_T("hand") @ [rig.robot.spec.finger_shape.tip, 0.0, 0.0, 1.0])[:3]
    map_T_base = rig.robot.pose.lift()
    near = Box(transform(tip + np.array([0.03 + over_m, 0.0, 0.0])), (0.06, 0.4, 2.4), WALL_NAME)
    far = Box(transform(tip + np.array([0.5, 0.0, 0.0])), (0.06, 0.4, 2.4), WALL_NAME)
    boxes = [wall.seen_from(map_T_base) for wall in (near, far)]
    monkeypatch.setattr(Objects, "walls_near", lambda *_, **__: boxes)
    found = [wall.pose[0, 3] for wall in certain_walls(rig.robot, view_of(rig))]
    assert found == pytest.approx([wall.pose[0, 3] for wall in ((near, far) if is_wall else (far,))])


def test_table_of_the_file_is_no_wall(rig: Rig) -> None:
    table = rig.model.of(Objects).objects.surfaces["table_a"]
    walls = rig.model.of(Objects).walls_near(rig.model.map, table.floor)
    assert len(walls) == 1
    assert table.margin(*walls[0].pose[:2, 3]) < -0.1


@pytest.mark.parametrize(("cause", "tries"), [(causes.NO_ARM_PATH, 4), (causes.ARM_BLOCKED, 1)])
def test_less_room_is_tried_where_no_path_has_it(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, cause: CauseKind, tries: int
) -> None:
    thickest = []

    def refused(robot: Any, joints: Any, held: Any, around: Any, *_: Any) -> Any:
        thickest.append(max(min(body.size) for body in around if body.name == "box"))
        raise Discrepancy("refused", cause=cause)
        yield

    monkeypatch.setattr("handcart.primitives.objects.site.roomy_motion.move_to_joints", refused)
    with pytest.raises(Discrepancy):
        list(move_with_room(rig.robot, view_of(rig), rig.robot.arm.command()))
    assert len(thickest) == tries


@pytest.mark.parametrize(("gap", "is_free"), [(0.04, False), (0.003, False), (0.0, True)])
def test_straight_motion_ends_before_walls_that_the_arm_is_clear_of(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, gap: float, is_free: bool
) -> None:
    """A wall in which the arm is already is a low obstacle, or not where the map shows it."""
    base_T_hand = rig.robot.base_T("hand")
    goal = base_T_hand.copy()
    goal[0, 3] += 0.06
    tip = (base_T_hand @ [rig.robot.spec.finger_shape.tip, 0.0, 0.0, 1.0])[:3]
    ahead = np.array([0.03 + gap, 0.0, 0.0])
    wall = Box(transform(tip + ahead), (0.06, 0.4, 2.4), WALL_NAME)
    monkeypatch.setattr("handcart.primitives.objects.site.roomy_motion.walls_to_try", lambda *_: [(wall,)])
    moved = True
    try:
        for _ in move_straight_with_room(rig.robot, view_of(rig), goal):
            rig.robot.step()
    except Discrepancy as no_way:
        assert no_way.cause is causes.NO_ARM_PATH
        moved = False
    assert moved is is_free


@pytest.mark.slow
def test_arm_within_its_margin_of_a_wall_goes_around_another_one(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, gap = rig.robot.arm.command(), 0.003
    base_T_hand = rig.robot.base_T("hand")
    tip = (base_T_hand @ [rig.robot.spec.finger_shape.tip, 0.0, 0.0, 1.0])[:3]
    ahead = Box(transform(tip + np.array([0.03 + gap, 0.0, 0.0])), (0.06, 0.4, 2.4), WALL_NAME)
    beside = Box(transform(tip + np.array([-0.02, 0.16, 0.0])), (0.02, 0.02, 2.4), WALL_NAME)
    walls = (ahead, beside)
    monkeypatch.setattr("handcart.primitives.objects.site.roomy_motion.walls_to_try", lambda *_: [walls])
    among = collision_model(rig.robot, None, walls)
    base_T_hand[:2, 3] += (-0.01, 0.32)
    goal = rig.robot.arm_model.inverse(base_T_hand, here)
    assert goal is not None
    clear = [among.distance(here)]
    assert clear == pytest.approx([gap], abs=1e-4)
    for _ in move_with_room(rig.robot, view_of(rig), goal):
        rig.robot.step()
        clear.append(among.distance(rig.robot.arm.command()))
    assert min(clear) > gap - 2e-4
    assert rig.robot.arm.command() == pytest.approx(goal, abs=1e-6)


def test_object_touches_the_level_parts_that_its_foot_reaches() -> None:
    at, size = {"y_m": 1.0, "height_m": 0.01}, {"size_m": [0.2, 0.3]}
    parts = {"left": {"x_m": 1.0, **at, **size}, "right": {"x_m": 1.2, **at, **size}}
    low = {"low": {"x_m": 1.2, "y_m": 1.0, "height_m": 0.05, **size}}
    file = ObjectsFile.model_validate(
        {"format": "handcart-objects/1", "kinds": {}, "surfaces": {**parts, **low}}
    )
    objects = Objects(objects=file)
    assert objects.touched_names("left", 1.08, 1.0, 0.03) == ("left", "right")
    assert objects.touched_names("left", 1.0, 1.0, 0.03) == ("left",)
