"""Fixation: turning the hand until a landmark stands in the middle of the picture, closed loop."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from backends.robot import Robot
from robotics.geometry.pose2 import Pose2
from robotics.geometry.transform import Transform, inverse, transform
from robotics.kinematics.shapes import Box
from robotics.manipulation.fixation import PAPER_RULE, PlannedView, StopRule, on_floor, placing_posture
from robotics.perception.landmark import Landmark
from robotics.perception.landmark_finder import find_landmarks
from robotics.perception.landmark_pose import planar_pose
from robotics.perception.overlay import draw_overlay

from .arm_motion import move_straight, move_to_pose
from .building import LandmarkPlan
from .discrepancy import Discrepancy, Measured
from .evidence import Evidence
from .hand_down import VIEW, pointing_down
from .snapshot import settle
from .world_model import Fixed

Rule = Literal["residual", "paper"]
RULES = {"residual": StopRule(), "paper": PAPER_RULE}
MOST_MOVES = 6  # of the hand, until the landmark stands where it should
NEARER, FARTHER = 0.05, 0.05  # [m] by which the landmark may be off its height in a picture
HEADING_SIGMA = 0.0004  # [rad] of a landmark's direction in a picture
AGREE, AGREE_TURN = 0.003, 0.003  # [m], [rad] between errors that tell of one place of the base
CENTRAL = 0.02  # [m] from its place in the picture, within which a landmark counts
STEP = 0.09  # [m] between the views of a search: the picture shows 0.24 x 0.18 m
RINGS = 2

GreyImage = NDArray[np.uint8]


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
    looks: int
    """Pictures that the error was taken from: after each move the arm errs anew."""


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


def fixate(
    robot: Robot,
    view: PlannedView,
    side: float,
    rule: Rule,
    evidence: Evidence,
    held: Box | None = None,
    around: Sequence[Box] = (),
    search: bool = True,
    looks: int = 1,
    known: Pose2 | None = None,
) -> Generator[None, None, Fixation]:
    """Move the hand until the landmark is seen as planned (Hatano et al. 2000, eq. 1 to 11, corrected).

    Args:
        robot: its arm may be anywhere.
        view: how the landmark is to be seen.
        side: of the landmark, in [m].
        rule: when to stop; `paper` also forgets what is left then.
        evidence: takes the deciding picture.
        held: in the hand, posed in its frame.
        around: bodies to keep clear of, in the base frame.
        search: whether a landmark that isn't in the picture is searched for.
        looks: how often the hand is to come to stand over it at least; what is found is their mean.
        known: the travelling error as far as it is known: from there the landmark is looked for.

    Raises:
        Discrepancy: it isn't found, or the hand doesn't come to stand over it.
    """
    start = view.base_T_hand if known is None else placing_posture(known.lift(), view.base_T_hand)
    yield from move_to_pose(robot, start, held, around)
    stop, frames = RULES[rule], 0
    found: list[Pose2] = []
    away = math.inf
    for moves in range(MOST_MOVES + 2 * looks):
        seen = yield from _look(robot, view, side, evidence)
        frames += 1
        if seen is None and search:
            seen, pictures = yield from _search(robot, view, start, side, evidence, held, around)
            frames += pictures
        if seen is None:
            nothing = Measured("Camera", f"landmarks found in {frames} pictures", 0, 1)
            raise Discrepancy("the landmark is not found", measured=nothing)
        base_T_hand = robot.base_T("hand")
        there = stop.met(view.camera_T_landmark, seen)
        if rule == "paper" and there:
            return Fixation(
                on_floor(view.travelling_error_by_posture(base_T_hand)), base_T_hand, frames, moves, 1
            )
        away = float(np.hypot(*(seen[:2, 3] - view.camera_T_landmark[:2, 3])))
        if away < CENTRAL:
            error = on_floor(view.travelling_error(base_T_hand, seen))
            # Where the base was moved meanwhile, what was seen before is over.
            found = [each for each in found if _agree(each, error)] + [error]
        if there and len(found) >= looks:
            return Fixation(_mean(found), base_T_hand, frames, moves, len(found))
        yield from move_straight(robot, _level(view.next_hand(base_T_hand, seen), view), held, around)
    off = Measured("Camera", "landmark off its place in the picture", 1e3 * away, 1e3 * stop.position, "mm")
    raise Discrepancy("the hand doesn't come to stand over the landmark", measured=off)


def fixed_by(robot: Robot, name: str, place: str, planned: Pose2, found: Fixation) -> Fixed:
    """Where the base stands, for the world model; `planned` is map_T_base of the place."""
    pose = planned.compose(found.planned_T_base)
    reach = (float(found.base_T_hand[0, 3]), float(found.base_T_hand[1, 3]))
    attitude = (*robot.attitude.tilt, robot.attitude.yaw)
    left, right = robot.base.wheel_travel()
    sigma = robot.spec.arm.accuracy_mm / 1e3 / math.sqrt(found.looks) if robot.spec.arm else 0.0
    return Fixed(
        name, place, pose, (sigma, HEADING_SIGMA), reach, attitude, (left, right), robot.attitude.moved
    )


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


def _look(
    robot: Robot, view: PlannedView, side: float, evidence: Evidence
) -> Generator[None, None, Transform | None]:
    """camera_T_landmark (4, 4) as one picture shows it, the camera taken to be tilted as planned.

    Of several landmarks it is the one nearest to where the wanted one is to be seen.
    """
    yield from settle(robot)
    yield
    image = robot.picture()
    height = float(view.camera_T_landmark[2, 3])
    found = find_landmarks(image, robot.camera.model, side, (height - NEARER, height + FARTHER))
    _show(image, found, evidence)
    if not found:
        return None
    plane = view.camera_T_landmark
    poses = [np.asarray(plane @ planar_pose(each, plane).lift()) for each in found]
    return min(poses, key=lambda pose: float(np.hypot(*(pose[:2, 3] - plane[:2, 3]))))


def _show(image: GreyImage, found: Sequence[Landmark], evidence: Evidence) -> None:
    evidence.pictures["landmark"] = draw_overlay(image, landmarks=found)


def _search(
    robot: Robot,
    view: PlannedView,
    start: Transform,
    side: float,
    evidence: Evidence,
    held: Box | None,
    around: Sequence[Box],
) -> Generator[None, None, tuple[Transform | None, int]]:
    """Look around in rings about the first view; what the arm can't reach is left out."""
    looks = 0
    for x, y in _rings():
        hand = start.copy()
        hand[:2, 3] += (x, y)
        try:
            yield from move_to_pose(robot, hand, held, around)
        except Discrepancy:
            continue
        seen = yield from _look(robot, view, side, evidence)
        looks += 1
        if seen is not None:
            return seen, looks
    return None, looks


def _rings() -> list[tuple[float, float]]:
    """x and y of the views in [m], the nearest first."""
    steps = [STEP * n for n in range(-RINGS, RINGS + 1)]
    views = [(x, y) for x in steps for y in steps if (x, y) != (0.0, 0.0)]
    return sorted(views, key=lambda each: (math.hypot(*each), math.atan2(each[1], each[0])))
