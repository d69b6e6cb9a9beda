"""The simulated drive, by itself."""

from __future__ import annotations

import pytest
from canopen.profiles.p402 import State402

from handcart.backends.can.bus.fault_words import fault_words
from handcart.backends.can.drives.profile import ramp
from handcart.backends.can.simulated.cyclic_modes import CyclicPosition
from handcart.backends.can.simulated.drive_life import DriveLife
from handcart.backends.can.simulated.drive_mode import Demand
from handcart.backends.can.simulated.drive_objects import DriveObjects
from handcart.backends.can.simulated.profile_position import ProfilePosition


def test_the_states_follow_the_controlword() -> None:
    life, seen = DriveLife(), []
    for word in (0x06, 0x07, 0x0F, 0x07, 0x0F, 0x02, 0x0F, 0x00, 0x06, 0x00, 0x0F):
        life.control(word)
        seen.append(life.state)
    on, ready, enabled = "SWITCHED ON", "READY TO SWITCH ON", "OPERATION ENABLED"
    off, quick = "SWITCH ON DISABLED", "QUICK STOP ACTIVE"
    assert seen == [ready, on, enabled, on, enabled, quick, quick, off, ready, off, off]


def test_a_fault_is_reset_by_a_rising_edge_alone() -> None:
    life = DriveLife()
    life.control(0x80)
    life.fail()
    assert life.state == "FAULT REACTION ACTIVE"
    life.settle()
    life.control(0x8F)
    assert life.state == "FAULT"
    life.control(0x00)
    life.control(0x80)
    assert life.state == "SWITCH ON DISABLED"


@pytest.mark.parametrize("state", ["SWITCH ON DISABLED", "READY TO SWITCH ON", "OPERATION ENABLED", "FAULT"])
def test_statuswords_are_those_that_the_library_knows(state: str) -> None:
    life = DriveLife()
    life._state = state
    matches = [name for name, (mask, bits) in State402.SW_MASK.items() if life.statusword & mask == bits]
    assert matches == [state]


def test_a_velocity_ramps() -> None:
    assert ramp(0.0, 1.0, 2.0, 0.25) == (0.0625, 0.5)
    assert ramp(0.0, 1.0, 2.0, 1.0) == (0.75, 1.0)
    assert ramp(1.0, -1.0, 4.0, 0.5) == (0.0, -1.0)
    assert ramp(1.0, 1.0, 0.0, 2.0) == (2.0, 1.0)


def test_fault_codes_are_told_in_words() -> None:
    assert fault_words(0) == ""
    assert fault_words(0x8611) == "error 8611h, following error"
    assert fault_words(0x4321) == "error 4321h, temperature"


def positioning() -> ProfilePosition:
    objects = DriveObjects(11)
    for index, value in ((0x6081, 1000), (0x6083, 10_000), (0x6084, 10_000), (0x607F, 2000)):
        objects[index] = value
    objects[0x607D, 1], objects[0x607D, 2] = -(10**6), 10**6
    mode = ProfilePosition(objects, Demand())
    mode.begin()
    return mode


def asks(mode: ProfilePosition, target: int, *words: int) -> None:
    """Controlwords one after the other, with a target position."""
    mode.objects[0x607A] = target
    before = 0
    for word in words:
        mode.control(word, word & ~before)
        before = word


def test_a_set_point_counts_when_bit_4_rises_and_once() -> None:
    """B6: CiA 402-2; one that is asked for while another one waits is not taken."""
    mode = positioning()
    asks(mode, 300, 0x1F, 0x0F)
    assert mode.status & 0x1000 == 0
    asks(mode, 200, 0x1F, 0x0F)  # waits until the first is reached
    assert mode.status & 0x1000
    asks(mode, 900, 0x1F, 0x0F)
    reached = []
    for _ in range(200):
        mode.advance(0.01)
        reached.append(mode.demand.position)
    assert max(reached) == pytest.approx(300.0)
    assert reached[-1] == pytest.approx(200.0)
    assert mode.status & 0x1000 == 0


def test_a_bit_4_that_was_set_before_is_no_new_set_point() -> None:
    mode = positioning()
    mode.objects[0x607A] = 500
    mode.control(0x1F, 0x08)  # enabled with it: it hasn't risen
    mode.advance(1.0)
    assert (mode.demand.position, mode.status & 0x1000) == (0.0, 0)


def test_cyclic_set_point_is_reached_evenly_in_interpolation_time() -> None:
    """60C2h: 50 * 10^-3 s; if the next set-point is late, the drive rests at the last one."""
    objects, demand = DriveObjects(11), Demand()
    objects[0x60C2, 1], objects[0x60C2, 2] = 50, -3
    objects[0x607D, 1], objects[0x607D, 2] = -(10**6), 10**6
    mode = CyclicPosition(objects, demand)
    mode.begin()
    objects[0x607A] = 1000
    mode.latch()
    went = []
    for _ in range(7):
        mode.advance(0.01)
        went.append((demand.position, demand.velocity))
    assert [position for position, _ in went] == pytest.approx([200, 400, 600, 800, 1000, 1000, 1000])
    assert [speed for _, speed in went] == pytest.approx([20_000] * 5 + [0.0] * 2)
