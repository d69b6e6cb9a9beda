"""Check by ground truth that the base is where driving and standing primitives claim it is."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.robot.localization.determination import PoseNeed, difference, sigmas_along
from handcart.backends.robot.localization.pose_covariance import worst_sigmas
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.driving.docking import DOCK_TOLERANCE
from handcart.primitives.driving.move_to import ARRIVAL_TOLERANCE
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes.outcome import Outcome, Success
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance

from .at_most import at_most
from .sensor_sigmas import LIMIT_SIGMAS
from .survey import Claim, FiguresSurvey, Survey, SurveyedRun

STOOD_MM, STOOD_DEG = 5.0, 0.3  # allowed creep of a base at rest
UNFELT_MM = 60.0  # further allowed slide with a localizer that does not see the surroundings
LOOKS_ROUND = (
    "scan",
    "odometry",
    "particle",
    "positioning",
)  # localizers that detect a slide of the base
ORIENTED_DEG = 10.0  # fixed limit of the heading that ORIENT claims to know
LOCATED_MM, LOCATED_DEG = 150.0, 5.0  # fixed limits of the pose that LOCATE claims to know
DRIVE_PRIMITIVE = "MOVE_TO"


def _moved_to(survey: Survey, claim: Claim) -> list[str]:
    """Compare the true arrival with the claimed tolerance, the claimed uncertainty and the place's fixed
    limit.
    """
    robot, place, model = survey.run.robot, claim.primitive.place, survey.run.model
    _, turned = arrival(survey.run, place)
    sigma, heading_sigma = robot.localization.sigma
    if not math.isfinite(sigma):
        return ["it isn't known where the base is"]
    claimed, needed = _claimed(robot, place, model), model.places[place].need_of(robot.spec.drive.kind)
    askew = math.degrees(claimed.heading + LIMIT_SIGMAS * heading_sigma)
    return [
        *_far(survey.run, place, claimed.position, needed),
        *at_most("the base is {:.2f} deg off", turned, askew, math.degrees(needed.heading)),
    ]


def _far(run: SurveyedRun, place: str, claimed: float, needed: PoseNeed) -> list[str]:
    """Describe the directions in which the base is farther from its place than its claim or the place
    allows.
    """
    off, _ = arrival(run, place)
    if needed.across is None:
        far = 1e3 * (claimed + LIMIT_SIGMAS * run.robot.localization.sigma[0])
        return at_most("the base is {:.1f} mm from its place", off, far, 1e3 * needed.position)
    axes, limits = needed.axes(run.robot.localization.covariance)
    away = np.abs(np.array(difference(run.base_on_map, run.model.places[place].pose)[:2]) @ axes)
    sigmas = sigmas_along(run.robot.localization.covariance, axes)
    named = zip(("along", "across"), away.tolist(), sigmas.tolist(), limits.tolist(), strict=True)
    return [
        wrong
        for name, size, sigma, limit in named
        for wrong in at_most(
            f"the base is {{:.1f}} mm from its place, {name} its heading",
            1e3 * size,
            1e3 * (claimed + LIMIT_SIGMAS * sigma),
            1e3 * limit,
        )
    ]


def _stood(survey: Survey, claim: Claim) -> list[str]:
    """Return messages about motion of a base at rest; the limit is larger for sensors that cannot feel a
    slide.
    """
    before, after = claim.before.base, claim.after.base
    most = STOOD_MM + (0.0 if survey.run.spec.localizer in LOOKS_ROUND else UNFELT_MM)
    return [
        *at_most("the base moved by {:.1f} mm", 1e3 * before.distance(after), most),
        *at_most("the base turned by {:.2f} deg", math.degrees(before.turn(after)), STOOD_DEG),
    ]


def _oriented(survey: Survey, claim: Claim) -> list[str]:
    """Compare the true heading with the claimed heading, its uncertainty and a fixed limit."""
    robot = survey.run.robot
    if not robot.localization.heading_known:
        return ["it isn't known which way the base heads"]
    off = math.degrees(robot.pose.turn(survey.run.base_on_map))
    most = STOOD_DEG + math.degrees(LIMIT_SIGMAS * robot.localization.sigma[1])
    return at_most("the base heads {:.2f} deg beside what is believed", off, most, ORIENTED_DEG)


def _located(survey: Survey, claim: Claim) -> list[str]:
    """Compare the true pose with the one found, its uncertainty and a fixed limit."""
    robot, base = survey.run.robot, survey.run.base_on_map
    if not robot.localization.is_located or robot.localization.lost is not None:
        return ["it isn't known where the base is"]
    sigma, heading_sigma = worst_sigmas(robot.localization.covariance)
    off, turned = 1e3 * robot.pose.distance(base), math.degrees(robot.pose.turn(base))
    far, askew = 1e3 * LIMIT_SIGMAS * sigma, math.degrees(LIMIT_SIGMAS * heading_sigma)
    return [
        *at_most("the base is {:.1f} mm from where LOCATE found it", off, far, LOCATED_MM),
        *at_most("the base heads {:.2f} deg from what LOCATE found", turned, askew, LOCATED_DEG),
    ]


def _modified(survey: Survey, claim: Claim) -> list[str]:
    detour = survey.run.model.detour
    known = detour is not None and detour.goal == claim.primitive.place
    return [] if known else ["no other way is known"]


class ArrivalSurvey(FiguresSurvey):
    """Evaluation of how exactly the base arrives at places, with the largest true errors of a run."""

    name = "arrival"
    effects: ClassVar = {
        DRIVE_PRIMITIVE: _moved_to,
        "LOCATE": _located,
        "ORIENT": _oriented,
        "STAND": _stood,
        "MODIFY": _modified,
    }

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        if primitive.label() == DRIVE_PRIMITIVE and isinstance(outcome, Success):
            off, turned = arrival(self.run, str(getattr(primitive, "place", "")))
            for name, size in (("arrival_mm_max", round(off, 2)), ("arrival_deg_max", round(turned, 3))):
                self._figures[name] = max(size, self._figures.get(name, 0.0))
        return []


def arrival(run: SurveyedRun, place: str) -> tuple[float, float]:
    """Return the true error of the base at a place: distance in [mm], and turn in [deg].

    Args:
        run: run with the simulated world.
        place: name of the place.
    """
    goal, base = run.model.places[place].pose, run.base_on_map
    return 1e3 * goal.distance(base), math.degrees(goal.turn(base))


def _claimed(robot: Robot, place: str, model: WorldModel) -> PoseTolerance:
    """Return the distance and turn from the place that the robot claims.

    A car cannot move sideways, so its final pose is not regulated: it claims its own estimate.
    """
    goal = model.places[place].pose
    if robot.spec.drive.kind == "ackermann":
        return PoseTolerance(robot.pose.distance(goal), abs(robot.pose.turn(goal)))
    return DOCK_TOLERANCE if model.places[place].docks else ARRIVAL_TOLERANCE
