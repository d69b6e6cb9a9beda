"""Views of a spot past the object in the hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.mounted_camera import HAND_LINK
from handcart.primitives.objects.knowledge.aimed_view import hidden_count
from handcart.primitives.objects.looking import spot_look
from handcart.primitives.objects.looking.view_plan import view_joints
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

SPOT = np.array([0.5, 0.0, 0.5])
SIDES = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
FOOT = SPOT + SIDES * (0.095, 0.035, 0.0)
BOOK = Box(transform((0.12, 0.0, 0.0), (0.0, -np.pi / 2, 0.0)), (0.152, 0.03, 0.2), "held")
TURNS = np.linspace(0.0, 2.0 * np.pi, 24)
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def robot() -> Any:
    spec = load_robot("librarian")
    along = np.eye(4)
    along[:3, :3] = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
    home = np.array(spec.posture("search_ready"))
    return SimpleNamespace(
        view_camera=SimpleNamespace(carrier=HAND_LINK),
        camera=SimpleNamespace(hand_T_camera=transform((0.0, 0.0, 0.11)) @ along),
        arm=SimpleNamespace(command=lambda: home),
        arm_model=spec.arm_model(),
    )


def test_view_past_the_held_object_comes_first(robot: Any) -> None:
    collision = CollisionModel(robot.arm_model, held=BOOK)
    nearest = view_joints(robot, collision, SPOT, [UP], (0.3,))
    shown = view_joints(robot, collision, SPOT, [UP], (0.3,), FOOT)
    assert nearest is not None and shown is not None
    assert hidden_count(collision, *nearest, FOOT) > 0
    assert hidden_count(collision, *shown, FOOT) == 0


def test_view_of_a_part_is_better_than_none(robot: Any) -> None:
    collision = CollisionModel(robot.arm_model, held=BOOK)
    ring = SPOT + np.column_stack([0.12 * np.cos(TURNS), 0.12 * np.sin(TURNS), 0.0 * TURNS])
    part = view_joints(robot, collision, SPOT, [UP], (0.3,), ring)
    assert part is not None
    assert 0 < hidden_count(collision, *part, ring) < len(ring)


def test_view_over_a_wall_before_the_spot_comes_first(robot: Any) -> None:
    """Seen from behind it, the wall itself would look like something at the spot."""
    foot = SPOT + SIDES * (0.03, 0.03, 0.0)
    wall = Box(transform((0.43, 0.0, 0.60)), (0.01, 0.4, 0.2), "wall")
    low, high = np.array([-0.6, 0.0, 0.8]), np.array([0.0, 0.0, 1.0])
    for around, direction in (((), low), ((wall,), high)):
        collision = CollisionModel(robot.arm_model, around)
        found = view_joints(robot, collision, SPOT, [low, high], (0.3,), foot)
        assert found is not None
        assert hidden_count(collision, *found, foot) == 0
        assert found[1][:3, 3] == pytest.approx(SPOT + 0.3 * direction, abs=0.01)


@pytest.mark.parametrize(("top", "share"), [(0.5, 1.0), (0.6, 0.6), (0.66, None)])
def test_of_a_spot_behind_a_wall_only_what_is_seen_counts(
    robot: Any, monkeypatch: pytest.MonkeyPatch, top: float, share: float | None
) -> None:
    """The wall hides what is low behind it from a camera that looks over it."""
    walls = (Box(transform((0.38, 0.0, top / 2)), (0.01, 0.4, top), "wall"),)
    monkeypatch.setattr(spot_look, "surroundings", lambda *_: walls)
    monkeypatch.setattr(
        spot_look, "collision_model", lambda _, held, around: CollisionModel(robot.arm_model, around)
    )
    looks = transform((0.0, 0.0, 1.0))
    looks[:3, :3] = [[0.0, -0.7, 0.7], [-1.0, 0.0, 0.0], [0.0, -0.7, -0.7]]
    foot = SPOT + SIDES * (0.1, 0.05, 0.0)
    seen = spot_look._seen_part(robot, None, looks, foot)  # type: ignore[arg-type]
    if share is None:
        assert seen is None
        return
    assert seen is not None
    assert seen[:, 0].max() == pytest.approx(0.6, abs=1e-6)
    assert np.ptp(seen[:, 0]) == pytest.approx(share * 0.2, abs=0.03)
    assert np.ptp(seen[:, 1]) == pytest.approx(0.1, abs=1e-6)
