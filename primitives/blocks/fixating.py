"""Fixation: turning the hand until a landmark stands in the middle of the picture, closed loop."""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.robot.localization.localization import worst_sigmas
from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Fixed
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.contract.discrepancy import Discrepancy, Measured
from handcart.primitives.contract.evidence import Evidence
from handcart.primitives.motions.arm_motion import move_straight, move_to_pose
from handcart.primitives.motions.from_above import pointing_down
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
from handcart.robotics.perception.landmarks.constellation import Belief, Kind, Mark

from .building import LandmarkPlan
from .building_site import VIEW
from .landmark_views import LandmarkViews, Sought, offsets

Rule = Literal["residual", "paper"]
RULES = {"residual": StopRule(), "paper": PAPER_RULE}
MOST_MOVES = 6  # of the hand, until the landmark stands where it should
HEADING_NOISE = 0.0004  # [rad] of a landmark's direction in one picture
LEAN_SHARE = 0.3  # of what the base leans by its model: what may be wrong with that
AGREE, AGREE_TURN = 0.003, 0.003  # [m], [rad] between errors that tell of one place of the base
CENTRAL = 0.02  # [m] from its place in the picture, within which a landmark counts
RINGS = 2  # of views in a search
MOST_VIEWS = 8  # to tell landmarks apart
MOST_TRIES = 20  # of views that the arm may not reach
SPREAD = np.diag([0.010, 0.010, 0.010]) ** 2
"""[m², rad²] of where the base stands, besides what is known of that: it leans and turns under the arm."""


class Fixation(NamedTuple):
    """What a fixation gives."""

    planned_T_base: Pose2
    """dT_M, the travelling error."""
    base_T_hand: Transform
    """Where the hand is."""
    frames: int
    """Pictures that were taken."""
    moves: int
    """Of the hand after it came to the planned posture."""
    seen: tuple[Pose2, ...]
    """The error by each picture that it was taken from: after each move the arm errs anew."""


def planned_view(
    robot: Robot, mark: LandmarkPlan, planned: Pose2, hand: Transform | None = None
) -> PlannedView:
    """How a landmark is to be seen from a base that stands where it should (relation A).

    Args:
        robot: its hand-eye calibration counts.
        mark: the landmark.
        planned: map_T_base.
        hand: base_T_hand (4, 4) from where it is looked at; left out: with the camera straight above it.
    """
    base_T_mark = inverse(planned.lift()) @ mark.pose
    hand_T_camera = robot.camera.hand_T_camera
    if hand is None:
        level = pointing_down(Pose2(0.0, 0.0, 0.0), 0.0)
        hand = level.copy()
        hand[:3, 3] = base_T_mark[:3, 3] + (0.0, 0.0, VIEW) - (level @ hand_T_camera)[:3, 3]
    return PlannedView(hand, hand_T_camera, inverse(hand @ hand_T_camera) @ base_T_mark)


def sought(
    name: str,
    marks: Mapping[str, LandmarkPlan],
    planned: Pose2,
    stands: Pose2,
    covariance: NDArray[np.float64],
) -> Sought:
    """A landmark of the plan, for a base that should stand at `planned` and is believed to be at `stands`.

    Args:
        name: of the landmark.
        marks: all of the plan.
        planned: map_T_base.
        stands: map_T_base.
        covariance: (3, 3) of `stands`, of x, y in [m] and heading in [rad], on the map.
    """
    among = {
        each: Mark(Kind(mark.height_m, mark.side_mm / 1e3), mark.floor.relative_to(planned))
        for each, mark in marks.items()
    }
    turn = planned.inverse().lift()[:3, :3]
    belief = Belief(stands.relative_to(planned), turn @ covariance @ turn.T + SPREAD)
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
    """Move the hand until the landmark is seen as planned (Hatano et al. 2000, eq. 1 to 11, corrected).

    Which of several landmarks it is, all that is seen tells together. Where that leaves two answers, more
    is looked at.

    Args:
        robot: its arm may be anywhere.
        view: how the landmark is to be seen.
        sought: which landmark, among which, from a base that stands about where.
        rule: when to stop; `paper` also forgets what is left then.
        evidence: takes the deciding picture.
        held: in the hand, posed in its frame.
        around: bodies to keep clear of, in the base frame.
        search: whether a landmark that isn't in the picture is searched for.
        looks: how often the hand is to come to stand over it at least; what is found is their mean.
        known: the travelling error as far as it is known: from there the landmark is looked for.

    Raises:
        Discrepancy: it isn't found, it can't be told from another one, or the hand doesn't come to stand
            over it.
    """
    start = view.base_T_hand if known is None else placing_posture(known.lift(), view.base_T_hand)
    yield from move_to_pose(robot, start, held, around)
    stop, views = RULES[rule], LandmarkViews(robot, view, sought, evidence)
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
        if away < CENTRAL:
            error = on_floor(view.travelling_error(base_T_hand, seen))
            # Where the base was moved meanwhile, what was seen before is over.
            found = [each for each in found if _agree(each, error)] + [error]
        if there and len(found) >= looks:
            return Fixation(_mean(found), base_T_hand, views.frames, moves, tuple(found))
        yield from move_straight(robot, _level(view.next_hand(base_T_hand, seen), view), held, around)
    off = Measured("Camera", "landmark off its place in the picture", 1e3 * away, 1e3 * stop.position, "mm")
    raise Discrepancy("the hand doesn't come to stand over the landmark", measured=off)


def fixed_by(robot: Robot, name: str, place: str, planned: Pose2, found: Fixation) -> Fixed:
    """Where the base stands, for the world model; `planned` is map_T_base of the place."""
    pose = planned.compose(found.planned_T_base)
    reach = (float(found.base_T_hand[0, 3]), float(found.base_T_hand[1, 3]))
    attitude = (*robot.attitude.tilt, robot.attitude.yaw)
    left, right = robot.base.wheel_travel()
    noise = robot.spec.arm.accuracy_mm / 1e3 if robot.spec.arm else 0.0
    sigma = worst_sigmas(covariance_of_mean(found.seen, (noise, HEADING_NOISE)))
    return Fixed(name, place, pose, sigma, reach, attitude, (left, right), robot.attitude.moved)


def covariance_of_mean(seen: Sequence[Pose2], noise: tuple[float, float]) -> NDArray[np.float64]:
    """Return the covariance (3, 3) of the mean of poses, of x, y in [m] and heading in [rad].

    Args:
        seen: the poses, close together.
        noise: sigma of one of them at least, of its position in [m] and its heading in [rad]. How far they
            lie apart is added: few poses may agree by chance.
    """
    position, heading = noise
    scatter = np.cov(np.array(seen), rowvar=False) if len(seen) > 1 else np.zeros((3, 3))
    return np.asarray((scatter + np.diag([position, position, heading]) ** 2) / len(seen))


def upright(fixed: Fixed, known: SuspensionModel, height: float, beside: Transform) -> Pose2:
    """Return map_T_base as it would stand if it did not lean.

    It leaned as its model says, and by `beside` (4, 4) more: a landmark at that height in [m] is seen
    displaced.
    """
    hand = transform((*fixed.reach, height))
    seen = beside @ known.displaced(hand, np.eye(4), 0)
    x, y = (hand - seen)[:2, 3].tolist()
    return fixed.pose.compose(Pose2(x, y, 0.0))


def upright_sigma(fixed: Fixed, pose: Pose2) -> tuple[float, float]:
    """Return the sigma of the pose that `upright` gave, of its position in [m] and its heading in [rad]."""
    position, heading = fixed.sigma
    return math.hypot(position, LEAN_SHARE * fixed.pose.distance(pose)), heading


def _agree(one: Pose2, other: Pose2) -> bool:
    return one.distance(other) < AGREE and one.turn(other) < AGREE_TURN


def _mean(poses: Sequence[Pose2]) -> Pose2:
    """Of poses close together."""
    x, y, turn = np.mean(np.array(poses), axis=0).tolist()
    return Pose2(x, y, turn)


def _level(base_T_hand: Transform, view: PlannedView) -> Transform:
    """The same at the planned height, pointing as planned but for the turn about the vertical."""
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
    """camera_T_landmark (4, 4) by the last picture, once it is sure which landmark that is."""
    if views.explanation is None and search:
        yield from _search(robot, start, views, held, around)
    if views.explanation is None:
        nothing = Measured("Camera", f"landmarks found in {views.frames} pictures", 0, 1)
        raise Discrepancy("the landmark is not found", measured=nothing)
    yield from _make_sure(robot, start, views, held, around)
    if views.wanted() is None and not views.hides():
        there = placing_posture(views.explanation.planned_T_base.lift(), view.base_T_hand)
        yield from move_to_pose(robot, there, held, around)
        yield from views.look()
        yield from _make_sure(robot, start, views, held, around)
    seen = views.wanted()
    if seen is None:
        nothing = Measured("Camera", "landmarks where one should be by those around it", 0, 1)
        raise Discrepancy("the landmark is not found where it should be by those around it", measured=nothing)
    return seen


def _make_sure(
    robot: Robot, start: Transform, views: LandmarkViews, held: Box | None, around: Sequence[Box]
) -> Periods:
    """Look from elsewhere until one explanation is left of what is seen."""
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
        raise Discrepancy("which landmark is which can't be told", measured=several)


def _search(
    robot: Robot, start: Transform, views: LandmarkViews, held: Box | None, around: Sequence[Box]
) -> Periods:
    """Look around in rings about the first view; what the arm can't reach is left out."""
    for x, y in offsets(RINGS):
        hand = start.copy()
        hand[:2, 3] += (x, y)
        if (yield from _reached(robot, hand, held, around)):
            yield from views.look()
            if views.explanation is not None:
                return


def _reached(
    robot: Robot, base_T_hand: Transform, held: Box | None, around: Sequence[Box]
) -> Generator[None, None, bool]:
    """Whether the hand could be moved to a pose (4, 4)."""
    try:
        yield from move_to_pose(robot, base_T_hand, held, around)
    except Discrepancy:
        return False
    return True
