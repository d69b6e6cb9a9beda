"""Fixation: move the hand in a closed loop until a landmark is in the middle of the picture."""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from handcart.backends.robot.localization.pose_covariance import worst_sigmas
from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Fixed
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.motions.arm_motion import move_straight, move_to_pose
from handcart.primitives.motions.from_above import pointing_down
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.evidence import Evidence
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.suspension.fixation import (
    PAPER_RULE,
    PlannedView,
    StopRule,
    on_floor,
    placing_posture,
)
from handcart.robotics.manipulation.suspension.suspension_model import SuspensionModel
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.landmarks.constellation import BasePrior, Kind, PlannedMark

from .building import LandmarkPlan
from .building_site import VIEW_DISTANCE_M
from .landmark_views import LandmarkViews, Sought, offsets

Rule = Literal["residual", "paper"]
STOP_RULES = {"residual": StopRule(), "paper": PAPER_RULE}
MOST_MOVES = 6  # of the hand, until the landmark is at its expected position
HEADING_NOISE = 0.0004  # [rad] of a landmark's direction in one picture
LEAN_SHARE = 0.3  # error of the suspension's model, as a share of the modelled tilt
AGREE, AGREE_TURN = 0.003, 0.003  # [m], [rad] between errors that belong to one pose of the base
CENTRED_TOLERANCE_M = 0.02  # from its place in the picture, within which a landmark counts
SEARCH_RINGS = 2  # of views in a search
MOST_VIEWS = 8  # to distinguish landmarks
MOST_TRIES = 20  # of views that the arm may not reach
BASE_TILT_COVARIANCE = np.diag([0.010, 0.010, 0.010]) ** 2
"""Covariance in [m², rad²] added to the believed pose of the base, which tilts and turns under the arm."""


class Fixation(NamedTuple):
    """Result of a fixation, which measures the base's pose by the hand camera's pictures of a landmark."""

    planned_T_base: Pose2
    """Travelling error dT_M of the base, as its pose relative to the planned one."""
    base_T_hand: Transform
    """Final pose of the hand, base_T_hand (4, 4)."""
    frames: int
    """Pictures that were taken."""
    moves: int
    """Moves of the hand after it reached the planned posture."""
    seen: tuple[Pose2, ...]
    """Travelling error by each picture; after each move the arm has another error."""


def planned_view(
    robot: Robot, mark: LandmarkPlan, planned: Pose2, hand: Transform | None = None
) -> PlannedView:
    """Return the poses of hand and camera that view a landmark when the base is exactly at its target place.

    This is relation A of Hatano et al. (2000).

    Args:
        robot: robot whose hand-eye calibration is used.
        mark: the landmark of the plan.
        planned: map_T_base of the target place.
        hand: (4, 4) base_T_hand of the view; None: the camera straight above the landmark.
    """
    base_T_mark = inverse(planned.lift()) @ mark.pose
    hand_T_camera = robot.camera.hand_T_camera
    if hand is None:
        level = pointing_down(Pose2(0.0, 0.0, 0.0), 0.0)
        hand = level.copy()
        hand[:3, 3] = base_T_mark[:3, 3] + (0.0, 0.0, VIEW_DISTANCE_M) - (level @ hand_T_camera)[:3, 3]
    return PlannedView(hand, hand_T_camera, inverse(hand @ hand_T_camera) @ base_T_mark)


def sought(
    name: str,
    marks: Mapping[str, LandmarkPlan],
    planned: Pose2,
    stands: Pose2,
    covariance: FloatArray,
) -> Sought:
    """Return a landmark to search for, all landmarks that it can be confused with, and the base's estimated
    pose.

    All poses in the result are relative to the base's target place.

    Args:
        name: name of the landmark.
        marks: all landmarks of the plan.
        planned: map_T_base of the target place.
        stands: estimated map_T_base.
        covariance: (3, 3) of `stands`, of x, y in [m] and heading in [rad], on the map.
    """
    among = {
        key: PlannedMark(Kind(mark.height_m, mark.side_mm / 1e3), mark.floor.relative_to(planned))
        for key, mark in marks.items()
    }
    turn = planned.inverse().lift()[:3, :3]
    belief = BasePrior(stands.relative_to(planned), turn @ covariance @ turn.T + BASE_TILT_COVARIANCE)
    return Sought(among[name], tuple(among.values()), belief)


def fixate(
    robot: Robot,
    view: PlannedView,
    sought: Sought,
    rule: Rule,
    evidence: Evidence,
    held: Box | None = None,
    around: Sequence[Box] = (),
    search: bool = True,
    looks: int = 1,
    known: Pose2 | None = None,
) -> Generator[None, None, Fixation]:
    """Move the hand until the landmark is seen as planned, and return the base's pose that follows from it.

    The method is that of Hatano et al. (2000), eq. 1 to 11, corrected. All visible landmarks together
    identify the wanted one. If that is ambiguous, more views are taken.

    Args:
        robot: robot with its arm in any posture.
        view: planned view of the landmark.
        sought: the landmark, all landmarks of the plan, and the estimated pose of the base.
        rule: rule that decides when the hand is near enough to its planned pose; the rule `paper` also
            ignores the remaining error of the hand.
        evidence: evidence of the attempt, to which the last picture is added.
        held: object in the hand, posed in the hand frame.
        around: obstacles for the arm, in the base frame.
        search: search for a landmark that is not in the picture.
        looks: minimum number of views over the landmark; the result is their mean.
        known: known part of the travelling error (the base's pose relative to its target place), with which
            the search starts; None: unknown.

    Raises:
        Discrepancy: the landmark is not found, cannot be distinguished from another one, or the hand does not
            reach its view of it.
    """
    start = view.base_T_hand if known is None else placing_posture(known.lift(), view.base_T_hand)
    yield from move_to_pose(robot, start, held, around)
    stop, views = STOP_RULES[rule], LandmarkViews(robot, view, sought, evidence)
    found: list[Pose2] = []
    away = math.inf
    for moves in range(MOST_MOVES + 2 * looks):
        yield from views.look()
        seen = yield from _identified(robot, view, start, views, held, around, search)
        base_T_hand = robot.base_T("hand")
        there = stop.met(view.camera_T_landmark, seen)
        if rule == "paper" and there:
            by_posture = on_floor(view.travelling_error_by_posture(base_T_hand))
            return Fixation(by_posture, base_T_hand, views.frames, moves, (by_posture,))
        away = float(np.hypot(*(seen[:2, 3] - view.camera_T_landmark[:2, 3])))
        if away < CENTRED_TOLERANCE_M:
            error = on_floor(view.travelling_error(base_T_hand, seen))
            # Where the base was moved meanwhile, earlier observations are void.
            found = [pose2 for pose2 in found if _agree(pose2, error)] + [error]
        if there and len(found) >= looks:
            return Fixation(_mean(found), base_T_hand, views.frames, moves, tuple(found))
        yield from move_straight(robot, _level(view.next_hand(base_T_hand, seen), view), held, around)
    off = Measured("Camera", "landmark off its place in the picture", 1e3 * away, 1e3 * stop.position, "mm")
    raise Discrepancy("the hand doesn't come to rest over the landmark", measured=off, cause=causes.OFF_GOAL)


def fixed_by(robot: Robot, name: str, place: str, planned: Pose2, found: Fixation) -> Fixed:
    """Convert a fixation, which has measured the base's pose at a landmark, to the form that the world model
    keeps.

    Args:
        robot: robot that has made the fixation, still in the same posture.
        name: name of the landmark.
        place: name of the base's target place.
        planned: map_T_base of this place.
        found: the fixation.
    """
    pose = planned.compose(found.planned_T_base)
    reach = (float(found.base_T_hand[0, 3]), float(found.base_T_hand[1, 3]))
    attitude = (*robot.attitude.tilt, robot.attitude.yaw)
    travel = robot.base.wheel_travel()
    noise = robot.spec.arm.accuracy_mm / 1e3 if robot.spec.arm else 0.0
    sigma = worst_sigmas(covariance_of_mean(found.seen, (noise, HEADING_NOISE)))
    return Fixed(name, place, pose, sigma, reach, attitude, travel, robot.attitude.moved)


def covariance_of_mean(seen: Sequence[Pose2], noise: tuple[float, float]) -> FloatArray:
    """Return the covariance (3, 3) of the mean of poses, of x, y on the map in [m] and heading in [rad].

    Args:
        seen: the poses map_T_base, close together.
        noise: sigma of one pose even if all poses agree, of its position in [m] and its heading in [rad].
            The scatter of the poses is added to it.
    """
    position, heading = noise
    scatter = np.cov(np.array(seen), rowvar=False) if len(seen) > 1 else np.zeros((3, 3))
    return np.asarray((scatter + np.diag([position, position, heading]) ** 2) / len(seen))


def upright(fixed: Fixed, known: SuspensionModel, height: float, beside: Transform) -> Pose2:
    """Return the pose map_T_base that was measured at a landmark (a fixation), corrected for the base's tilt.

    Args:
        fixed: fixation with the measured pose.
        known: suspension model, which predicts the tilt during the fixation.
        height: height of the landmark above the floor, in [m]; the effect of the tilt depends on it.
        beside: (4, 4) motion of the base, in the base frame, that the suspension model does not predict. It
            is corrected as well.
    """
    hand = transform((*fixed.reach, height))
    seen = beside @ known.displaced(hand, np.eye(4), 0)
    x, y = (hand - seen)[:2, 3].tolist()
    return fixed.pose.compose(Pose2(x, y, 0.0))


def upright_sigma(fixed: Fixed, pose: Pose2) -> tuple[float, float]:
    """Return the sigma of a measured pose of the base after it was corrected for the base's tilt, for its
    position in [m] and heading in [rad].

    Args:
        fixed: fixation (measurement at a landmark) with the measured pose.
        pose: the corrected pose.
    """
    position, heading = fixed.sigma
    return math.hypot(position, LEAN_SHARE * fixed.pose.distance(pose)), heading


def _agree(one: Pose2, other: Pose2) -> bool:
    return one.distance(other) < AGREE and one.turn(other) < AGREE_TURN


def _mean(poses: Sequence[Pose2]) -> Pose2:
    """Return the mean of poses close together."""
    x, y, turn = np.mean(np.array(poses), axis=0).tolist()
    return Pose2(x, y, turn)


def _level(base_T_hand: Transform, view: PlannedView) -> Transform:
    """Return the hand's pose (4, 4), moved to the planned height and tilted as planned; x, y and heading
    stay.
    """
    turn = base_T_hand[:3, :3] @ view.base_T_hand[:3, :3].T
    yaw = math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])
    result = transform(rpy=(0.0, 0.0, yaw)) @ view.base_T_hand
    result[:3, 3] = (*base_T_hand[:2, 3], view.base_T_hand[2, 3])
    return np.asarray(result)


def _identified(
    robot: Robot,
    view: PlannedView,
    start: Transform,
    views: LandmarkViews,
    held: Box | None,
    around: Sequence[Box],
    search: bool,
) -> Generator[None, None, Transform]:
    """Move the hand until the landmark is identified; return camera_T_landmark (4, 4) by the last picture.

    Args:
        robot: the robot.
        view: planned view of the landmark.
        start: (4, 4) base_T_hand of the first view.
        views: pictures so far.
        held: object in the hand, posed in the hand frame.
        around: bodies to keep clear of, in the base frame.
        search: True to search for a landmark that is not in the picture.
    """
    if views.explanation is None and search:
        yield from _search(robot, start, views, held, around)
    if views.explanation is None:
        nothing = Measured("Camera", f"landmarks found in {views.frames} pictures", 0, 1)
        raise Discrepancy("the landmark is not found", measured=nothing, cause=causes.NOT_SEEN)
    yield from _make_sure(robot, start, views, held, around)
    if views.wanted() is None and not views.hides():
        there = placing_posture(views.explanation.planned_T_base.lift(), view.base_T_hand)
        yield from move_to_pose(robot, there, held, around)
        yield from views.look()
        yield from _make_sure(robot, start, views, held, around)
    seen = views.wanted()
    if seen is None:
        nothing = Measured("Camera", "landmarks where one should be by those around it", 0, 1)
        raise Discrepancy(
            "the landmark is not found where it should be by those around it",
            measured=nothing,
            cause=causes.NOT_SEEN,
        )
    return seen


def _make_sure(
    robot: Robot, start: Transform, views: LandmarkViews, held: Box | None, around: Sequence[Box]
) -> Periods:
    """Take views from elsewhere until one explanation of the seen marks is left."""
    for _ in range(MOST_VIEWS):
        if len(views.explanations) < 2:
            return
        for hand in views.telling_hands(start)[:MOST_TRIES]:
            if (yield from _reached(robot, hand, held, around)):
                break
        else:
            break
        yield from views.look()
    if (left := len(views.explanations)) > 1:
        several = Measured("Camera", "places of the base from which it looks like that", left, 1)
        raise Discrepancy("the landmarks can't be distinguished", measured=several, cause=causes.AMBIGUOUS)


def _search(
    robot: Robot, start: Transform, views: LandmarkViews, held: Box | None, around: Sequence[Box]
) -> Periods:
    """Look around in rings about the first view `start`, base_T_hand (4, 4); skip views out of the arm's
    reach.
    """
    for x, y in offsets(SEARCH_RINGS):
        hand = start.copy()
        hand[:2, 3] += (x, y)
        if (yield from _reached(robot, hand, held, around)):
            yield from views.look()
            if views.explanation is not None:
                return


def _reached(
    robot: Robot, base_T_hand: Transform, held: Box | None, around: Sequence[Box]
) -> Generator[None, None, bool]:
    """Return whether the hand could be moved to base_T_hand (4, 4)."""
    try:
        yield from move_to_pose(robot, base_T_hand, held, around)
    except Discrepancy as no_way:
        if no_way.cause not in (causes.OUT_OF_REACH, causes.NO_ARM_PATH):
            raise
        return False
    return True
