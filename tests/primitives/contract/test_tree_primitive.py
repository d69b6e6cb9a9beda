"""Tests of behaviour trees as primitives: handcart's own behaviours, and foreign ones."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, ClassVar

import numpy as np
import pytest
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Failure, Running, TickCounter
from py_trees.behaviours import Success as Always
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Inverter, Retry

from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.primitives.books.books import Books
from handcart.primitives.contract.behaviour_primitive import behaviour_primitive
from handcart.primitives.contract.tree_primitive import GeneratorBehaviour, TreePrimitive, leaves, ticked
from handcart.primitives.knowledge.world_model import ModelView, UndeclaredAccess
from handcart.primitives.outcomes.discrepancy import Discrepancy, NeedsPerson
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from tests.primitives.conftest import Rig


def periods(root: Behaviour) -> int:
    """Periods until the tree has succeeded."""
    return sum(1 for _ in ticked(root, lambda: 0.0))


def steps(count: int, log: list[str], name: str, value: bool | None = None) -> GeneratorBehaviour:
    """A leaf that runs for `count` periods and notes its begin, end and cleaning up."""

    def run() -> Generator[None, None, bool | None]:
        log.append(f"{name} begins")
        try:
            for _ in range(count):
                yield
            log.append(f"{name} ends")
        finally:
            log.append(f"{name} cleans up")
        return value

    return GeneratorBehaviour(name, run)


def test_a_sequence_of_generators_takes_the_periods_of_all() -> None:
    log: list[str] = []
    root = Sequence("all", memory=True, children=[steps(3, log, "a"), steps(0, log, "b"), steps(2, log, "c")])
    assert periods(root) == 5
    assert [entry for entry in log if "ends" in entry] == ["a ends", "b ends", "c ends"]


def test_a_failure_speaks_the_words_of_the_leaf_that_failed() -> None:
    leaf = Failure("look")

    def update() -> Status:
        leaf.feedback_message = "the lamp is out"
        return Status.FAILURE

    leaf.update = update  # type: ignore[method-assign]
    with pytest.raises(Discrepancy, match=r"^the lamp is out$"):
        periods(Sequence("all", memory=True, children=[Always("ok"), leaf]))


class Mute(Behaviour):
    """Fails without a word."""

    def update(self) -> Status:
        return Status.FAILURE


@pytest.mark.parametrize(
    ("root", "words"),
    [
        (Sequence("all", memory=True, children=[Mute("reach for it")]), "reach for it failed"),
        (Inverter("not", Always("seen")), "success -> failure"),
        (steps(2, [], "turn", value=False), "turn failed"),
    ],
    ids=["sequence", "inverter", "generator"],
)
def test_a_failure_has_words_whatever_fails(root: Behaviour, words: str) -> None:
    with pytest.raises(Discrepancy) as caught:
        periods(root)
    assert caught.value.reason == words


def test_a_selector_takes_a_failure_for_one() -> None:
    log: list[str] = []
    root = Selector("any", memory=True, children=[steps(1, log, "a", value=False), steps(1, log, "b")])
    assert periods(root) == 2
    assert "b ends" in log


def test_only_a_retry_lets_a_period_pass_before_the_next_try() -> None:
    ends = iter([False, True] * 2)

    def once() -> Generator[None, None, bool]:
        yield
        return next(ends)

    assert periods(Selector("any", memory=True, children=leaves({"one": once, "other": once}))) == 2
    assert periods(Retry("again", GeneratorBehaviour("once", once), 2)) == 3


@pytest.mark.parametrize("error", [NeedsPerson("a cable is torn"), Discrepancy("the light went out")])
def test_no_selector_goes_on_after_what_a_leaf_raises(error: Exception) -> None:
    log: list[str] = []

    def torn() -> Generator[None, None, None]:
        yield
        raise error

    children = [GeneratorBehaviour("torn", torn), steps(1, log, "other")]
    with pytest.raises(type(error), match=str(error)):
        periods(Selector("any", memory=True, children=children))
    assert log == []


def test_leaves_that_run_are_stopped_however_the_tree_ends() -> None:
    log: list[str] = []
    both = Parallel("both", ParallelPolicy.SuccessOnOne(), children=[steps(1, log, "a"), steps(9, log, "b")])
    assert periods(both) == 1
    assert log[-1] == "b cleans up"

    root = ticked(steps(9, log, "c"), lambda: 0.0)
    next(root)
    with pytest.raises(Discrepancy, match="cancelled"):
        root.throw(Discrepancy("cancelled"))
    assert log[-1] == "c cleans up"


class Turn(Behaviour):
    """Foreign behaviour that turns the base a little."""

    def __init__(self, robot: Robot, count: int, end: Status) -> None:
        super().__init__("turn")
        self._robot, self._left, self._end = robot, count, end
        self.lives = [0, 0]

    def setup(self, **_: Any) -> None:
        self.lives[0] += 1

    def shutdown(self) -> None:
        self.lives[1] += 1

    def update(self) -> Status:
        self._left -= 1
        if self._left < 0:
            self.feedback_message = "the wheels squeak"
            return self._end
        self._robot.base.drive(0.0, 0.3)
        return Status.RUNNING


class TestForeignBehaviour:
    def test_it_serves_as_a_primitive(self, make_rig: Callable[..., Any]) -> None:
        made: list[Turn] = []

        def make(robot: Robot, model: ModelView) -> Behaviour:
            made.append(Turn(robot, 20, Status.SUCCESS))
            return made[-1]

        TurnAround = behaviour_primitive("TurnAround", make, needs=(Base,))
        rig = make_rig()
        heading = rig.robot.pose.theta
        assert TurnAround.label() == "TURN_AROUND"
        assert isinstance(rig.run(TurnAround()), Success)
        assert rig.robot.pose.theta - heading == pytest.approx(0.3, abs=0.03)
        assert made[0].lives == [1, 1]

    def test_its_failure_is_restored(self, make_rig: Callable[..., Any]) -> None:
        TurnAround = behaviour_primitive(
            "TurnAround", lambda robot, model: Turn(robot, 20, Status.FAILURE), needs=(Base,)
        )
        rig = make_rig()
        heading = rig.scene.base.theta
        outcome = rig.run(TurnAround())
        assert isinstance(outcome, Fail)
        assert outcome.reason == "the wheels squeak"
        assert rig.scene.base.theta == pytest.approx(heading, abs=0.02)

    def test_what_it_reads_is_declared(self, make_rig: Callable[..., Any]) -> None:
        Peek = behaviour_primitive("Peek", lambda robot, model: Always(str(model.of(Books).slot)))
        outcome = make_rig().run(Peek())
        assert isinstance(outcome, Fail)
        assert UndeclaredAccess.__name__ in outcome.reason
        Peek = behaviour_primitive(
            "Peek", lambda robot, model: Always(str(model.of(Books).slot)), reads=("slot",)
        )
        assert isinstance(make_rig().run(Peek()), Success)

    def test_a_counter_from_py_trees_itself(self, make_rig: Callable[..., Any]) -> None:
        Count = behaviour_primitive("Count", lambda robot, model: TickCounter("count", 7, Status.SUCCESS))
        assert isinstance(make_rig().run(Count()), Success)


class Careful(TreePrimitive):
    """Moves, then needs a person, although a Selector has an alternative."""

    needs: ClassVar = (Base,)

    def tree(self, robot: Robot, model: ModelView) -> Behaviour:
        def need() -> Generator[None, None, None]:
            robot.base.drive(0.1, 0.0)
            yield
            raise NeedsPerson("the door is locked")

        children = [GeneratorBehaviour("open the door", need), Running("wait")]
        return Selector("in any way", memory=True, children=children)


def test_a_person_needed_inside_a_selector_is_a_give_up(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    outcome = rig.run(Careful())
    assert isinstance(outcome, GiveUp)
    assert outcome.reason == "the door is locked"
    before = np.array(rig.scene.base)
    rig.drive(rig.robot.wait(0.5))
    assert np.array_equal(before, np.array(rig.scene.base))
