"""The chain from a primitive to the reading that decided, as an attempt leaves it."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, ClassVar

import pytest
from py_trees.behaviour import Behaviour

from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.tree_primitive import GeneratorBehaviour, TreePrimitive
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.outcomes.outcome import Fail, GiveUp
from handcart.primitives.restoring.snapshot import Seen
from tests.primitives.conftest import Rig

FELT = Measured("Arm", "force that resists", 8.0, 7.0, "N")


class Try(ActionPrimitive):
    """Turns a little, and ends in the method given by `where`."""

    where: str
    needs: ClassVar = (Base,)

    def observe(self, robot: Robot, model: ModelView) -> Generator[None, None, Seen]:
        yield
        self._perhaps("observe")
        return {}

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(5):
            robot.base.drive(0.0, 0.1)
            yield
        yield from self._deeper()

    def watch(self, robot: Robot, model: ModelView) -> None:
        self._perhaps("watch")

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        yield
        return self.where != "effect"

    def _deeper(self) -> Periods:
        yield
        if self.where == "a fault":
            raise ZeroDivisionError("division by zero")
        if self.where == "a person":
            raise NeedsPerson("it squeaks", FELT)
        self._perhaps("motion")

    def _perhaps(self, here: str) -> None:
        if self.where == here:
            raise Discrepancy("it resists", measured=FELT)


class NoWayBack(Try):
    """Raises on the way back too."""

    def restore(self, *_: Any) -> Periods:
        yield
        raise Discrepancy("the way back is blocked")


class Branch(TreePrimitive):
    """Fails in a leaf of a behaviour tree."""

    needs: ClassVar = (Base,)

    def tree(self, robot: Robot, model: ModelView) -> Behaviour:
        return GeneratorBehaviour("push", lambda: self._push())

    def _push(self) -> Generator[None, None, None]:
        yield
        raise Discrepancy("it resists", measured=FELT)


@pytest.fixture
def rig(make_rig: Callable[..., Rig]) -> Rig:
    return make_rig()


@pytest.mark.parametrize(
    ("where", "calls"),
    [
        ("observe", ("Try.observe", "Try._perhaps")),
        ("motion", ("Try.motion", "Try._deeper", "Try._perhaps")),
        ("watch", ("Try.watch", "Try._perhaps")),
    ],
)
def test_who_found_it_and_by_what(rig: Rig, where: str, calls: tuple[str, ...]) -> None:
    primitive = Try(where=where)
    rig.run(primitive)
    cause = primitive.evidence.causes[0]  # a watch is also active on the way back
    assert (cause.check, cause.calls, cause.measured) == (where, calls, FELT)


def test_an_effect_that_is_not_seen(rig: Rig) -> None:
    primitive = Try(where="effect")
    outcome = rig.run(primitive)
    assert isinstance(outcome, Fail)
    assert primitive.evidence.causes[0].check == "effect"
    assert outcome.residuals.limits["base_mm"] == rig.robot.spec.tolerance.base_mm


def test_a_fault_in_the_code_is_told_as_one(rig: Rig) -> None:
    primitive = Try(where="a fault")
    rig.run(primitive)
    (cause,) = primitive.evidence.causes
    assert (cause.check, cause.fault, cause.calls[-1]) == ("motion", "ZeroDivisionError", "Try._deeper")


def test_a_person_is_needed(rig: Rig) -> None:
    primitive = Try(where="a person")
    assert isinstance(rig.run(primitive), GiveUp)
    assert primitive.evidence.causes[0].measured == FELT


def test_a_way_back_that_failed_is_the_second_link(rig: Rig) -> None:
    primitive = NoWayBack(where="motion")
    assert isinstance(rig.run(primitive), GiveUp)
    first, second = primitive.evidence.causes
    assert not first.restoring
    assert (second.restoring, second.check, second.reason) == (True, "restore", "the way back is blocked")


def test_a_leaf_of_a_tree(rig: Rig) -> None:
    primitive = Branch()
    rig.run(primitive)
    (cause,) = primitive.evidence.causes
    assert (cause.calls, cause.measured) == (("Branch._push",), FELT)
    assert cause.check == "motion"


def test_a_success_has_no_cause(rig: Rig) -> None:
    primitive = Try(where="nowhere")
    rig.run(primitive)
    assert primitive.evidence.causes == []
