"""Lifting of a held object out from between others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.objects.holding.clearing import RISE_STEP_M, path_up
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box, Cylinder
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

HAND = transform((0.5, 0.0, 0.8), (0.0, np.pi / 2, 0.0))  # points down
BOOK = Box(transform((0.1, 0.0, 0.0), (0.0, -np.pi / 2, 0.0)), (0.15, 0.03, 0.2), "held")
NEIGHBOUR = Cylinder(transform((0.5, 0.1, 0.65)), 0.12, 0.22, "object book_2")


@pytest.fixture(scope="module")
def start() -> tuple[ArmModel, FloatArray]:
    robot = load_robot("librarian")
    arm = robot.arm_model()
    joints = arm.inverse(HAND, np.array(robot.posture("search_ready")), restarts=20)
    assert joints is not None
    return arm, joints


def test_held_object_goes_straight_up_out_of_a_neighbours_belief(start: tuple[ArmModel, FloatArray]) -> None:
    arm, here = start
    every, sure = CollisionModel(arm, (NEIGHBOUR,), BOOK), CollisionModel(arm, (), BOOK)
    assert every.in_collision(here)
    path = path_up(every, sure, here)
    assert path is not None
    assert not every.in_collision(path[-1])
    hands = np.array([arm.forward(joints)[:3, 3] for joints in path])
    assert np.abs(hands[:, :2] - HAND[:2, 3]).max() < 1e-3
    rise = hands[-1, 2] - HAND[2, 3]  # the foot is at 0.60 m, the neighbour's top at 0.76 m
    assert 0.16 - 1e-6 <= rise <= 0.16 + RISE_STEP_M + 1e-6


def test_held_object_is_not_lifted_into_a_board(start: tuple[ArmModel, FloatArray]) -> None:
    arm, here = start
    board = Box(transform((0.57, 0.0, 0.85)), (0.02, 0.1, 0.02), "board")
    every, sure = CollisionModel(arm, (NEIGHBOUR,), BOOK), CollisionModel(arm, (board,), BOOK)
    assert not sure.in_collision(here)
    assert path_up(every, sure, here) is None


def test_object_between_high_neighbours_stays(start: tuple[ArmModel, FloatArray]) -> None:
    arm, here = start
    high = CollisionModel(arm, (replace(NEIGHBOUR, length=1.4),), BOOK)
    assert path_up(high, CollisionModel(arm, (), BOOK), here) is None
