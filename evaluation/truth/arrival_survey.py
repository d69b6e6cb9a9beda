"""Whether the base is where driving and standing claim, and how far from its places it came to stand."""

from __future__ import annotations

import math
from typing import ClassVar

from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.contract.outcome import Outcome, Success
from handcart.primitives.driving.move_to import ARRIVED, DOCKED
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance

from .at_most import at_most
from .sensor_sigmas import SIGMAS
from .survey import Claim, FiguresSurvey, Survey, SurveyedRun

STOOD_MM, STOOD_DEG = 5.0, 0.3  # that a base creeps which stands
UNFELT_MM = 60.0  # that it may slide beside, which looks at nothing near it
LOOKS_ROUND = (
    "scan",
    "odometry",
    "particle",
    "positioning",
)  # localizers that feel a slide
CAR_ARRIVED = PoseTolerance(position=0.25, heading=0.15)
"""What a car's MOVE_TO means by arrived: nothing is regulated at the end, it can't move sideways."""
CAR_NEEDS = PoseTolerance(position=1.5, heading=math.radians(15.0))
"""Fixed limit of a car's arrival, however uncertain its fixes are: DEPLOY reaches a target from there."""
ORIENTED_DEG = 10.0  # fixed limit of the heading that ORIENT claims to know
DRIVES = "MOVE_TO"


def _moved_to(survey: Survey, claim: Claim) -> list[str]:
    """Compare the arrival with what was measured, and with the fixed limit of the place."""
    robot, place, model = survey.run.robot, claim.primitive.place, survey.run.model
    off, turned = arrival(survey.run, place)
    sigma, heading_sigma = robot.localization.sigma
    if not math.isfinite(sigma):
        return ["it isn't known where the base is"]
    claimed, needed = _claimed(robot, place, model), _needed(robot, place, model)
    far = 1e3 * (claimed.position + SIGMAS * sigma)
    askew = math.degrees(claimed.heading + SIGMAS * heading_sigma)
    return [
        *at_most("the base is {:.1f} mm from its place", off, far, 1e3 * needed.position),
        *at_most("the base is {:.2f} deg off", turned, askew, math.degrees(needed.heading)),
    ]


def _stood(survey: Survey, claim: Claim) -> list[str]:
    """As far as a sensor can tell: a receiver good to a metre feels no slide of centimetres."""
    before, after = claim.before.base, claim.after.base
    most = STOOD_MM + (0.0 if survey.run.spec.localizer in LOOKS_ROUND else UNFELT_MM)
    return [
        *at_most("the base moved by {:.1f} mm", 1e3 * before.distance(after), most),
        *at_most("the base turned by {:.2f} deg", math.degrees(before.turn(after)), STOOD_DEG),
    ]


def _oriented(survey: Survey, claim: Claim) -> list[str]:
    """The heading is what it is claimed to be, within what is claimed of that."""
    robot = survey.run.robot
    if not robot.localization.heading_known:
        return ["it isn't known which way the base heads"]
    off = math.degrees(robot.pose.turn(survey.run.world.base))
    most = STOOD_DEG + math.degrees(SIGMAS * robot.localization.sigma[1])
    return at_most("the base heads {:.2f} deg beside what is believed", off, most, ORIENTED_DEG)


def _modified(survey: Survey, claim: Claim) -> list[str]:
    detour = survey.run.model.detour
    known = detour is not None and detour.goal == claim.primitive.place
    return [] if known else ["no other way is known"]


class ArrivalSurvey(FiguresSurvey):
    """Notes the worst arrival of the run."""

    name = "arrival"
    effects: ClassVar = {DRIVES: _moved_to, "ORIENT": _oriented, "STAND": _stood, "MODIFY": _modified}

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        if primitive.label() == DRIVES and isinstance(outcome, Success):
            off, turned = arrival(self.run, str(getattr(primitive, "place", "")))
            for name, size in (("arrival_mm_max", round(off, 2)), ("arrival_deg_max", round(turned, 3))):
                self._figures[name] = max(size, self._figures.get(name, 0.0))
        return []


def arrival(run: SurveyedRun, place: str) -> tuple[float, float]:
    """How far the base truly is from a place, in [mm] and in [deg]."""
    goal, base = run.model.places[place].pose, run.world.base
    return 1e3 * goal.distance(base), math.degrees(goal.turn(base))


def _claimed(robot: Robot, place: str, model: WorldModel) -> PoseTolerance:
    if robot.spec.drive.kind == "ackermann":
        return CAR_ARRIVED
    return DOCKED if model.places[place].docks else ARRIVED


def _needed(robot: Robot, place: str, model: WorldModel) -> PoseTolerance:
    """Return how far from a place the base may truly be, whatever its localizer claims."""
    if robot.spec.drive.kind == "ackermann":
        return CAR_NEEDS
    need = model.places[place].need
    return PoseTolerance(need.position, need.heading)
