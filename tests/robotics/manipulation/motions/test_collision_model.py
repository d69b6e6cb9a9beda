"""Contacts and clearances with known answers."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box, Cylinder, Sphere
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

STRETCHED = np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
FOLDED = np.array([-1.6405, -1.1, 2.6568, -1.6404, -1.5718, 0.014])


def _ahead_of_fingers(arm: ArmModel, gap: float) -> Box:
    """A box `gap` [m] before the fingertips, facing them."""
    return Box(arm.forward(STRETCHED) @ transform((0.15 + gap + 0.05, 0.0, 0.0)), (0.1, 0.1, 0.1), "wall")


def test_free_without_obstacles(arm: ArmModel) -> None:
    collision = CollisionModel(arm)
    assert not collision.in_collision(STRETCHED)
    assert collision.contacts(STRETCHED) == []


def test_arm_meets_itself_and_its_base(arm: ArmModel) -> None:
    collision = CollisionModel(arm)
    into_deck = np.array([-0.7, 0.7, 1.2, 0.0, 0.0, 0.0])
    assert collision.in_collision(into_deck)
    assert any("base" in pair or "tray" in pair for pair in collision.contacts(into_deck))


@pytest.mark.parametrize("gap", [0.001, 0.02, 0.03])
def test_distance_is_the_gap(arm: ArmModel, gap: float) -> None:
    collision = CollisionModel(arm, [_ahead_of_fingers(arm, gap)])
    assert collision.distance(STRETCHED) == pytest.approx(gap, abs=1e-5)
    assert not collision.in_collision(STRETCHED)


def test_penetration_is_negative_and_named(arm: ArmModel) -> None:
    collision = CollisionModel(arm, [_ahead_of_fingers(arm, -0.004)])
    assert collision.distance(STRETCHED) == pytest.approx(-0.004, abs=1e-4)
    assert collision.contacts(STRETCHED) == [("left_finger", "wall"), ("right_finger", "wall")]


def test_margin(arm: ArmModel) -> None:
    wall = _ahead_of_fingers(arm, 0.008)
    assert CollisionModel(arm, [wall], margin=0.01).in_collision(STRETCHED)
    assert not CollisionModel(arm, [wall], margin=0.005).in_collision(STRETCHED)


def test_obstacles_may_be_given_in_the_world(arm: ArmModel) -> None:
    world_T_base = transform((2.0, -1.0, 0.0), (0.0, 0.0, 2.0))
    wall = _ahead_of_fingers(arm, -0.01)
    in_world = wall.seen_from(world_T_base)
    assert CollisionModel(arm, [in_world], world_T_base=world_T_base).in_collision(STRETCHED)
    assert not CollisionModel(arm, [in_world]).in_collision(STRETCHED)


def test_held_book_reaches_further(arm: ArmModel) -> None:
    wall = _ahead_of_fingers(arm, 0.05)
    book = Box(transform((0.20, 0.0, 0.0)), (0.16, 0.03, 0.22))
    assert not CollisionModel(arm, [wall]).in_collision(STRETCHED)
    holding = CollisionModel(arm, [wall], held=book)
    assert holding.contacts(STRETCHED) == [("held", "wall")]
    assert not CollisionModel(arm, [wall], held=book, allowed=[("wall", "held")]).in_collision(STRETCHED)


@pytest.mark.parametrize(
    "body",
    [Cylinder(np.eye(4), 0.05, 0.1, "body"), Sphere(np.eye(4), 0.05, "body")],
    ids=["cylinder", "sphere"],
)
def test_other_shapes(arm: ArmModel, body: Cylinder | Sphere) -> None:
    pose = arm.forward(STRETCHED) @ transform((0.15 + 0.05 + 0.01, 0.0, 0.0))
    placed = (
        Sphere(pose, body.radius, body.name)
        if isinstance(body, Sphere)
        else Cylinder(pose, body.radius, body.length, body.name)
    )
    assert CollisionModel(arm, [placed]).distance(STRETCHED) == pytest.approx(0.01, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("boards", [1, 4])
def test_check_distance_and_contacts_agree(arm: ArmModel, boards: int) -> None:
    """Also where coal, asked without margin, would call overlapping bodies free."""
    places = [(0.6, -0.5 + 0.04 * k, 0.8 + 0.5 * board) for board in range(boards) for k in range(25)]
    shelf = [Box(transform(place), (0.15, 0.03, 0.2), f"book_{k}") for k, place in enumerate(places)]
    collision = CollisionModel(arm, shelf, held=Box(transform((0.19, 0.0, 0.0)), (0.14, 0.03, 0.2)))
    postures = np.random.default_rng(1).uniform(arm.lower, arm.upper, (600, 6))
    hits = [collision.in_collision(q) for q in postures]
    assert hits == [collision.distance(q) <= 1e-6 for q in postures]
    assert hits == [bool(collision.contacts(q)) for q in postures]
    assert 0.1 < np.mean(hits) < 0.9


def test_line_meets_what_stands_between(arm: ArmModel) -> None:
    post = Cylinder(transform((0.6, 0.215, 1.0)), 0.02, 1.0, "post")
    collision = CollisionModel(arm, [post])
    left, right = (np.array([angle, -0.3, 0.8, 0.0, -0.5, 0.0]) for angle in (0.6, -0.6))
    assert not collision.in_collision(left) and not collision.in_collision(right)
    assert not collision.line_free(left, right)
    assert collision.path_free(np.array([left, left]))


def test_eased_model_lets_no_close_body_come_closer(arm: ArmModel) -> None:
    close = CollisionModel(arm, [_ahead_of_fingers(arm, 0.003)], margin=0.005)
    assert close.in_collision(STRETCHED)
    eased = close.eased_at(STRETCHED)
    assert not eased.in_collision(STRETCHED)
    down = STRETCHED + 0.02 * np.eye(6)[4]
    up = STRETCHED - 0.02 * np.eye(6)[4]
    assert [eased.in_collision(q) for q in (down, up)] == [close.distance(q) < 0.0029 for q in (down, up)]
    touching = CollisionModel(arm, [_ahead_of_fingers(arm, -0.001)], margin=0.005)
    assert touching.eased_at(STRETCHED).in_collision(STRETCHED)


def test_eased_model_keeps_the_margin_to_others(arm: ArmModel) -> None:
    aside = Box(arm.forward(STRETCHED) @ transform((0.1, 0.3, 0.0)), (0.1, 0.1, 0.1), "aside")
    model = CollisionModel(arm, [_ahead_of_fingers(arm, 0.003), aside], margin=0.005)
    turned = next(
        q
        for angle in np.arange(0.0, 1.0, 1e-3)
        if 0.0 < CollisionModel(arm, [aside]).distance(q := STRETCHED + angle * np.eye(6)[0]) < 0.004
    )
    assert model.eased_at(STRETCHED).in_collision(turned)
