"""Poses in which a robot can hold books, and parts that it lacks to return them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.evaluation.robot_report.domain_facts import DomainFacts, FactTable
from handcart.evaluation.robot_report.reach import HandReach
from handcart.primitives.books.book_grip import GRIP_HEIGHT
from handcart.robotics.numerics.arrays import FloatArray

BEFORE_SHELF = 0.46  # [m] ahead of the base that the tips are for `aside`: shelves of return_book are at 0.47
BOARD_HEIGHTS_M = (0.1, 0.3, 0.5, 0.7, 0.9, 1.1, 1.3, 1.5)  # heights of boards that are tried [m]
AHEAD_M = np.arange(-0.4, 1.41, 0.05)  # [m]
ASIDE_M = np.arange(-1.0, 1.01, 0.1)  # [m]
TRIED_POSTURES = ("home", "look_at_tag", "carry")

Span = tuple[float, float] | None


@dataclass(frozen=True)
class GraspRow:
    """Positions at which a hand, upright and pointing ahead, can hold a book on a board of one height."""

    board_m: float
    """Height of the surface under the book."""
    ahead_m: Span
    """Range of x of the finger tips in the base frame, with their y at `line_m`."""
    line_m: float
    """y of the finger tips in the base frame for the range `ahead_m`."""
    aside_m: Span
    """Range of y of the finger tips in the base frame, with their x at `BEFORE_SHELF`."""


def book_facts(robot: RobotFile, reach: HandReach | None) -> DomainFacts:
    """Return where a robot's hand can hold books on boards, and what the robot lacks to return books.

    Args:
        robot: the robot.
        reach: reach of its hand. If it is None, or the robot has no tray, only what the robot lacks is
            returned.
    """
    remarks = _lacking(robot)
    if reach is None or not robot.has_tray:
        return DomainFacts(remarks)
    grasps = _grasps(robot, reach)
    rows = [
        (f"{row.board_m:.2f} m", f"{_words(row.ahead_m)}, y = {row.line_m:.2f}", _words(row.aside_m))
        for row in grasps
    ]
    heading = "upright, pointing ahead and holding a book on a board, its finger tips get to"
    columns = ("board at", "x, straight ahead", f"y, {BEFORE_SHELF} m ahead")
    figures = {"grasps": [asdict(grasp) for grasp in grasps]}
    return DomainFacts(remarks, figures, (FactTable(heading, columns, rows),))


def _lacking(robot: RobotFile) -> list[str]:
    """Return the missing parts of a robot with a tray, or of one that looks for tags on a tray."""
    if robot.arm is None:
        return []
    if not robot.has_tray:
        looks = "look_at_tag" in robot.arm.postures
        return ["no link 'tray': RECOGNIZE and PICK_UP take a book from one"] if looks else []
    missing = [name for name in TRIED_POSTURES if name not in robot.arm.postures]
    return [f"no posture {name!r}: return_book needs it" for name in missing]


def _words(span: Span) -> str:
    return "nowhere" if span is None else f"{span[0]:.2f} to {span[1]:.2f} m"


def _grasps(robot: RobotFile, reach: HandReach) -> list[GraspRow]:
    tip = robot.finger_shape.tip if robot.gripper is not None else 0.0
    rows = [_row(reach, board, tip, 0.0) for board in BOARD_HEIGHTS_M]
    tray = robot.tray_shape
    rows.append(_row(reach, tray.top, tip, tray.middle[1]))
    return sorted(rows, key=lambda row: (row.board_m, row.line_m))


def _row(reach: HandReach, board: float, tip: float, line: float) -> GraspRow:
    z = board + GRIP_HEIGHT
    ahead = [(x - tip, line, z) for x in AHEAD_M]
    aside = [(BEFORE_SHELF - tip, y, z) for y in ASIDE_M]
    reached = reach.reached(ahead)
    beside = reach.reached(aside)
    return GraspRow(board, _longest(AHEAD_M, reached), line, _longest(ASIDE_M, beside))


def _longest(values: FloatArray, good: Sequence[bool]) -> Span:
    """Return the least and largest of the longest run of consecutive values (n,) that are good; None without
    any.
    """
    best: Span = None
    start: int | None = None
    for index, item in enumerate([*good, False]):
        if item and start is None:
            start = index
        elif not item and start is not None:
            span = (float(values[start]), float(values[index - 1]))
            if best is None or span[1] - span[0] > best[1] - best[0]:
                best = span
            start = None
    return None if best is None else (round(best[0], 2) + 0.0, round(best[1], 2) + 0.0)  # no -0.0
