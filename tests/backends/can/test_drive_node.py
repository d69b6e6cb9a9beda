"""The simulated drive, by itself."""

from __future__ import annotations

import pytest
from canopen.profiles.p402 import State402

from backends.can.fault_words import fault_words
from backends.can.profile import ramp
from backends.can.simulated.drive_life import DriveLife


def test_the_states_follow_the_controlword():
    life, seen = DriveLife(), []
    for word in (0x06, 0x07, 0x0F, 0x07, 0x0F, 0x02, 0x0F, 0x00, 0x06, 0x00, 0x0F):
        life.control(word)
        seen.append(life.state)
    on, ready, enabled = "SWITCHED ON", "READY TO SWITCH ON", "OPERATION ENABLED"
    off, quick = "SWITCH ON DISABLED", "QUICK STOP ACTIVE"
    assert seen == [ready, on, enabled, on, enabled, quick, quick, off, ready, off, off]


def test_a_fault_is_reset_by_a_rising_edge_alone():
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
def test_statuswords_are_those_that_the_library_knows(state):
    life = DriveLife()
    life._state = state
    matches = [name for name, (mask, bits) in State402.SW_MASK.items() if life.statusword & mask == bits]
    assert matches == [state]


def test_a_velocity_ramps():
    assert ramp(0.0, 1.0, 2.0, 0.25) == (0.0625, 0.5)
    assert ramp(0.0, 1.0, 2.0, 1.0) == (0.75, 1.0)
    assert ramp(1.0, -1.0, 4.0, 0.5) == (0.0, -1.0)
    assert ramp(1.0, 1.0, 0.0, 2.0) == (2.0, 1.0)


def test_fault_codes_are_told_in_words():
    assert fault_words(0) == ""
    assert fault_words(0x8611) == "error 8611h, following error"
    assert fault_words(0x4321) == "error 4321h, temperature"
