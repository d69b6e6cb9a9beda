"""Weights, forces of drives, and loads that are too heavy to hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.physics.engine.engine import Engine
from handcart.backends.physics.engine.thing_form import Cuboid, ThingForm
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.books.book_props import BookProps
from handcart.robotics.geometry.transform import transform

from .conftest import Hand, Make


def test_a_drive_gives_no_more_than_it_can(make: Make) -> None:
    for share, moves in ((1e-9, False), (1.0, True)):
        backend = make()
        arm = backend.scene.arm
        assert arm is not None
        joint = arm.joint_names[0]
        group = backend._body.joints([joint])
        for _ in range(20):
            group.turn(np.array([0.5]), np.array([share * backend._body.effort[joint]]))
            backend._engine.step()
        assert bool(abs(group.states()[1][0] - 0.5) < 0.1) is moves


def cube(height: float) -> ThingForm:
    """100 mm wide and 1 kg, its middle at that height in [m]."""
    size = (0.1, 0.1, 0.1)
    face = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    pieces, picture = (Cuboid(size),), np.zeros((4, 4), np.uint8)
    return ThingForm(transform((0.6, 2.2, height)), size, 1.0, pieces, 0.5, (face,) * 6, picture)


def short_of_sleep(engine: Engine) -> Engine:
    """With steps of 5 ms in each engine: in a whole period what lies still may go to sleep."""
    engine.substeps = 2
    return engine


def test_what_touched_nothing_can_be_touched_again(make: Make) -> None:
    engine = short_of_sleep(make()._engine)
    lower, upper = engine.add_thing(cube(0.05)), engine.add_thing(cube(0.15))
    engine.touches(upper, False)
    engine.pose(engine.add_thing(cube(3.0)))  # the world has grown while it touched nothing
    for touches in (False, True):
        engine.touches(upper, touches)
        engine.set_pose(upper, transform((0.6, 2.2, 0.15)))
        engine.step()
        assert any(touching.other == upper for touching in engine.touching(lower)) is touches


@pytest.mark.parametrize("mass", [1.0, 3.0])
def test_what_is_weighed_anew_presses_with_its_new_weight(make: Make, mass: float) -> None:
    engine = short_of_sleep(make()._engine)
    number = engine.add_thing(cube(0.05))
    engine.weigh(number, mass)
    for _ in range(6):
        engine.step()
    assert sum(contact.force[2] for contact in engine.contacts(number)) == pytest.approx(
        9.81 * mass, rel=0.05
    )


@pytest.mark.slow
@pytest.mark.parametrize(("mass", "slips"), [(0.5, False), (40.0, True)])
def test_what_is_too_heavy_slips_from_the_hand(hand: Hand, mass: float, slips: bool) -> None:
    backend: PhysicsBackend = hand.backend
    book = backend.scene.of(BookProps).books[117]
    hand.take_book()
    here = hand.model.forward(hand.arm.command())[:3, 3]
    hand.line(here[0], here[1], here[2] + 0.08)
    before = backend.link_pose("hand")[2, 3] - book.pose[2, 3]
    backend._engine.weigh(backend._world.bodies[book.name], mass)
    for _ in range(20):
        backend.step()
    slid = backend.link_pose("hand")[2, 3] - book.pose[2, 3] - before
    assert bool(0.05 < slid < 1.0) is slips


@pytest.mark.slow
def test_a_base_that_turns_does_not_hop_and_what_stands_on_it_stays(make: Make) -> None:
    backend = make()
    body, engine = backend._body, backend._engine
    base: Any = next(capability for capability in backend.capabilities() if isinstance(capability, Base))
    for _ in range(10):
        backend.step()
    book = backend.ground_truth().bodies["book 117"]
    pressed = []
    for number in range(60):
        base.drive(0.0, 0.6 * min(1.0, number / 20, (59 - number) / 20))
        backend.step()
        wheels = {body.link_index["left_wheel"], body.link_index["right_wheel"]}
        pressed.append(
            sum(contact.force[2] for contact in engine.contacts(body.id) if contact.link in wheels)
        )
    assert np.std(pressed) < 0.1 * np.mean(pressed)
    now = backend.ground_truth().bodies["book 117"]
    assert (book.support, now.support) == ("tray", "tray")
    assert np.linalg.norm(now.pose[:3, 3] - book.pose[:3, 3]) < 0.5e-3
