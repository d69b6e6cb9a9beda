"""Primitives with inner structure: a py_trees behaviour tree inside the contract of a primitive."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Generator, Mapping

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from handcart.backends.robot.robot import Robot
from handcart.primitives.clock.tick_clock import robot_clock
from handcart.primitives.clock.wall_clock import refuse_wall_clock
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause import FRAMEWORK_MODULES
from handcart.primitives.outcomes.cause_kind import CauseKind
from handcart.primitives.outcomes.discrepancy import Discrepancy

from .action_primitive import ActionPrimitive, Periods

FRAMEWORK_MODULES.add(__name__)
Step = Callable[[], Generator[None, None, bool | None]]
"""Function that begins the motion of a tree's leaf; a motion that returns False has failed."""


class TreePrimitive(ActionPrimitive):
    """Primitive whose motion is a behaviour tree, ticked once a period.

    The tree's SUCCESS ends the motion; its FAILURE is a `Discrepancy` with the message of the leaf that
    failed. An exception of a leaf leaves the tree at once: a Selector does not treat `Discrepancy` or
    `NeedsPerson` as a failure that another child could repair. Running leaves are stopped at every end of
    the motion.

    Behaviours of py_trees that measure time (`Timer`, `Timeout`) use the robot's clock. A behaviour whose own
    code reads the wall clock is rejected when a task is loaded, and before the first tick.
    """

    @abstractmethod
    def tree(self, robot: Robot, model: ModelView) -> Behaviour:
        """Return a new behaviour tree for this attempt of the primitive.

        Robot and model may only be used when the leaves run, not while the tree is built, because
        `handcart describe` builds the tree without them.
        """

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        """Tick the behaviour tree once a period until it ends."""
        with robot_clock(lambda: robot.time):
            root = self.tree(robot, model)
        yield from ticked(root, lambda: robot.time)


class GeneratorBehaviour(Behaviour):
    """Leaf of a behaviour tree that runs a generator, one step for each tick.

    Its status is RUNNING while the generator yields, FAILURE if the generator returns False, and SUCCESS if
    it returns anything else.
    """

    def __init__(self, name: str, factory: Step) -> None:
        """Name the leaf; `factory` is called each time that the leaf starts."""
        super().__init__(name)
        self._factory = factory
        self._periods: Generator[None, None, bool | None] | None = None

    def initialise(self) -> None:
        """Begin a new generator of the leaf's motion; py_trees calls this when the leaf starts."""
        self._periods = self._factory()

    def update(self) -> Status:
        """Run the generator for one period, and return RUNNING, or the leaf's final status if it has
        ended.
        """
        if self._periods is None:
            return Status.INVALID
        try:
            next(self._periods)
        except StopIteration as end:
            return Status.FAILURE if end.value is False else Status.SUCCESS
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Close the generator when the leaf ends, so that its `finally` blocks run at once. `new_status` is
        the leaf's status from now on.
        """
        if self._periods is not None and new_status != Status.RUNNING:
            self._periods.close()
            self._periods = None


def leaves(steps: Mapping[str, Step]) -> list[Behaviour]:
    """Return a leaf of a behaviour tree for each step, under the step's name.

    In a composite of py_trees with memory, such as a Sequence, a leaf begins in the same control period in
    which the leaf before it ends, so that no period is lost between two steps.
    """
    return [GeneratorBehaviour(name, step) for name, step in steps.items()]


def ticked(root: Behaviour, now: Callable[[], float]) -> Periods:
    """Tick a behaviour tree once a period until it has succeeded.

    Args:
        root: a new tree.
        now: function that returns the robot's time, in [s], which replaces the wall clock inside the tree.

    Raises:
        Discrepancy: the tree failed.
        WallClockError: the code of a behaviour in the tree reads the wall clock.
    """
    refuse_wall_clock(root.iterate())
    with robot_clock(now):
        root.setup_with_descendants()
    try:
        while True:
            with robot_clock(now):
                root.tick_once()
            if root.status == Status.SUCCESS:
                return
            if root.status != Status.RUNNING:
                raise Discrepancy(_why(root), cause=_cause_of(root))
            yield
    finally:
        with robot_clock(now):
            root.stop(Status.INVALID)
            for node in root.iterate():
                node.shutdown()


def _failed_leaf(root: Behaviour) -> Behaviour:
    tip = root.tip()
    return tip if tip is not None and tip.status == Status.FAILURE else root


def _cause_of(root: Behaviour) -> CauseKind:
    """Return the cause that the failed leaf names in its attribute `cause`."""
    cause = getattr(_failed_leaf(root), "cause", None)
    return cause if isinstance(cause, CauseKind) else causes.TREE_FAILED


def _why(root: Behaviour) -> str:
    failed = _failed_leaf(root)
    return failed.feedback_message or f"{failed.name} failed"
