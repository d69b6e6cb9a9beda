"""Faults under way on a bench, and what must have stopped then."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

import numpy as np
import pytest

from handcart.backends.can.bench.injected_faults import inject
from handcart.backends.can.bus.errors import CanFault
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base

JOINT_1 = 11
"""The node of the librarian's first joint."""
BEFORE = 10  # periods driven before something goes wrong
HOLDING, LOOSE = ("QUICK STOP ACTIVE",), ("SWITCH ON DISABLED", "FAULT")


def move(backend: Any, periods: int) -> None:
    """Drive, and turn the arm."""
    for _ in range(periods):
        backend.get(Base).drive(0.4, 0.3)
        arm = backend.get(Arm)
        if arm is not None:
            arm.move(arm.command() + np.array([0.02, 0.0, 0.0, 0.0, 0.0, 0.0]))
        backend.step()


def fault_of(backend: Any, name: str, node: int | None = None, within: int = 20) -> CanFault:
    """Return the fault that ends a run in which a fault is injected."""
    move(backend, BEFORE)
    inject(backend.bench, name, backend.bench.time, node)
    with pytest.raises(CanFault) as raised:
        move(backend, within)
    return raised.value


def assert_stopped(backend: Any, fault: CanFault, gone: Collection[int] = ()) -> None:
    """Assert that all axes have stopped for good, each in its own way; drives in `gone` are not asked."""
    drives = {node: drive for node, drive in backend.bench.drives.items() if node not in gone}
    assert [drive.velocity for drive in drives.values()] == [0.0] * len(drives)
    for axis in backend.axes.values():
        if axis.id not in gone:
            states = HOLDING if axis.spec.stop == "hold" else LOOSE
            assert drives[axis.id].life.state in (*states, "FAULT")
    there, epoch = [drive.position for drive in drives.values()], backend.epoch
    with pytest.raises(CanFault) as again:
        move(backend, 1)
    assert again.value is fault
    backend.stop()
    assert backend.epoch == epoch + 1
    for _ in range(40):  # nothing that was queued comes after
        backend.bench.serve()
        backend.bench.tick(0.05)
    assert [drive.position for drive in drives.values()] == there
    backend.close()


def assert_told(pattern: str, fault: CanFault) -> None:
    assert re.search(pattern, str(fault)), str(fault)


def assert_drives_stop_alone(backend: Any, within: float = 0.15) -> None:
    moving = [drive.velocity for drive in backend.bench.drives.values()]
    assert any(moving)
    braking = backend.axes["left wheel"].limits
    ramp = braking.speed / braking.braking
    periods = round((within + ramp) / backend.period) + 1
    for _ in range(periods):
        backend.bench.tick(backend.period)
    assert [drive.velocity for drive in backend.bench.drives.values()] == [0.0] * len(moving)
    states = {backend.bench.drives[axis.id].life.state for axis in backend.axes.values()}
    assert states == {"QUICK STOP ACTIVE", "SWITCH ON DISABLED"}
