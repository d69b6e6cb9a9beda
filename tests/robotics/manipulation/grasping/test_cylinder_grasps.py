"""Grasps around a cylinder."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.manipulation.grasping.cylinder_grasps import AROUND_SIDE, cylinder_grasps

TIP = 0.12


def test_pads_close_across_the_axis_of_a_cylinder() -> None:
    found = list(cylinder_grasps(0.066, 0.115, 0.09, TIP))
    assert {grasp_.face for grasp_ in found} == {"+z", AROUND_SIDE}
    for grasp in found:
        pose = grasp.box_T_hand
        tips, closing = pose[:3, 3] + TIP * pose[:3, 0], pose[:3, 1]
        assert grasp.width == pytest.approx(0.066)
        assert abs(closing @ tips) < 1e-12  # the pads are as far from the axis on both sides
        assert abs(closing[2]) < 1e-12
        assert 0.0 < tips[2] < 0.115


def test_hands_never_come_from_below() -> None:
    assert max(grasp.box_T_hand[2, 0] for grasp in cylinder_grasps(0.066, 0.115, 0.09, TIP)) < 1e-12


def test_flat_disc_is_taken_by_its_ends() -> None:
    found = list(cylinder_grasps(0.2, 0.04, 0.09, TIP))
    assert {grasp.width for grasp in found} == {0.04}
    assert all(abs(grasp.box_T_hand[2, 1]) == 1.0 for grasp in found)


def test_first_grasp_from_aside_comes_from_the_robot() -> None:
    grasp = next(cylinder_grasps(0.066, 0.115, 0.09, TIP, towards=0.7, above=False))
    assert np.allclose(grasp.box_T_hand[:3, 0], [-np.cos(0.7), -np.sin(0.7), 0.0])
