"""Causes that a primitive can raise, as read from its code."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from handcart.backends.backend import CommandError
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.raised_causes import causes_of, framework_causes, possible_causes
from handcart.primitives.contract.tree_primitive import TreePrimitive
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause_kind import CauseKind
from handcart.primitives.outcomes.discrepancy import Discrepancy, NeedsPerson
from handcart.primitives.outcomes.outcome import Fail, GiveUp
from handcart.primitives.registry import primitive_class, primitive_names
from tests.primitives.conftest import Rig

MELTED = CauseKind("melted", "The ice melted.")
FROZEN = CauseKind("frozen", "The water is frozen.")


def check_ice() -> None:
    """Raise what the primitive's own helper finds."""
    raise Discrepancy("it dripped", cause=MELTED)


class Skate(ActionPrimitive):
    """Ends in the way given by `how`."""

    how: str = ""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield
        if self.how == "helper":
            check_ice()
        if self.how == "inner":

            def fall() -> None:
                self._fall()

            fall()
        if self.how == "late":
            from handcart.primitives.books.book_causes import JAMMED

            raise Discrepancy("stuck", cause=JAMMED)
        if self.how == "refused":
            raise CommandError("too fast")
        if self.how == "bug":
            raise ZeroDivisionError("division by zero")
        if self.how == "nameless":
            raise Discrepancy("who knows")

    def _fall(self) -> None:
        raise NeedsPerson("it fell", cause=FROZEN)


class Glide(Skate):
    """Inherits all."""


class Sleigh(TreePrimitive):
    """A tree with one leaf, which fails."""

    named: bool = True

    def tree(self, robot: Robot, model: ModelView) -> Behaviour:
        leaf = Leaf("slide")
        if self.named:
            leaf.cause = causes.BLOCKED
        return leaf


class Leaf(Behaviour):
    """Fails at once."""

    cause: CauseKind | None = None

    def update(self) -> Status:
        return Status.FAILURE


def test_causes_are_found_in_helpers_and_late_imports() -> None:
    assert [kind.name for kind in causes_of(Skate)] == ["frozen", "jammed", "melted"]
    assert causes_of(Glide) == causes_of(Skate)
    assert set(possible_causes(Skate)) == {*causes_of(Skate), *framework_causes()}


def test_causes_of_shipped_primitives_are_their_own() -> None:
    found = {name: {kind.name for kind in causes_of(primitive_class(name))} for name in primitive_names()}
    assert {"jammed", "slipped", "neighbour_pushed", "arm_blocked"} <= found["INSERT"]
    assert {"blocked", "no_route", "lost", "undetermined"} <= found["MOVE_TO"]
    assert "jammed" not in found["MOVE_TO"] | found["STACK"]
    assert found["STAND"] == set()


def test_framework_causes_hold_for_any_primitive() -> None:
    names = {cause.name for cause in framework_causes()}
    assert {"no_rest", "no_effect", "precondition", "displaced", "base_stopped", "not_following"} <= names
    assert {"cancelled", "time_out", "code_error", "robot_fault"} <= names
    assert "jammed" not in names


@pytest.mark.parametrize(
    ("how", "outcome", "cause"),
    [
        ("helper", Fail, MELTED),
        ("inner", GiveUp, FROZEN),
        ("refused", Fail, causes.ROBOT_FAULT),
        ("bug", Fail, causes.CODE_ERROR),
        ("nameless", Fail, causes.UNNAMED),
    ],
)
def test_an_outcome_carries_the_cause(
    make_rig: Callable[..., Rig], how: str, outcome: type, cause: CauseKind
) -> None:
    primitive = Skate(how=how)
    found: Any = make_rig().run(primitive)
    assert (type(found), found.cause) == (outcome, cause)
    assert primitive.evidence.causes[0].kind == cause
    assert cause in possible_causes(Skate)


@pytest.mark.parametrize(("named", "cause"), [(True, causes.BLOCKED), (False, causes.TREE_FAILED)])
def test_a_leaf_of_a_tree_may_name_its_cause(
    make_rig: Callable[..., Rig], named: bool, cause: CauseKind
) -> None:
    found: Any = make_rig().run(Sleigh(named=named))
    assert found.cause == cause
