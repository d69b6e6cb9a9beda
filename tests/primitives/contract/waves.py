"""Primitives with every kind of end, for tests of the attempt around them."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Any, ClassVar

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.primitives.books.books import Books
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy, NeedsPerson
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Seen, Snapshot
from handcart.primitives.restoring.trace import Trace


class Wave(ActionPrimitive):
    """Turns the base and swings the arm for a second, then ends as given by `end`."""

    end: str = "returns"
    needs: ClassVar = (Base, Arm)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for index in range(20):
            robot.base.drive(0.1, 0.4)
            swing = np.zeros(6)
            swing[0] = 0.01 * math.sin(index / 4.0)
            robot.arm.move(robot.arm.command() + swing)
            yield
        self.found(swings=1)
        match self.end:
            case "discrepancy":
                raise Discrepancy("the wave was not answered")
            case "for good":
                raise Discrepancy("nobody is there", permanent=True)
            case "a fault":
                raise ZeroDivisionError("division by zero")
            case "a person":
                raise NeedsPerson("the arm squeaks")
            case "no return":
                self.point_of_no_return("it waved")
                yield
                raise Discrepancy("the wave was not answered")
            case "reads":
                model.places["home"]
            case "writes":
                model.of(Books).slot = None

    def finish(self, robot: Robot, model: ModelView) -> Periods:
        yield
        self.found(finished=1)


class WithdrawsBadly(Wave):
    """Can't withdraw after its point of no return."""

    def finish(self, robot: Robot, model: ModelView) -> Periods:
        yield
        raise ValueError("it is stuck")


class NotYet(Wave):
    """Must not start, or is pushed while it is looked at whether it may."""

    stage: str

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        match self.stage:
            case "precondition":
                return "the lamp is missing"
            case "unmet raises":
                raise ValueError("nobody knows")
        robot.localization.displacements += 1
        return ""


class Thinks(ActionPrimitive):
    """Learns something for a period, then ends as given by `end`."""

    end: str
    only_knowledge: ClassVar = True

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield
        match self.end:
            case "discrepancy":
                raise Discrepancy("it makes no sense")
            case "for good":
                raise Discrepancy("it never will", permanent=True)
            case "a fault":
                raise ZeroDivisionError("division by zero")
            case "a person":
                raise NeedsPerson("who knows")
        self.found(thought=1)


class Blind(Wave):
    """Its effect is never seen."""

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        yield
        return False


class BlindAfter(Blind):
    """Its effect is never seen, and can't be undone."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        self.point_of_no_return("the lamp is broken")
        yield


class Pusher(Wave):
    """Moves an object by 12 mm that it doesn't put back."""

    end: str = "discrepancy"
    lost: bool = False

    def observe(self, robot: Robot, model: ModelView) -> Generator[None, None, Seen]:
        yield
        if not self.facts:
            return {"cup": (1.0, 0.0, 0.0)}
        return {} if self.lost else {"cup": (1.012, 0.0, 0.0)}


class Stubborn(Wave):
    """Its own restore leaves the robot where it is; or raises."""

    end: str = "discrepancy"
    raises: bool = False

    def restore(self, *_: Any) -> Periods:
        yield
        if self.raises:
            raise Discrepancy("the way back is blocked")


class Rolls(Stubborn):
    """Moves the base alone."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(20):
            robot.base.drive(0.1, 0.0)
            yield
        raise Discrepancy("nobody is there")


class ComesShort(Rolls):
    """Its way back ends 8 mm ahead of where it began."""

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        yield from retrace(robot, start, trace)
        yield from robot.wait(0.5)
        for _ in range(5):
            robot.base.drive(0.008 / (5 * robot.period), 0.0)
            yield


class Inches(Wave):
    """Moves the base by 12 mm, less than what a Fail may leave."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(10):
            robot.base.drive(0.0012 / robot.period, 0.0)
            yield


class Watched(Wave):
    """Watches for a person who comes after half a second, also while restoring."""

    also_back: bool = False
    _asked: int = 0

    def watch(self, robot: Robot, model: ModelView) -> None:
        self._asked += 1
        if self._asked == 10 or (self.also_back and self._asked > 20):
            raise Discrepancy("somebody stands there")


def at(rig: Any) -> tuple[float, ...]:
    """The true base and the commanded joints."""
    return (*rig.scene.base, *rig.robot.arm.command())


def count_stops(rig: Any) -> list[float]:
    """Return the times at which the robot is stopped from now on."""
    stops: list[float] = []
    stop = rig.robot.stop

    def noted() -> None:
        stops.append(rig.robot.time)
        stop()

    rig.robot.stop = noted
    return stops
