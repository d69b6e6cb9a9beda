"""A book stays where it is in the hand while its robot drives."""

from __future__ import annotations

import pytest

from benchmarks.physics.held_book import HeldBook
from handcart.backends.mujoco.mujoco_backend import MujocoBackend


@pytest.mark.slow
def test_a_book_does_not_slide_in_the_hand_for_a_minute_of_driving() -> None:
    held = HeldBook(MujocoBackend)
    held.take()
    slid = held.drive(60.0)
    turned = abs(held.backend.scene.base.theta - held.stood.theta)
    held.backend.close()
    assert held.backend.scene.held is held.book
    assert turned > 0.0
    assert slid.mm < 0.1
    assert slid.mrad < 1.0
