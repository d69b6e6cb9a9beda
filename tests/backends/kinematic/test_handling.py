from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.pose2 import Pose2

from .conftest import Puppet


def front(puppet: Puppet, accession: int) -> Any:
    standing = puppet.scene.of(BookProps).shelf_books("shelf_1")
    return next(book for book in standing if book.book.accession == accession)


def test_the_gripper_takes_the_book_from_the_tray_and_carries_it(puppet: Puppet) -> None:
    puppet.take_book()
    assert puppet.scene.held is puppet.scene.of(BookProps).books[117]
    assert puppet.gripper.closed_on_something()
    assert puppet.gripper.width() == pytest.approx(0.025, abs=3e-4)
    foot = puppet.scene.of(BookProps).book_pose(117)[2, 3]
    puppet.to(-0.02, 0.0, 0.78)
    assert puppet.scene.of(BookProps).book_pose(117)[2, 3] - foot == pytest.approx(0.08, abs=1e-3)
    assert puppet.scene.contacts == []


def test_a_stop_holds_what_is_held_and_where_the_fingers_are(puppet: Puppet) -> None:
    puppet.take_book()
    puppet.backend.stop()
    for _ in range(5):
        puppet.backend.step()
    assert puppet.gripper.closed_on_something()
    assert puppet.gripper.command() == 0.0
    puppet.gripper.move(0.06)
    for _ in range(3):
        puppet.backend.step()
    puppet.backend.stop()
    width = puppet.scene.width
    for _ in range(5):
        puppet.backend.step()
    assert 0.025 < width < 0.06
    assert puppet.scene.width == width


def test_closing_on_nothing_the_fingers_meet(puppet: Puppet) -> None:
    puppet.fingers(0.0)
    assert puppet.scene.held is None
    assert puppet.gripper.width() == pytest.approx(0.0, abs=3e-4)
    assert puppet.gripper.closed_on_something()


def test_a_book_set_back_onto_the_tray_stands_there_and_rides_along(puppet: Puppet) -> None:
    puppet.take_book()
    here = puppet.scene.arm.forward(puppet.arm.command())[:3, 3]
    puppet.to(here[0], here[1], here[2] + 0.05)
    puppet.to(here[0], here[1], here[2] + 0.01)
    puppet.fingers(0.06)
    book = puppet.scene.of(BookProps).books[117]
    assert book.rest is Rest.TRAY
    assert book.pose[2, 3] == pytest.approx(0.62)


def test_a_book_let_go_in_the_air_falls_to_the_floor(puppet: Puppet) -> None:
    puppet.take_book()
    puppet.to(-0.02, 0.0, 0.80)
    puppet.fingers(0.06)
    assert puppet.scene.held is None
    assert puppet.scene.of(BookProps).books[117].rest is Rest.FLOOR
    assert puppet.scene.of(BookProps).books[117].tilt() == pytest.approx(np.pi / 2)


def test_book_before_its_slot_is_inserted_and_stands_after_release(puppet: Puppet) -> None:
    neighbours = {number: front(puppet, number).front for number in (103, 104)}
    puppet.insert()
    assert puppet.scene.contacts == []
    puppet.fingers(0.07)
    book = front(puppet, 117)
    assert book.front == pytest.approx(-0.03, abs=2e-3)
    assert book.lateral == pytest.approx(puppet.slot, abs=2e-3)
    assert abs(book.lean) < np.arcsin(0.0045 / 0.2)  # gap between the neighbours
    assert book.yaw == pytest.approx(0.0, abs=1e-3)
    assert {number: front(puppet, number).front for number in (103, 104)} == neighbours


def test_a_small_error_is_taken_up_by_the_slot_and_felt(puppet: Puppet) -> None:
    puppet.insert(error=0.004)
    # 4 mm of error less 3 mm of play.
    assert puppet.arm.hand_force()[1] == pytest.approx(-2.0, abs=1.5)
    puppet.fingers(0.07)
    assert abs(front(puppet, 117).lateral - puppet.slot) < 0.0031


def test_large_error_jams_with_rising_force_and_moves_the_neighbour(puppet: Puppet) -> None:
    before = front(puppet, 103).front
    puppet.before_slot(error=0.012)
    contact = puppet.DOCK - 0.12 - 0.15 + before
    puppet.to(contact + 0.003, puppet.slot + 0.012, puppet.height)
    assert puppet.arm.hand_force()[0] == pytest.approx(-6.0, abs=1.5)
    assert front(puppet, 103).front == before
    assert ("load", "book 103") in puppet.scene.touching
    puppet.to(contact + 0.025, puppet.slot + 0.012, puppet.height)
    assert puppet.arm.hand_force()[0] == pytest.approx(-10.0, abs=1.5)
    assert front(puppet, 103).front - before == pytest.approx(0.020, abs=2e-3)


def test_closed_fingers_push_a_proud_book_home(puppet: Puppet) -> None:
    puppet.insert()
    puppet.fingers(0.07)
    puppet.to(puppet.DOCK - 0.22, puppet.slot, puppet.height)
    puppet.fingers(0.0)
    puppet.to(puppet.DOCK - puppet.TIP + 0.0015, puppet.slot, puppet.height)
    assert front(puppet, 117).front == pytest.approx(0.0, abs=1e-3)
    assert puppet.arm.hand_force()[0] == pytest.approx(-3.0, abs=1.5)
    puppet.to(puppet.DOCK - 0.25, puppet.slot, puppet.height)
    assert front(puppet, 117).front == pytest.approx(0.0, abs=1e-3)
    assert puppet.arm.hand_force()[0] == pytest.approx(0.0, abs=1.5)


def test_an_inserted_book_can_be_gripped_again_and_drawn_out(puppet: Puppet) -> None:
    puppet.insert()
    puppet.fingers(0.07)
    puppet.fingers(0.0)
    assert puppet.scene.held is puppet.scene.of(BookProps).books[117]
    puppet.to(0.10, puppet.slot, puppet.height)
    assert puppet.scene.of(BookProps).shelf_books("shelf_1")[0].book.accession == 101
    assert 117 not in [book.book.accession for book in puppet.scene.of(BookProps).shelf_books("shelf_1")]


def test_the_arm_stops_at_what_is_solid_and_feels_it(puppet: Puppet) -> None:
    puppet.to(0.10, 0.0, 0.80)
    puppet.to(0.10, 0.0, 0.75)
    puppet.fingers(0.0)
    # Down through the shelf's board, from above it.
    puppet.to(0.25, puppet.slot, 0.76)
    commanded_below = 0.66
    puppet.to(0.25, puppet.slot, commanded_below)
    height = puppet.scene.arm.forward(puppet.scene.joints)[2, 3]
    touched = {contact.other for contact in puppet.scene.contacts}
    if touched:
        assert height > commanded_below + 0.005
        assert np.linalg.norm(puppet.arm.hand_force()) > 5.0
    else:
        pytest.fail("the hand went through the board")


def test_the_hand_cannot_be_driven_through_its_own_tray(puppet: Puppet) -> None:
    puppet.scene.move_base(Pose2(2.0, 1.0, 0.0))
    puppet.to(-0.10, 0.08, 0.80)
    puppet.to(0.0, 0.08, 0.66)
    puppet.to(0.0, 0.08, 0.60)
    assert puppet.scene.arm.forward(puppet.scene.joints)[2, 3] > 0.63
    assert "tray" in {contact.other for contact in puppet.scene.contacts}
    assert puppet.arm.hand_force()[2] > 20.0


def test_a_book_in_its_slot_holds_a_hand_that_wrenches_sideways(puppet: Puppet) -> None:
    puppet.insert()
    puppet.to(puppet.DOCK - 0.15, puppet.slot - 0.08, puppet.height)
    hand = puppet.scene.arm.forward(puppet.scene.joints)
    assert abs(hand[1, 3] - puppet.slot) < 0.04
    assert puppet.arm.hand_force()[1] > 40.0
    assert abs(front_of_held(puppet)) < 0.0031


def front_of_held(puppet: Puppet) -> float:
    """y of the held book in S, about the slot's middle."""
    pose = puppet.scene.of(BookProps).shelves["shelf_1"].inverse_pose @ puppet.scene.of(BookProps).book_pose(
        117
    )
    return float(pose[1, 3] - puppet.slot)
