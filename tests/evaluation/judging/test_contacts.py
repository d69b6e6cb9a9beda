"""Unmeant contacts of the robot are reported with its part, the touched body, the time and the force."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.evaluation.judging.contact_survey import ContactSurvey
from handcart.evaluation.judging.survey import SurveyedRun
from handcart.files.models.loading import load
from handcart.primitives.books.books import Slot
from handcart.primitives.books.catalogue import Book
from handcart.primitives.books.insert import Insert
from handcart.primitives.books.pick_up import PickUp
from handcart.primitives.books.search import Search
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from tests.shelf_text import GAP, shelf_text

WORLD = f"""
format: handcart-world/1
start: {{x_m: 2.0, y_m: 1.0, heading_deg: 90}}
walls: [{{from_m: [0, 0], to_m: [4, 0]}}]
furniture: [{{name: lamp, x_m: 0.6, y_m: 1.0, size_m: [0.3, 0.3, 0.3], above_m: 0.8}}]
{shelf_text([101, 102, 103, GAP, 104])}"""
DOCK = 0.47  # [m] from the base's middle to the shelf's front
STEP = 0.07  # [rad] of a joint in a period


def book(accession: int, call: str) -> Book:
    sizes = {"thickness_mm": 25, "height_mm": 210, "depth_mm": 150}
    return Book(accession=accession, call=call, title="", shelf="shelf_1", **sizes)


class Hands:
    """Moves a robot about in a small room, and asks afterwards what it touched."""

    def __init__(self, backend: Any) -> None:
        books = [book(103, "512.5 BOR"), book(104, "512.8 POI"), book(117, "512.7 NAG")]
        slot = Slot("shelf_1", 0.07, 0.039, 0.001, "512.5 BOR", "512.8 POI")
        known = SimpleNamespace(book=books[2], slot=slot, catalogue=SimpleNamespace(books=books))
        model: Any = SimpleNamespace(of=lambda _: known)
        self.backend, self.scene = backend, backend.scene
        self.arm, self.gripper, self.base = backend._arm, backend._gripper, backend._base
        robot: Any = SimpleNamespace()
        self.survey = ContactSurvey(SurveyedRun(robot, load_robot("librarian"), model, self.scene))

    def begins(self, primitive: ActionPrimitive) -> None:
        self.primitive = primitive
        self.survey.started(1, primitive)

    def ends(self) -> list[str]:
        """Return the messages that contradict a Success."""
        return self.survey.ended(1, self.primitive, Success())

    def step(self, periods: int = 1) -> None:
        for _ in range(periods):
            self.backend.step()
            robot: Any = SimpleNamespace(
                time=self.scene.time, period=self.backend.period, command=DriveCommand()
            )
            self.survey.look(robot)

    def stand(self, x: float, y: float, heading: float) -> None:
        self.scene.move_base(Pose2(x, y, heading))

    def dock(self) -> None:
        self.stand(2.0, 2.0 - DOCK, np.pi / 2)

    def drive(self, speed: float, periods: int) -> None:
        for _ in range(periods):
            self.base.drive(speed, 0.0)
            self.step()

    def hand(self, x: float, y: float, z: float) -> None:
        """Move the hand straight to a place of the base frame in [m], level and ahead."""
        joints, model = self.arm.command(), self.scene.arm
        start, goal = model.forward(joints)[:3, 3], np.array([x, y, z])
        for share in np.linspace(0.0, 1.0, max(2, int(np.linalg.norm(goal - start) / 0.02)) + 1)[1:]:
            wanted = model.inverse(transform(tuple(start + share * (goal - start))), joints, restarts=0)
            while not np.allclose(joints, wanted):
                joints = joints + np.clip(wanted - joints, -STEP, STEP)
                self.arm.move(joints)
                self.step()

    def fingers(self, width: float) -> None:
        self.gripper.move(width)
        self.step(35)

    def take_book(self) -> None:
        spine = self.scene.of(BookProps).tray_book().base_T_thing[:3, 3]
        self.hand(-0.10, spine[1], 0.80)
        self.hand(-0.10, spine[1], 0.70)
        self.hand(spine[0] - 0.12, spine[1], 0.70)
        self.fingers(0.0)
        self.hand(spine[0] - 0.12, spine[1], 0.80)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, WorldFile]:
    path = tmp_path_factory.mktemp("room") / "world.yaml"
    path.write_text(WORLD, encoding="utf-8")
    return load_robot("librarian"), load(path, world_model())


@pytest.fixture
def hands(files: tuple[Any, WorldFile]) -> Iterator[Hands]:
    with KinematicBackend(*files, 0) as backend:
        yield Hands(backend)


def test_a_base_that_rams_a_wall_is_told(hands: Hands) -> None:
    hands.stand(2.0, 0.45, -np.pi / 2)
    hands.begins(MoveTo(place="home"))
    hands.drive(0.2, 20)
    hands.drive(-0.2, 5)
    (wrong,) = hands.ends()
    assert wrong.startswith("base touched wall 1, which it didn't mean to, from 0.")
    figures = hands.survey.figures()
    assert figures["contacts_of_base"] == figures["contacts_unmeant"] == 1
    (contact,) = figures["contacts"]
    assert (contact["part"], contact["other"], contact["do"]) == ("base", "wall 1", "MOVE_TO")
    assert 0.3 <= contact["from_s"] < contact["to_s"] == pytest.approx(1.0, abs=0.051)
    assert figures["contacts_unmeant_s"] == pytest.approx(contact["to_s"] - contact["from_s"], abs=0.01)


def test_what_touches_twice_are_two_contacts(hands: Hands) -> None:
    """Each lasts as long as it lasted, not from the first to the last."""
    hands.stand(2.0, 0.40, -np.pi / 2)
    hands.begins(MoveTo(place="home"))
    for _ in range(2):
        hands.drive(0.2, 10)
        hands.drive(-0.2, 10)
    first, second = hands.survey.contacts
    assert first.to_s < second.from_s
    assert hands.survey.figures()["contacts_unmeant_s"] < 1.2


def test_an_arm_above_the_base_that_is_driven_into_a_lamp_is_told(hands: Hands) -> None:
    hands.stand(1.3, 1.0, np.pi)
    hands.begins(MoveTo(place="home"))
    hands.drive(0.2, 60)
    assert any("touched lamp" in end for end in hands.ends())
    assert "base" not in {contact.body for contact in hands.survey.contacts}


@pytest.mark.parametrize("holds", [False, True], ids=["hand", "held book"])
def test_what_runs_into_a_shelf_is_told_with_its_force(hands: Hands, holds: bool) -> None:
    hands.dock()
    if holds:
        hands.take_book()
    else:
        hands.fingers(0.0)
    hands.hand(0.05, 0.214, 0.80)
    hands.begins(Search(shelf="shelf_1"))
    hands.step(3)
    assert hands.ends() == []
    hands.begins(Search(shelf="shelf_1"))
    hands.hand(0.25 if holds else 0.36, 0.214, 0.80)
    assert hands.ends()
    contacts = hands.survey.figures()["contacts"]
    contact, *_ = [item for item in contacts if item["other"].endswith("panel of shelf_1")]
    assert contact["part"] == ("held" if holds else "hand")
    assert contact["body"] == ("held book 117" if holds else "fingers")
    assert max(item["force_n"] for item in contacts) > 5.0, contacts


def test_a_book_that_the_fingers_push_by_the_way_is_told(hands: Hands) -> None:
    hands.dock()
    hands.fingers(0.0)
    row = {
        shelf_book.book.accession: shelf_book
        for shelf_book in hands.scene.of(BookProps).shelf_books("shelf_1")
    }
    hands.hand(0.10, row[102].lateral, 0.80)
    hands.begins(Insert(shelf="shelf_1"))
    hands.hand(DOCK - 0.15 + 0.02, row[102].lateral, 0.80)
    assert any(end.startswith("fingers touched book 102, which") for end in hands.ends())
    assert {contact.part for contact in hands.survey.contacts} == {"hand"}
    assert hands.scene.of(BookProps).shelf_books("shelf_1")[1].front > row[102].front + 0.01


def test_the_held_book_may_touch_its_neighbours_but_no_other(hands: Hands) -> None:
    hands.dock()
    hands.take_book()
    slot = 0.2 - 0.13 - 0.0155
    hands.hand(0.0, slot, 0.80)
    hands.begins(Insert(shelf="shelf_1"))
    hands.hand(0.05, slot + 0.012, 0.784)
    hands.hand(DOCK - 0.12 - 0.15 + 0.01, slot + 0.012, 0.784)
    assert [contact.other for contact in hands.survey.contacts] == ["book 103"]
    assert hands.ends() == []
    hands.hand(0.05, slot + 0.012, 0.784)
    hands.hand(0.05, 0.2 - 0.065, 0.784)
    hands.begins(Insert(shelf="shelf_1"))
    hands.hand(DOCK - 0.12 - 0.15 + 0.01, 0.2 - 0.065, 0.784)
    assert any("held book 117 touched book 102" in end for end in hands.ends())


def test_the_book_that_is_picked_up_may_be_touched(hands: Hands) -> None:
    hands.begins(PickUp())
    spine = hands.scene.of(BookProps).tray_book().base_T_thing[:3, 3]
    hands.hand(-0.10, spine[1], 0.80)
    hands.fingers(0.0)
    hands.hand(-0.10, spine[1], 0.70)
    hands.hand(spine[0] - 0.14, spine[1], 0.70)
    assert hands.survey.contacts[0].other == "book 117"
    assert hands.ends() == []


def test_notes_bring_back_what_was_touched(hands: Hands) -> None:
    hands.stand(2.0, 0.45, -np.pi / 2)
    hands.begins(MoveTo(place="home"))
    hands.drive(0.2, 20)
    hands.ends()
    again = ContactSurvey(hands.survey.run)
    again.go_on(hands.survey.notes())
    assert again.figures() == hands.survey.figures()


def test_a_fast_arm_goes_through_no_thin_board(hands: Hands) -> None:
    hands.dock()
    arm, hand = hands.scene.arm, hands.backend._hand
    left, right = (
        arm.inverse(transform((0.40, 0.21 + aside, 0.98)), hands.arm.command()) for aside in (0.06, -0.06)
    )
    assert hand.contact.deepest_of_arm(left).depth == hand.contact.deepest_of_arm(right).depth == 0.0
    hands.scene.joints = left
    hand.move(right)
    stopped = arm.forward(hands.scene.joints)[1, 3]
    assert 0.21 < stopped < 0.27
