"""Behaviours and primitives that read the wall clock are refused by name."""

from __future__ import annotations

import datetime
import threading
import time
from collections.abc import Callable
from functools import partial
from time import monotonic
from typing import Any

import numpy as np
import pytest
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success as Always
from py_trees.common import Status
from py_trees.composites import Sequence
from py_trees.timers import Timer

from handcart.backends.robot.robot import Robot
from handcart.primitives.clock.tick_clock import WallClockError
from handcart.primitives.clock.wall_clock import wall_clock_reads
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.behaviour_primitive import behaviour_primitive
from handcart.primitives.contract.tree_primitive import GeneratorBehaviour, ticked
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.outcome import Fail
from handcart.primitives.registry import primitive_class, primitive_names
from tests.primitives.conftest import Rig


class Leaf(Behaviour):
    def update(self) -> Status:
        return Status.SUCCESS


class ByModule(Leaf):
    def update(self) -> Status:
        return Status.SUCCESS if time.monotonic() > 0.0 else Status.RUNNING


class ByName(Leaf):
    def update(self) -> Status:
        return Status.SUCCESS if monotonic() > 0.0 else Status.RUNNING


class ByDate(Leaf):
    def update(self) -> Status:
        return Status.SUCCESS if datetime.datetime.now().year > 0 else Status.RUNNING


class ByThread(Leaf):
    def initialise(self) -> None:
        threading.Timer(1.0, lambda: None)


class ByLocalImport(Leaf):
    def update(self) -> Status:
        import time as clock

        return Status.SUCCESS if clock.time_ns() else Status.RUNNING


class ByLocalName(Leaf):
    def update(self) -> Status:
        from time import perf_counter as now

        return Status.SUCCESS if now() > 0.0 else Status.RUNNING


def waited() -> bool:
    return time.time() > 0.0


class ByHelper(Leaf):
    def update(self) -> Status:
        return Status.SUCCESS if waited() else Status.RUNNING


class ByDefault(Leaf):
    def __init__(self, name: str, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(name)
        self._clock = clock


class ByAttribute(Leaf):
    clock = staticmethod(time.time)


class ByParent(ByModule):
    """Inherits it."""


class ByProperty(Leaf):
    @property
    def late(self) -> bool:
        return time.perf_counter() > 1.0


class Sleeper(Leaf):
    def update(self) -> Status:
        time.sleep(1e-4)
        return Status.SUCCESS


READERS = [
    ByModule,
    ByName,
    ByDate,
    ByThread,
    ByLocalImport,
    ByLocalName,
    ByHelper,
    ByDefault,
    ByAttribute,
    ByParent,
    ByProperty,
    Sleeper,
]


@pytest.mark.parametrize("kind", READERS)
def test_a_behaviour_that_reads_the_clock_is_refused_by_name(kind: type[Behaviour]) -> None:
    root = Sequence("all", memory=True, children=[Always("first"), kind("late")])
    with pytest.raises(WallClockError, match=kind.__name__) as caught:
        next(ticked(root, lambda: 0.0))
    assert "allowed: robot.time" in str(caught.value)
    assert root.status == Status.INVALID  # never ticked


def test_the_words_name_function_file_and_line() -> None:
    (words,) = wall_clock_reads(ByModule)
    line = ByModule.update.__code__.co_firstlineno + 1
    assert words == f"ByModule reads the wall clock (time.monotonic, test_wall_clock.py:{line})"


class Robotic(Leaf):
    """Leaf that uses the name `time` for another object, and an attribute `time` of the robot."""

    def __init__(self, name: str, robot: Any) -> None:
        super().__init__(name)
        self._robot = robot

    def update(self) -> Status:
        stamp = time.strftime("%Y", (2000, 1, 1, 0, 0, 0, 0, 1, 0))
        age = datetime.timedelta(seconds=self._robot.time)
        return Status.SUCCESS if stamp and age else Status.RUNNING


GOAL = np.zeros(3)


class WithArray(Leaf):
    """Leaf with an array of the module, which has no single truth value."""

    def update(self) -> Status:
        return Status.SUCCESS if GOAL.copy().sum() else Status.RUNNING


@pytest.mark.parametrize("kind", [Leaf, Robotic, WithArray, Always, Timer, Sequence])
def test_a_behaviour_on_the_robots_clock_is_accepted(kind: type) -> None:
    assert wall_clock_reads(kind) == ()


@pytest.mark.parametrize("name", primitive_names())
def test_no_shipped_primitive_reads_the_wall_clock(name: str) -> None:
    assert wall_clock_reads(primitive_class(name)) == ()


def test_a_factory_of_a_leaf_is_looked_through() -> None:
    def wait(seconds: float) -> Any:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            yield

    with pytest.raises(WallClockError, match="GeneratorBehaviour reads the wall clock"):
        next(ticked(GeneratorBehaviour("wait", partial(wait, 1.0)), lambda: 0.0))


def test_a_primitive_around_a_reader_is_found_without_building_it() -> None:
    def make(robot: Robot, model: ModelView) -> Behaviour:
        return ByName(str(robot.pose))  # asks the robot while it is built

    (words,) = wall_clock_reads(behaviour_primitive("LookOut", make))
    assert words.startswith("ByName reads the wall clock (monotonic")


def test_a_primitive_whose_motion_waits_on_the_wall_clock_is_found() -> None:
    class Dawdle(ActionPrimitive):
        def motion(self, robot: Robot, model: ModelView) -> Periods:
            end = time.monotonic() + 2.0
            while time.monotonic() < end:
                yield

    assert [words.partition(" (")[0] for words in wall_clock_reads(Dawdle)] == [
        "Dawdle reads the wall clock"
    ] * 2


def test_a_reader_in_a_run_is_a_fail_before_it_moves(make_rig: Callable[..., Rig]) -> None:
    Look = behaviour_primitive("Look", lambda robot, model: ByModule("look"))
    outcome = make_rig().run(Look())
    assert isinstance(outcome, Fail)
    assert "ByModule reads the wall clock (time.monotonic" in outcome.reason
