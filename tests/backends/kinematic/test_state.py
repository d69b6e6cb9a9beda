"""A restored world continues as if nothing had happened."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.backends.saved_state import pack, unpack
from handcart.backends.simulation.books.book_props import BookProps
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .conftest import Make, Puppet


def readings(puppet: Puppet) -> FloatArray:
    backend = puppet.backend
    capabilities: Any = backend.capabilities()
    base, arm, gripper, camera, ranges = capabilities
    return np.concatenate(
        [
            base.wheel_travel(),
            arm.joints(),
            arm.hand_force(),
            [gripper.width(), gripper.closed_on_something()],
            ranges.scan().ranges,
            camera.image().ravel()[::97],
            *(book.pose.ravel() for book in backend.scene.of(BookProps).books.values()),
        ]
    )


@pytest.mark.parametrize("stage", ["at first", "in the hand", "in the slot"])
def test_a_restored_world_goes_on_like_the_one_that_was_kept(puppet: Puppet, make: Make, stage: str) -> None:
    if stage == "in the hand":
        puppet.take_book()
    if stage == "in the slot":
        puppet.insert()
    kept = pack(puppet.backend.state())
    again = type(puppet)(make())
    again.backend.set_state(unpack(kept))
    for item in (puppet, again):
        item.backend._base.drive(0.0, 0.1)
        item.backend.step()
    assert np.array_equal(readings(puppet), readings(again), equal_nan=True)
    for item in (puppet, again):
        item.fingers(0.07)
        here = item.scene.arm.forward(item.arm.command())[:3, 3]
        item.to(here[0] - 0.05, here[1], here[2])
    assert np.array_equal(readings(puppet), readings(again), equal_nan=True)
    assert puppet.scene.contacts == again.scene.contacts


def test_a_world_that_went_on_is_put_back_too(puppet: Puppet) -> None:
    """Nothing of where it stood meanwhile is left in what was worked out of it."""
    puppet.take_book()
    backend, kept = puppet.backend, pack(puppet.backend.state())
    here = puppet.scene.arm.forward(puppet.arm.command())[:3, 3]

    def on() -> FloatArray:
        puppet.to(here[0], here[1], here[2] + 0.05)
        puppet.to(here[0], here[1], here[2] - 0.03)
        return readings(puppet)

    first = on()
    puppet.scene.move_base(puppet.scene.base.compose(Pose2(-0.3, 0.1, 0.7)))
    puppet.to(here[0], here[1], here[2] + 0.1)
    puppet.fingers(0.07)
    backend.set_state(unpack(kept))
    assert np.array_equal(first, on(), equal_nan=True)


@pytest.mark.slow
def test_what_was_worked_out_elsewhere_is_forgotten(puppet: Puppet, make: Make) -> None:
    """Things were moved as often there, so by their number of changes alone they could be the same."""
    backend, scene, first = puppet.backend, puppet.scene, pack(puppet.backend.state())

    def down_on_the_book(each: Puppet) -> list[float]:
        spine = each.scene.of(BookProps).tray_book().base_T_thing[:3, 3]
        each.to(spine[0] + 0.05, spine[1], 0.75)
        each.to(spine[0] + 0.05, spine[1], 0.60)
        return list(each.scene.joints)

    scene.move_base(scene.base.compose(Pose2(-0.3, 0.0, 0.0)))
    there, changes = pack(backend.state()), scene.changes
    backend.set_state(unpack(first))
    scene.move_base(scene.base.compose(Pose2(-0.6, 0.3, 0.5)))
    assert scene.changes == changes
    puppet.to(-0.10, 0.0, 0.80)
    backend.set_state(unpack(there))
    fresh = type(puppet)(make())
    fresh.backend.set_state(unpack(there))
    assert down_on_the_book(puppet) == down_on_the_book(fresh)
    assert puppet.scene.contacts == fresh.scene.contacts
    assert puppet.scene.contacts
