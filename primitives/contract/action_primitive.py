"""The base class of all primitives."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Generator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import PrivateAttr

from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.files.models.model import FileModel
from handcart.files.models.private_defaults import replace_private_defaults
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.preconditions.hand_use import USE_UNDECLARED, USES_NO_FINGERS, HandUse
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Seen, Snapshot
from handcart.primitives.restoring.trace import Trace

from .intents import UNRECORDED_INTENTS, Intents
from .tracking_error_monitor import TRACKING_TOLERANCE_RAD

Periods = Generator[None, None, None]


class ActionPrimitive(FileModel, ABC):
    """Basic motion that restores the robot before it fails.

    A subclass declares its parameters as annotated fields, the capabilities it needs, the entries of the
    world model that it reads and writes, and implements `motion`: a generator that yields once a period.
    If `motion` returns, the outcome is Success once `effect` is observed; if it raises `Discrepancy`, the
    framework restores the robot and reports Fail; if it raises `NeedsPerson`, the robot stops and gives
    up. Each attempt gets a new instance, so state of one attempt may be kept in private attributes.
    """

    needs: ClassVar[tuple[type[Capability], ...]] = ()
    """Capabilities that the robot must have; `Camera` means a camera on the hand."""
    reads: ClassVar[tuple[str, ...]] = ()
    """Entries of the world model that it may read."""
    writes: ClassVar[tuple[str, ...]] = ()
    """Entries of the world model that it may write (and read)."""
    results: ClassVar[tuple[str, ...]] = ()
    """Names of results that Success may have besides the usual one; `evidence.result` is set to one."""
    only_knowledge: ClassVar[bool] = False
    """True if the primitive moves nothing, so that nothing has to settle or to be restored."""
    hand: ClassVar[HandUse | None] = None
    """Required content of the hand at the start, and its content after Success. None: nothing is required,
    and only a primitive that does not need the gripper leaves the hand as it was.
    """
    needs_pose: ClassVar[bool] = True
    """True if the pose of the base on the map must be known before it starts."""
    draws_map: ClassVar[bool] = False
    """True if the primitive draws a map, so that it may begin without one."""
    max_joint_error: ClassVar[float] = TRACKING_TOLERANCE_RAD
    """Largest distance of a joint from its commands, in [rad] or [m]: more means that the arm is stuck."""
    asks_permission: ClassVar[bool] = False
    """True if a person has to permit each start. An entry with `permit` "none" needs none."""
    arm_inside: ClassVar[bool] = False
    """The hand must be within the robot's footprint before it starts, because the base drives."""

    _evidence: Evidence = PrivateAttr(default_factory=Evidence)
    _no_return: str | None = PrivateAttr(default=None)
    _intents: Intents = PrivateAttr(default_factory=lambda: UNRECORDED_INTENTS)  # a default would be copied

    if not TYPE_CHECKING:  # a checker takes private attributes for ordinary ones

        def __getattr__(self, name: str) -> Any:
            """Return private attributes directly, because they are read each period and pydantic's lookup is
            slow.

            Values are returned as they were set: a function is not bound.
            """
            try:
                return object.__getattribute__(self, "__pydantic_private__")[name]
            except (AttributeError, KeyError, TypeError):
                return super().__getattr__(name)

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        """Let instances of a new subclass set the defaults of their private attributes fast."""
        super().__pydantic_init_subclass__(**options)
        replace_private_defaults(cls)

    @classmethod
    def label(cls) -> str:
        """Return the primitive's name in task files; for example, the class `MoveTo` is MOVE_TO."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).upper()

    @classmethod
    def usual_hand_use(cls) -> HandUse:
        """Return the content of the hand that the primitive requires at its start, and the content that it
        has after Success.

        If a primitive's parameters decide this content, `hand_use` of an instance may return another one.
        """
        if cls.hand is not None:
            return cls.hand
        return USE_UNDECLARED if Gripper in cls.needs and not cls.only_knowledge else USES_NO_FINGERS

    def hand_use(self) -> HandUse:
        """Return the content of the hand that is required at the start, and the content after Success.

        A subclass overrides this method if its parameters decide the content.
        """
        return self.usual_hand_use()

    def needs_arm_inside(self) -> bool:
        """Return whether the hand must be within the robot's footprint at the start.

        A subclass whose parameters decide this overrides it.
        """
        return self.arm_inside

    def thing(self, model: ModelView) -> str:
        """Return the name, in simulated worlds, of the thing that the primitive takes, carries or releases.

        The name is empty if there is no such thing, or if its name is not known.
        """
        return ""

    def lacking(self, kinds: Sequence[type[Capability]], model: ModelView) -> str:
        """Return, in words, what the robot lacks for this instance's parameters; empty if it lacks nothing.

        The method is called when a task is checked. If it returns a text, the task is refused, as it is for
        capabilities in `needs` that the robot lacks.

        Args:
            kinds: classes of the robot's capabilities.
            model: world model before the start.
        """
        return ""

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message about a condition for the start that is not met; empty if all are met.

        The method is called at rest, after the declared conditions on the hand's content (`hand`) and the
        arm's posture (`arm_inside`) were checked. If it returns a message, the action is not started, which
        counts as a Fail of the action, and the run is planned again.
        """
        return ""

    @abstractmethod
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        """Control the robot during the primitive's motion, as a generator that yields once in each control
        period.
        """

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Check a condition that must hold during the motion; called once a period, also while restoring.

        Raises:
            Discrepancy: the motion must not continue.
        """
        return

    def observe(self, robot: Robot, model: ModelView) -> Generator[None, None, Seen]:
        """Return the positions of the objects that the motion will touch, measured now; by default none.

        The method is called at rest before the motion and after restoring; the two results are compared.
        """
        return {}
        yield

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the wanted effect is observed; called at rest at the end of the motion.

        The default is True, for primitives whose effect no sensor can observe.
        """
        return True
        yield

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Bring the robot, and objects that it moved, back to `start`.

        By default the recorded motion is played backwards.

        Args:
            robot: the robot.
            model: the world model.
            start: state of the robot before the motion.
            trace: record of the motion.
        """
        yield from retrace(robot, start, trace)

    def base_room(self, robot: Robot, model: ModelView) -> float:
        """Return the largest distance from the start at which the base may end after a Fail, in [m].

        Further away, the next action might not be possible, so that the outcome is GiveUp. The tolerance in
        the robot's file is checked as well; the default here is infinity.
        """
        return math.inf

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Return the contacts that the motion intends between robot, held object and surroundings.

        It is only called in simulation, to judge outcomes, with a world model that has the ground truth. A
        Success with any other contact of the robot counts as false.
        """
        return ()

    def finish(self, robot: Robot, model: ModelView) -> Generator[None, None, bool | None]:
        """Bring the robot into a safe posture after an interruption that follows a point of no return.

        It takes the place of restoring, which is impossible after such a point. If a fault interrupts it, it
        is called again, as often as the task allows restoring.

        Returns:
            True if the motion was completed and its effect measured. The outcome is Success only if the
            result is True and a fault of a machine or of code caused the interruption; otherwise it is
            GiveUp.
        """
        return False
        yield

    def intend(self, effect: str) -> Periods:
        """Announce an effect, and wait until the announcement is stored; the robot holds meanwhile.

        A primitive announces effects of which a crash would leave unknown whether they happened, such as
        fingers that close or open.
        """
        self._intents.intends(effect)
        while not self._intents.kept:
            yield

    def point_of_no_return(self, what: str) -> None:
        """Declare that effects of the motion from now on can't be undone, so that only Success or GiveUp can
        follow; `what` names the step in the journal.
        """
        self._no_return = what
        self._intents.passed(what)

    def found(self, **what: float | str) -> None:
        """Record measured or derived values by name for the journal and the summary, as in
        `found(force_n=3.1)`. A later value of a name replaces an earlier one.
        """
        self._evidence.facts.update(what)

    @property
    def met_fault(self) -> bool:
        """True if the motion was broken off by a fault of a machine or of code.

        Discrepancies with the world model, and requests of a person, are no faults.
        """
        found = self._evidence.causes
        return bool(found) and found[0].kind in causes.FAULT_CAUSES

    @property
    def evidence(self) -> Evidence:
        """Findings of this attempt, with the pictures and scans that decided it."""
        # Looked up directly: `_evidence` takes a failing look-up in the class first.
        found: Evidence = (self.__pydantic_private__ or {})["_evidence"]
        return found

    @property
    def facts(self) -> Mapping[str, float | str]:
        """Measured or derived values of this attempt, numbers and texts by name, for the journal and the
        summary.
        """
        return self.evidence.facts
