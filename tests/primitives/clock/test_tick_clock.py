"""Tests of the robot's clock in behaviour trees: timing of py_trees, threads, and unchanged code."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

import py_trees
import pytest
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Running
from py_trees.common import Status
from py_trees.decorators import Timeout
from py_trees.timers import Timer

from handcart.backends.robot.robot import Robot
from handcart.primitives.clock.tick_clock import TICK_TIME, WallClockError, robot_clock
from handcart.primitives.contract.behaviour_primitive import behaviour_primitive
from handcart.primitives.contract.tree_primitive import GeneratorBehaviour, ticked
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.outcome import Fail, Success
from tests.primitives.conftest import Rig

PERIOD = 0.05


def timed(root: Behaviour) -> tuple[int, list[Status]]:
    """Periods until a tree ends, on a robot whose clock advances by `PERIOD` a tick."""
    ticks = 0

    def now() -> float:
        return 1000.0 + PERIOD * ticks

    for _ in ticked(root, now):
        ticks += 1
        assert ticks < 1000
    return ticks, [root.status]


@pytest.mark.parametrize("duration", [0.5, 2.0])
def test_a_timer_lasts_its_duration_on_the_robots_clock(duration: float) -> None:
    ticks, _ = timed(Timer("wait", duration))
    assert PERIOD * ticks == pytest.approx(duration, abs=1.01 * PERIOD)


def test_a_timeout_in_a_primitive_lasts_two_seconds(make_rig: Callable[..., Rig]) -> None:
    def make(robot: Robot, model: ModelView) -> Behaviour:
        return Timeout("wait", Running("for ever"), duration=2.0)

    rig = make_rig()
    before = rig.robot.time
    outcome = rig.run(behaviour_primitive("WaitTwo", make)())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "timed out"
    assert 2.0 <= rig.robot.time - before < 4.0  # it comes to rest before and after


def test_a_timer_takes_the_same_time_on_every_run(make_rig: Callable[..., Rig]) -> None:
    ends = []
    for pause in (0.0, 0.02):
        rig = make_rig()

        def make(robot: Robot, model: ModelView, pause: float = pause) -> Behaviour:
            time.sleep(pause)  # a slow machine, seen from outside the tick
            return Timer("wait", 1.0)

        assert isinstance(rig.run(_unchecked("Wait", make)), Success)
        ends.append(rig.robot.time)
    assert ends[0] == ends[1]


def _unchecked(name: str, make: Callable[[Robot, ModelView], Behaviour]) -> Any:
    return behaviour_primitive(name, make)()


def test_the_clock_outside_a_tick_is_the_wall_clock() -> None:
    with robot_clock(lambda: 7.0):
        inside = [TICK_TIME.time(), TICK_TIME.monotonic(), TICK_TIME.perf_counter()]
        assert TICK_TIME.monotonic_ns() == 7_000_000_000
    assert inside == [7.0, 7.0, 7.0]
    assert abs(TICK_TIME.time() - time.time()) < 5.0
    assert abs(TICK_TIME.monotonic() - time.monotonic()) < 5.0
    assert TICK_TIME.strftime is time.strftime
    assert time.time.__module__ == "time"  # the standard library itself is as it was


def test_another_thread_keeps_the_wall_clock_during_a_tick() -> None:
    read = []
    with robot_clock(lambda: -5.0):
        thread = threading.Thread(target=lambda: read.append(TICK_TIME.monotonic()))
        thread.start()
        thread.join()
        assert TICK_TIME.monotonic() == -5.0
    assert abs(read[0] - time.monotonic()) < 5.0


def test_two_robots_in_two_threads_see_a_clock_each() -> None:
    ticks = {}

    def run(name: str, period: float) -> None:
        clock = [0.0]
        for _ in ticked(Timer(name, 1.0), lambda: clock[0]):
            clock[0] += period
        ticks[name] = round(clock[0] / period)

    threads = [threading.Thread(target=run, args=item) for item in (("fast", 0.01), ("slow", 0.1))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert ticks["fast"] == pytest.approx(101, abs=1)
    assert ticks["slow"] == pytest.approx(11, abs=1)


def test_every_module_of_py_trees_that_times_is_served() -> None:
    with robot_clock(lambda: 0.0):
        pass
    loaded = [module for name, module in sys.modules.items() if name.partition(".")[0] == "py_trees"]
    assert py_trees.timers.time is TICK_TIME  # type: ignore[attr-defined]
    assert [module.__name__ for module in loaded if vars(module).get("time") is time] == []


def test_a_sleep_in_a_tick_is_refused() -> None:
    with robot_clock(lambda: 0.0), pytest.raises(WallClockError, match="sleeps for 3"):
        TICK_TIME.sleep(3)
    TICK_TIME.sleep(0)


def test_a_generator_leaf_may_end_beside_a_timer() -> None:
    clock = [0.0]

    def steps() -> Any:
        while clock[0] < 3.0:
            yield

    root = py_trees.composites.Sequence(
        "all", memory=True, children=[Timer("wait", 1.0), GeneratorBehaviour("steps", steps)]
    )
    for _ in ticked(root, lambda: clock[0]):
        clock[0] += 0.5
    assert clock[0] == 3.0


def test_module_imported_in_the_place_of_another_is_served(monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of loaded modules is then the same as at the tick before."""
    monkeypatch.setitem(sys.modules, "tick_clock_placeholder", ModuleType("tick_clock_placeholder"))
    with robot_clock(lambda: 0.0):
        pass
    late = ModuleType("py_trees.late_timers")
    vars(late)["time"] = time
    monkeypatch.delitem(sys.modules, "tick_clock_placeholder")
    monkeypatch.setitem(sys.modules, late.__name__, late)
    with robot_clock(lambda: 7.0):
        assert vars(late)["time"] is TICK_TIME
        assert vars(late)["time"].monotonic() == 7.0
