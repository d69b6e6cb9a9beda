"""The way of hardware: drives that answer by themselves, and a wall clock."""

from __future__ import annotations

import threading
import time

import can
import pytest

from backends.base import Base
from backends.can.can_backend import CanBackend
from backends.can.pace import Pace
from backends.can.simulated.simulated_drives import SimulatedDrives

from .conftest import LEFT, RIGHT


@pytest.fixture
def drives(monkeypatch):
    """Drives in a thread of their own, behind whatever interface is opened."""
    made, end = SimulatedDrives(LEFT, RIGHT), threading.Event()

    def serve():
        while not end.is_set():
            made.serve()
            time.sleep(0.0005)

    thread = threading.Thread(target=serve)
    thread.start()
    monkeypatch.setattr(can, "Bus", lambda **_: made.open())
    yield made
    end.set()
    thread.join()
    made.close()


def test_a_step_lasts_a_period_and_the_wheels_roll(cart, drives):
    spec = cart.can.model_copy(update={"interface": "socketcan", "channel": "can0"})
    robot = cart.model_copy(update={"can": spec, "period_s": 0.1})
    with CanBackend.build(robot, None, 0) as backend:
        assert backend.bench is None and backend.scene is None
        base = backend.get(Base)
        backend.step()
        begin = time.monotonic()
        for _ in range(5):
            base.drive(0.2, 0.0)
            backend.step()
        assert 0.3 < time.monotonic() - begin < 2.0
        assert base.wheel_travel().left == pytest.approx(0.08, abs=0.03)
        assert base.wheel_travel().right == pytest.approx(base.wheel_travel().left)
    assert [node.life.state for node in drives.nodes.values()] == ["SWITCH ON DISABLED"] * 2


def test_pace_waits_for_the_end_and_makes_up_for_nothing():
    now, slept = [10.0], []

    def sleep(seconds):
        slept.append(seconds)
        now[0] += seconds

    pace = Pace(0.1, lambda: now[0], sleep)
    now[0] += 0.03
    pace.wait()
    pace.wait()
    now[0] += 0.25
    pace.wait()
    pace.wait()
    assert slept == pytest.approx([0.07, 0.1, 0.1])
    assert pace.late == 1
