"""Survey of the contacts of the robot in a run: part of the robot, touched body, time and force."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.backends.simulation.body.arm_contact import LOAD_NAME
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.knowledge.meant_contact import RobotPart
from handcart.primitives.outcomes.outcome import Outcome, Success
from handcart.robotics.kinematics.arm_model import ArmModel

from .survey import Survey, SurveyedRun

FINGERS_BODY = "fingers"  # both fingers together, as one body that pushes
STANDING_SPEED_M_S = 0.02  # of the base; below it the base is at rest, and the other body ran into it
MAX_LISTED_CONTACTS = 8  # contacts listed one by one in a run's metrics
Pair = tuple[str, str]


@dataclass
class Touched:
    """Contact of the robot with another body during one action, or between actions.

    A contact that lasts longer than an action counts separately for each action.
    """

    part: RobotPart
    body: str
    """Name of the robot's link, or of the held body."""
    other: str
    """Name of the touched body in the world."""
    action: int
    """Number of the running action; 0 if no action was running."""
    do: str
    """Name of the primitive of the running action; empty if no action was running."""
    from_s: float
    """Begin of the contact on the robot's clock, in [s]."""
    to_s: float
    force_n: float | None
    """Largest force on the hand during the contact, in [N]; None where no force is known."""
    meant: bool
    """True if the primitive declares this contact as meant."""
    speed_m_s: float = 0.0
    """Speed of the base when the contact began, as driven or as it truly moved before, if that is more."""
    ran_into_it: bool = False
    """True if a passer ran into the base while it was at rest."""

    def __str__(self) -> str:
        how_long = f"from {self.from_s:.2f} s to {self.to_s:.2f} s"
        return f"{self.body} touched {self.other}, which it didn't mean to, {how_long}"


class ContactSurvey(Survey):
    """Observer of a simulated run that records all contacts of the robot, once per period."""

    name = "contacts"
    noted = list[Touched]

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self.contacts: list[Touched] = []
        """All contacts of the run, both finished and lasting."""
        self._running: tuple[int, ActionPrimitive] | None = None
        self._lasting: dict[Pair, Touched | None] = {}
        """Contacts that last now, by pair of bodies; None for those that began before the last action
        ended.
        """
        self._links, self._held = RobotLinks(run.world.arm), ""
        self._speed, self._base = 0.0, run.world.base
        """True speed of the base in the previous period, in [m/s], and its true pose."""

    @property
    def _passers(self) -> tuple[str, ...]:
        """Names of the passers in the world."""
        return self.run.world.passers.names

    @classmethod
    @override
    def applies(cls, run: SurveyedRun) -> bool:
        return run.scene is not None

    def started(self, number: int, primitive: ActionPrimitive) -> None:
        """Record that an action starts; contacts that exist already count as contacts of this action, too."""
        self._running, self._lasting = (number, primitive), {}

    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        """Return a message for each contact that an action with Success did not intend.

        The list is empty after a Fail or GiveUp.
        """
        unmeant = self.unmeant()
        self._running = None
        self._lasting = dict.fromkeys(self.run.world.touching)
        return [str(touched) for touched in unmeant] if isinstance(outcome, Success) else []

    def unmeant(self) -> list[Touched]:
        """Return the contacts of the running action that its primitive does not declare as intended.

        Contacts are left out in which a simulated person or cart ran into the base at rest.
        """
        number = 0 if self._running is None else self._running[0]
        own = (contact for contact in self.contacts if contact.action == number and number)
        return [item for item in own if not item.meant and not item.ran_into_it]

    def look(self, robot: Robot) -> None:
        """Record the contacts that begin, last or end in this period, with their forces."""
        world = self.run.world
        if world.held is not None:
            self._held = world.held.name
        touching = world.touching
        speed = max(abs(robot.command.along), self._speed)
        self._speed = self._base.distance(world.base) / robot.period
        self._base = world.base
        if not touching and not self._lasting:
            return
        self._lasting = {pair: touched for pair, touched in self._lasting.items() if pair in touching}
        for pair in sorted(touching):
            if pair not in self._lasting:
                self._lasting[pair] = self._begin(pair, robot.time, speed)
            each = self._lasting[pair]
            if each is not None:
                self._go_on_touching(each, robot.time)

    def _begin(self, pair: Pair, now: float, speed: float) -> Touched:
        body, other = pair
        part, number, do, meant = self._links.part(body), 0, "", False
        if self._running is not None:
            number, primitive = self._running
            do, means = primitive.label(), primitive.meant_contacts(self.run.model)
            meant = any(mean.covers(part, other) for mean in means)
        name = f"held {self._held}" if body == LOAD_NAME else body
        touched = Touched(part, name, other, number, do, round(now, 3), now, None, meant, round(speed, 3))
        touched.ran_into_it = other in self._passers and speed < STANDING_SPEED_M_S
        self.contacts.append(touched)
        return touched

    def _go_on_touching(self, each: Touched, now: float) -> None:
        each.to_s = round(now, 3)
        if each.part in ("hand", "held"):
            force = float(np.linalg.norm(self.run.world.hand_force))
            each.force_n = round(max(force, each.force_n or 0.0), 1)

    @override
    def notes(self) -> list[Touched]:
        return self.contacts

    @override
    def go_on(self, noted: list[Touched]) -> None:
        self.contacts = noted
        self._lasting = dict.fromkeys(self.run.world.touching)

    def figures(self) -> dict[str, Any]:
        """Return the number of contacts of each part of the robot, and the first unintended contacts."""
        unmeant = [contact for contact in self.contacts if not contact.meant and not contact.ran_into_it]
        seconds = sum(item.to_s - item.from_s for item in unmeant)
        counts = {f"contacts_of_{part}": _of(self.contacts, part) for part in ("base", "arm", "hand", "held")}
        return {
            **counts,
            "contacts_unmeant": len(unmeant),
            "contacts_unmeant_s": round(seconds, 2),
            "contacts": [asdict(item) for item in unmeant[:MAX_LISTED_CONTACTS]],
            **self._of_passers(),
        }

    def _of_passers(self) -> dict[str, int]:
        """Return how often the robot touched passers, and how often they ran into it while it was at rest."""
        if not self._passers:
            return {}
        own = [contact for contact in self.contacts if contact.other in self._passers]
        stood = sum(item.ran_into_it for item in own)
        return {"contacts_by_the_robot": len(own) - stood, "was_run_into_while_standing": stood}


def _of(contacts: list[Touched], part: str) -> int:
    return sum(contact.part == part for contact in contacts)


class RobotLinks:
    """Assignment of the robot's bodies in contacts to base, arm, hand or held object."""

    def __init__(self, arm: ArmModel | None) -> None:
        """Sort the links of an arm; None for a robot without an arm."""
        self._arm = set() if arm is None else _moved(arm, 0)
        self._hand = {FINGERS_BODY} if arm is None else {FINGERS_BODY, "hand", *_moved(arm, arm.dof - 1)}

    def part(self, body: str) -> RobotPart:
        """Return the robot's part that a body belongs to; a structure on the base counts as base.

        Args:
            body: name of the body in a contact.
        """
        if body == LOAD_NAME:
            return "held"
        if body in self._hand:
            return "hand"
        return "arm" if body in self._arm else "base"


def _moved(arm: Any, first: int) -> set[str]:
    """Return the names of the links that are moved by a joint with index `first` or higher."""
    here = 0.5 * (arm.lower + arm.upper)
    there = here + np.where(np.arange(arm.dof) >= first, 0.1, 0.0)
    names = [shape.name for shape in arm.link_shapes(here)]
    poses = zip(names, arm.link_poses(here).copy(), arm.link_poses(there), strict=True)
    return {name for name, one, other in poses if not np.allclose(one, other)}
