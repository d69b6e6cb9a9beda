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
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.preconditions.hand_use import UNDECLARED, UNUSED, HandUse
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Seen, Snapshot
from handcart.primitives.restoring.trace import Trace

from .evidence import Evidence
from .intents import UNKEPT, Intents
from .meant_contact import MeantContact

Periods = Generator[None, None, None]


class ActionPrimitive(FileModel, ABC):
    """One basic motion that looks after itself.

    A subclass states its parameters as annotated fields, what it needs and what it reads and writes of the
    world model, and writes `motion`: a generator that hands back control once a period. Ending `motion` by
    returning means Success once `effect` is seen; raising `Discrepancy` means that the framework restores and
    reports Fail; raising `NeedsPerson` stops and gives up. A new instance is made for each attempt, so what
    belongs to one attempt may be kept in private attributes.
    """

    needs: ClassVar[tuple[type[Capability], ...]] = ()
    """What the robot must have."""
    reads: ClassVar[tuple[str, ...]] = ()
    """Entries of the world model that it may read."""
    writes: ClassVar[tuple[str, ...]] = ()
    """Entries of the world model that it may write (and read)."""
    only_knowledge: ClassVar[bool] = False
    """It doesn't move anything, so nothing has to settle and nothing is restored."""
    hand: ClassVar[HandUse | None] = None
    """What the hand must hold before it starts, and holds after its Success. None: nothing is required, and
    only a primitive that does not need the gripper leaves the hand as it was."""
    arm_inside: ClassVar[bool] = False
    """The hand must be within the robot's footprint before it starts, because the base drives."""

    _evidence: Evidence = PrivateAttr(default_factory=Evidence)
    _no_return: str | None = PrivateAttr(default=None)
    _intents: Intents = PrivateAttr(default_factory=lambda: UNKEPT)  # a default would be copied

    if not TYPE_CHECKING:  # a checker takes private attributes for ordinary ones

        def __getattr__(self, name: str) -> Any:
            """Private attributes at once: they are asked in each period, and pydantic takes long.

            As they were set: a function isn't bound.
            """
            try:
                return object.__getattribute__(self, "__pydantic_private__")[name]
            except (AttributeError, KeyError, TypeError):
                return super().__getattr__(name)

    @classmethod
    def label(cls) -> str:
        """How task files call it: `MoveTo` is MOVE_TO."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).upper()

    @classmethod
    def usual_hand_use(cls) -> HandUse:
        """Return what instances require of the hand and leave in it, where parameters do not decide."""
        if cls.hand is not None:
            return cls.hand
        return UNDECLARED if Gripper in cls.needs and not cls.only_knowledge else UNUSED

    def hand_use(self) -> HandUse:
        """Return what it requires of the hand and leaves in it; override where parameters decide."""
        return self.usual_hand_use()

    def needs_arm_inside(self) -> bool:
        """Return whether the hand must be within the footprint; override where parameters decide."""
        return self.arm_inside

    def thing(self, model: ModelView) -> str:
        """Return the name of the thing that it takes, carries or lets go, as simulated worlds call it.

        Empty: not known yet, or any thing.
        """
        return ""

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return what else stands in the way of its start, in words; empty if nothing does.

        Called at rest, after `hand` and `arm_inside` were checked, and before anything moves. The action is
        then not started, which counts as its Fail, and the run is planned again.
        """
        return ""

    @abstractmethod
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        """One choice of actuators and sensor feedback, until its end is reached."""

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Asked every period before the motion goes on, also while restoring; raises `Discrepancy`."""
        return

    def observe(self, robot: Robot, model: ModelView) -> Generator[None, None, Seen]:
        """Measure the objects that the motion will touch: before the start, and after a restore."""
        return {}
        yield

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Asked at rest at the end: whether what was to be achieved is seen."""
        return True
        yield

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Bring everything back to `start`; by default the recorded motion is played backwards."""
        yield from retrace(robot, start, trace)

    def base_room(self, robot: Robot, model: ModelView) -> float:
        """How far from where it began the base may stand at most for a Fail, in [m], so that what follows can
        still be done; never more than the robot's file allows."""
        return math.inf

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """What it means to touch; whatever else the robot runs into makes its Success untrue.

        Asked by those who see the ground truth, when something is touched; nobody acts on it.
        """
        return ()

    def finish(self, robot: Robot, model: ModelView) -> Periods:
        """After a point of no return: bring the robot out of the way; nothing is retraced."""
        return
        yield

    def intend(self, effect: str) -> Periods:
        """Say what is about to be done, and wait until that is safely noted; the robot holds meanwhile.

        For effects of which a crash would leave unknown whether they happened: fingers that close on
        something or let go, a tool that is changed.
        """
        self._intents.intends(effect)
        while not self._intents.kept:
            yield

    def point_of_no_return(self, what: str) -> None:
        """Declare that what happens from here on can't be undone; only Success or GiveUp is left."""
        self._no_return = what
        self._intents.passed(what)

    def found(self, **what: float | str) -> None:
        """Note what was found, for the journal and the summary."""
        self._evidence.facts.update(what)

    @property
    def evidence(self) -> Evidence:
        """What this attempt found, with the pictures and scans that decided it."""
        return self._evidence

    @property
    def facts(self) -> Mapping[str, float | str]:
        """What this attempt found, in figures and words."""
        return self._evidence.facts
