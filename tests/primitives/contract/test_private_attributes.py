"""Private attributes of a primitive are pydantic's, only faster."""

import copy
from typing import Any

import pytest
from pydantic import PrivateAttr
from pydantic._internal._model_construction import init_private_attributes

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView


class Waves(ActionPrimitive):
    """Has some of them."""

    times: int = 2
    _done: int = PrivateAttr(default=0)
    _where: list[str] = PrivateAttr(default_factory=list)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        """Nothing."""
        yield

    @property
    def broken(self) -> int:
        """Asks for what isn't there."""
        return int(self.nothing)  # type: ignore[attr-defined]


def test_each_has_its_own() -> None:
    one, other = Waves(), Waves(times=3)
    one._done += 1
    one._where.append("here")
    assert (one._done, one._where, one.times) == (1, ["here"], 2)
    assert (other._done, other._where, other.times) == (0, [], 3)


class Counted(Waves):
    """Sets one of its own after pydantic."""

    _limits: dict[str, list[int]] = PrivateAttr(default={"x": [1]})
    _late: str = PrivateAttr()
    _all: int = PrivateAttr(default=0)

    def model_post_init(self, context: Any, /) -> None:
        """Add what is known only then."""
        super().model_post_init(context)
        self._all = self.times + len(self._limits)


class Further(Counted):
    """Inherits all of them."""


@pytest.mark.parametrize("kind", [Waves, Counted, Further])
def test_private_defaults_are_those_of_pydantic(kind: type[Waves]) -> None:
    ours, theirs = kind(times=5), kind(times=5)
    object.__setattr__(theirs, "__pydantic_private__", None)
    init_private_attributes(theirs, None)
    known = dict(ours.__pydantic_private__ or {})
    if isinstance(ours, Counted):
        assert known.pop("_all") == 6
        assert known["_limits"] is not kind(times=5)._limits  # type: ignore[attr-defined]
        assert "_late" not in known
    assert {name: (theirs.__pydantic_private__ or {})[name] for name in known} == known


def test_a_copy_takes_them_along() -> None:
    one = Waves()
    one._where.append("here")
    deep = copy.deepcopy(one)
    deep._where.append("there")
    assert (one._where, deep._where) == (["here"], ["here", "there"])
    assert Waves.model_construct()._done == 0


@pytest.mark.parametrize("one", [Waves(), Waves.__new__(Waves)])
def test_what_is_not_there_is_missed_by_its_name(one: Any) -> None:
    assert not hasattr(one, "nothing")
    with pytest.raises(AttributeError, match=r"nothing|__pydantic_private__"):
        _ = one.nothing


def test_a_property_that_asks_for_what_is_not_there_says_so() -> None:
    with pytest.raises(AttributeError, match=r"nothing|broken"):
        _ = Waves().broken


def test_findings_of_an_attempt_are_kept_by_name() -> None:
    one = Waves()
    one.found(depth_mm=3.0, side="left")
    one.found(depth_mm=4.0)
    assert one.evidence.facts == {"depth_mm": 4.0, "side": "left"}
