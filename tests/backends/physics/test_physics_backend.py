"""What is physics, whatever the engine, and what must be as on the kinematic backend."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.physics.engine.engine import Pinned
from handcart.backends.physics.engine.thing_form import Cuboid, ThingForm
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.plain_values import to_plain
from handcart.backends.saved_state import pack, unpack
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.thing import Rest
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.robotics.geometry.transform import inverse, transform

from .conftest import Hand, Make

ROOT = Path(__file__).resolve().parents[3]


def parts(backend: PhysicsBackend | KinematicBackend) -> Any:
    return backend.capabilities()


def steps(backend: PhysicsBackend, count: int) -> None:
    for _ in range(count):
        backend.step()


def test_all_books_stand_where_the_world_file_puts_them(
    make: Make, world: WorldFile, spec: RobotFile
) -> None:
    backend = make()
    planned = KinematicBackend(spec, world, 0).scene
    steps(backend, 20)
    for number, book in backend.scene.of(BookProps).books.items():
        off = (
            backend.scene.of(BookProps).book_pose(number)[:3, 3]
            - planned.of(BookProps).book_pose(number)[:3, 3]
        )
        assert np.linalg.norm(off) < 2e-3
        assert book.tilt() < 0.01
    assert backend.scene.contacts == []


@pytest.mark.slow
def test_wheels_drive_the_base_and_tell_how_far(make: Make) -> None:
    backend = make()
    base, start = parts(backend)[0], backend.scene.base
    for _ in range(40):
        base.drive(0.1, 0.0)
        backend.step()
    steps(backend, 10)
    gone = start.distance(backend.scene.base)
    travel = base.wheel_travel()
    assert gone == pytest.approx(0.2, abs=0.01)
    assert (travel.left + travel.right) / 2 == pytest.approx(0.2, abs=0.002)


@pytest.mark.slow
def test_a_base_that_is_stopped_stands(make: Make) -> None:
    backend = make()
    for _ in range(10):
        parts(backend)[0].drive(0.1, 0.1)
        backend.step()
    backend.stop()
    steps(backend, 5)
    there = backend.scene.base
    steps(backend, 40)
    assert there.distance(backend.scene.base) < 2e-4
    assert there.turn(backend.scene.base) < 2e-4


def test_fingers_that_were_stopped_can_be_told_to_stay(make: Make) -> None:
    backend = make()
    gripper = parts(backend)[2]
    steps(backend, 3)
    backend.stop()
    gripper.move(gripper.command())
    assert gripper.command() <= 0.07


@pytest.mark.slow
def test_a_picture_shows_the_same_whoever_looked_before(make: Make) -> None:
    idle, busy = make(), make()
    for number in range(30):
        for backend in (idle, busy):
            parts(backend)[0].drive(-0.3 if number < 15 else 0.3, 0.3)
            backend.step()
        if number % 5 == 0:
            busy.view()
            parts(busy)[3].image()
    assert np.array_equal(parts(idle)[3].image(), parts(busy)[3].image())


def test_the_hand_is_where_the_urdf_puts_it_also_on_a_base_that_gives(hand: Hand) -> None:
    scene = hand.backend.scene
    assert np.abs(scene.world_T("hand") - hand.backend.link_pose("hand")).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("held", [False, True])
def test_a_world_put_back_goes_on_as_the_one_that_was_kept(
    make: Make, spec: RobotFile, hand_of: Callable[[PhysicsBackend], Hand], held: bool
) -> None:
    first = hand_of(make())
    if held:
        first.take_book()
    kept = pack(first.backend.state())
    again = hand_of(make())
    again.backend.set_state(unpack(kept))
    assert (again.backend.scene.held is not None) == held
    for item in (first, again):
        here = item.model.forward(item.arm.command())[:3, 3]
        item.line(here[0], here[1], here[2] + 0.02)
    one, other = first.backend.scene, again.backend.scene
    assert np.abs(one.joints - other.joints).max() < 1e-5
    assert one.base.distance(other.base) < 1e-5
    then, now = one.of(BookProps).books, other.of(BookProps).books
    for number, book in then.items():
        assert np.abs(book.pose - now[number].pose).max() < 1e-4
        assert book.rest == now[number].rest


def test_positive_turn_rate_turns_left(make: Make) -> None:
    backend = make()
    base, start = parts(backend)[0], backend.scene.base
    for _ in range(20):
        base.drive(0.0, 0.3)
        backend.step()
    assert start.inverse().compose(backend.scene.base).theta == pytest.approx(0.3, abs=0.03)


def test_a_wrong_tread_misleads_the_odometry_as_without_physics(
    make: Make, world: WorldFile, spec: RobotFile
) -> None:
    """The encoders do not know that the true tread differs from the file's by the error `tread_percent`."""
    other = {"tread_percent": 10.0, "wheel_radius_percent": 0.0, "slip_percent": 0.0}
    wrong = spec.model_copy(update={"errors": spec.errors.model_copy(update=other)})
    ratios = []
    for backend in (make(robot=wrong), KinematicBackend(wrong, world, 0)):
        base, begun = parts(backend)[0], backend.scene.base.theta
        for _ in range(20):
            base.drive(0.0, 0.5)
            backend.step()
        for _ in range(5):
            backend.step()
        travel = base.wheel_travel()
        measured = (travel.right - travel.left) / spec.drive.tread_m
        ratios.append((backend.scene.base.theta - begun) / measured)
    assert abs(ratios[1] - 1.0) > 0.01
    assert ratios[0] == pytest.approx(ratios[1], abs=2e-3)


@pytest.mark.slow
def test_base_command_not_renewed_ends_and_the_base_stops(make: Make) -> None:
    backend = make()
    base = parts(backend)[0]
    for _ in range(20):
        base.drive(0.2, 0.0)
        backend.step()
    steps(backend, 10)
    rests = backend.scene.base
    steps(backend, 40)
    assert rests.distance(backend.scene.base) < 2e-4


@pytest.mark.slow
def test_a_wall_stops_the_base_and_is_told_as_contact(make: Make) -> None:
    backend = make()
    base = parts(backend)[0]
    for _ in range(150):
        base.drive(0.3, 0.0)
        backend.step()
    assert backend.scene.base.y < 1.8
    assert any("shelf_1" in other for _, other in backend.scene.touching)


def test_the_hand_is_where_kinematics_say(hand: Hand) -> None:
    hand.joints(hand.arm.command() + np.array([0.2, -0.1, 0.1, 0.0, 0.1, 0.2]))
    measured = hand.model.forward(hand.backend.scene.joints)
    body = hand.backend._body
    assert np.abs(measured - np.linalg.solve(body.base_pose(), body.link_pose("hand"))).max() < 1e-6


@pytest.mark.slow
def test_arm_reaches_commanded_joints_within_its_repeatability(hand: Hand, spec: RobotFile) -> None:
    goal = hand.arm.command() + np.array([0.3, -0.2, 0.1, 0.2, 0.1, -0.2])
    hand.joints(goal)
    steps(hand.backend, 20)
    off = np.abs(hand.backend.scene.joints - goal).max()
    assert off < 6e-3 * spec.errors.joint_repeatability_mrad + 1e-3


@pytest.mark.slow
def test_fingers_hold_a_book_by_friction_and_let_it_fall(hand: Hand) -> None:
    book = hand.backend.scene.of(BookProps).books[117]
    hand.take_book()
    assert hand.gripper.closed_on_something()
    assert hand.backend.scene.held is book
    assert hand.gripper.width() == pytest.approx(0.025, abs=1e-3)
    here = hand.model.forward(hand.arm.command())[:3, 3]
    before = book.pose[2, 3]
    hand.line(here[0], here[1], here[2] + 0.08)
    assert book.pose[2, 3] - before == pytest.approx(0.08, abs=3e-3)
    hand.grip(0.06)
    assert hand.backend.scene.held is None
    assert book.rest is not Rest.HAND
    assert book.pose[2, 3] - before < 0.02


@pytest.mark.slow
def test_a_held_book_stays_held_when_a_body_is_added(hand: Hand) -> None:
    """MuJoCo compiles its model again then, where the pins that hold the book begin as placeholders."""
    book = hand.backend.scene.of(BookProps).books[117]
    hand.take_book()
    here = hand.model.forward(hand.arm.command())[:3, 3]
    hand.line(here[0], here[1], here[2] + 0.08)
    before = inverse(hand.backend.link_pose("hand")) @ book.pose
    size, side = (0.1, 0.1, 0.1), ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    gray = np.full((4, 4), 100, np.uint8)
    far = transform((5.0, 5.0, 1.0))
    hand.backend._engine.add_thing(ThingForm(far, size, 0.2, (Cuboid(size),), 0.65, (side,) * 6, gray))
    for _ in range(20):
        hand.backend.step()
    assert hand.backend.scene.held is book
    after = inverse(hand.backend.link_pose("hand")) @ book.pose
    assert float(np.linalg.norm((after - before)[:3, 3])) < 1e-3


@pytest.mark.slow
def test_closed_fingers_that_push_a_book_do_not_hold_it(hand: Hand) -> None:
    book = hand.backend.scene.of(BookProps).tray_book()
    assert book is not None
    spine = book.base_T_thing[:3, 3]
    hand.line(-0.10, spine[1], 0.80)
    hand.grip(0.0)
    hand.line(-0.10, spine[1], 0.70)
    hand.line(spine[0] - 0.14, spine[1], 0.70)
    assert any("117" in other for _, other in hand.backend.scene.touching)
    assert hand.backend.scene.held is None


@pytest.mark.slow
def test_weak_fingers_let_the_book_slip(
    make: Make, spec: RobotFile, hand_of: Callable[[PhysicsBackend], Hand]
) -> None:
    assert spec.gripper is not None
    gripper = spec.gripper.model_copy(update={"force_n": 1.0})
    hand = hand_of(make(robot=spec.model_copy(update={"gripper": gripper})))
    book = hand.backend.scene.of(BookProps).books[117]
    hand.take_book()
    before = book.pose[2, 3]
    here = hand.model.forward(hand.arm.command())[:3, 3]
    hand.line(here[0], here[1], here[2] + 0.08)
    assert book.pose[2, 3] - before < 0.04


def test_fingers_that_close_on_nothing_meet(hand: Hand) -> None:
    hand.grip(0.0)
    assert hand.backend.scene.held is None
    assert hand.gripper.width() < 1e-3


@pytest.mark.slow
def test_constraint_grasp_holds_and_survives_a_restored_state(
    make: Make, spec: RobotFile, hand_of: Callable[[PhysicsBackend], Hand]
) -> None:
    assert spec.gripper is not None
    gripper = spec.gripper.model_copy(update={"grasp": "constraint"})
    hand = hand_of(make(robot=spec.model_copy(update={"gripper": gripper})))
    physics, book = hand.backend._engine, hand.backend.scene.of(BookProps).books[117]
    free = physics.state()
    hand.take_book()
    held = physics.state()
    there = hand.backend._world.pose(book)
    here = hand.model.forward(hand.arm.command())[:3, 3]
    hand.line(here[0], here[1], here[2] + 0.08)
    assert hand.backend.scene.held is book
    assert (book.pose - there)[2, 3] == pytest.approx(0.08, abs=1e-3)
    physics.set_state(held)
    assert to_plain(physics.pinned, Pinned) == held["pinned"] is not None
    assert np.abs(hand.backend._world.pose(book) - there).max() < 1e-6
    physics.set_state(free)
    assert physics.pinned is None


@pytest.mark.slow
def test_a_constraint_grasp_opens(
    make: Make, spec: RobotFile, hand_of: Callable[[PhysicsBackend], Hand]
) -> None:
    assert spec.gripper is not None
    gripper = spec.gripper.model_copy(update={"grasp": "constraint"})
    hand = hand_of(make(robot=spec.model_copy(update={"gripper": gripper})))
    hand.take_book()
    hand.grip(0.06)
    assert hand.backend.scene.held is None
    assert hand.backend._engine.pinned is None


def test_ranges_are_those_of_the_kinematic_backend(make: Make, world: WorldFile, spec: RobotFile) -> None:
    scans = []
    for backend in (make(), KinematicBackend(spec, world, 0)):
        backend.step()
        scans.append(parts(backend)[-1].scan().ranges)
    met = np.isfinite(scans[0]) & np.isfinite(scans[1])
    assert met.mean() > 0.9
    assert np.median(np.abs(scans[0] - scans[1])[met]) < 0.01


@pytest.mark.slow
def test_the_same_seed_gives_the_same_run(make: Make) -> None:
    readings = []
    for backend in (make(7), make(7), make(8)):
        base, arm, *_, camera, ranges = parts(backend)
        for _ in range(10):
            base.drive(0.1, 0.2)
            arm.move(arm.command() + 0.01)
            backend.step()
        readings.append(
            np.concatenate([ranges.scan().ranges, arm.joints(), base.wheel_travel(), camera.image().ravel()])
        )
    assert np.array_equal(readings[0], readings[1], equal_nan=True)
    assert not np.array_equal(readings[0], readings[2], equal_nan=True)


@pytest.mark.slow
def test_the_engine_writes_nothing_to_our_streams(physics: type[PhysicsBackend]) -> None:
    code = (
        "from pathlib import Path; from handcart.backends.registry import make_backend;"
        "from handcart.backends.loading.robot_loading import load_robot;"
        "world = Path('tasks/return_book/world.yaml');"
        f"b = make_backend('{physics.name}', load_robot('librarian'), world, 0);"
        "b.step(); b.view(); b.capabilities()[3].image(); b.close()"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


def test_what_stands_there_weighs_what_it_weighs(make: Make) -> None:
    """The engine tells forces of a part of its step: what carries a book has to add up to its weight."""
    backend = make()
    for _ in range(20):
        backend.step()
    on_tray = backend.scene.of(BookProps).tray_book()
    assert on_tray is not None
    book = backend._world.bodies[on_tray.name]
    mass = on_tray.mass
    felt = []
    for _ in range(10):
        backend.step()
        felt.append(backend._touch.force(book))
    assert np.mean(felt, axis=0) == pytest.approx([0.0, 0.0, 9.81 * mass], abs=0.1 * 9.81 * mass)
