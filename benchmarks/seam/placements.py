"""Measure base placements for a path longer than the arm's reach: `python -m benchmarks.seam.placements`.

Seeded. Times are minima of several warm calls in one process; compared functions alternate. The plain
loops are the same closed form in Python; they run on a part of the placements (drawn by the seed) and
their time is scaled. `--quick` uses a smaller part.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from benchmarks.seam.directional_manipulability import (
    top_speed,
    top_speed_by_program,
)
from benchmarks.seam.greedy_division import greedy_division
from benchmarks.seam.placement_bound import score_bound
from benchmarks.seam.planar_arm import PlanarArm
from handcart.robotics.manipulation.arms.pitch_arm import PitchArm
from handcart.robotics.manipulation.arms.score_rule import Measure, ScoreRule
from handcart.robotics.manipulation.paths.tool_path import ToolPath, tool_path
from handcart.robotics.manipulation.placement.placement_division import (
    Division,
    best_division,
    best_division_by_cost,
)
from handcart.robotics.manipulation.placement.placement_refinement import refine
from handcart.robotics.numerics.arrays import FloatArray

POINTS, PLACEMENTS = 400, (50, 20, 20)
LOW, HIGH = 0.20, 1.0  # [m] b_min and b_max of the pitch arm


class Row(NamedTuple):
    """A line of the table."""

    what: str
    ours: str
    wanted: str = ""


def least(call: Callable[[], Any], times: int = 7) -> float:
    """Least wall time of warm calls, in [s]."""
    call()
    taken = []
    for _ in range(times):
        begin = time.perf_counter()
        call()
        taken.append(time.perf_counter() - begin)
    return min(taken)


def arched_seam(span: float, rise: float, points: int = POINTS) -> ToolPath:
    """Return an arch over y = 0, from 0.7 m up; the tool points along y and 35 degrees down."""
    t = np.linspace(-0.5, 0.5, points)
    poses = np.tile(np.eye(4), (points, 1, 1))
    poses[:, 0, 3], poses[:, 2, 3] = t * span, 0.7 + rise * (1.0 - (2.0 * t) ** 2)
    axis = np.array([0.0, math.cos(math.radians(35.0)), -math.sin(math.radians(35.0))])
    poses[:, :3, 0], poses[:, :3, 1] = axis, (-1.0, 0.0, 0.0)
    poses[:, :3, 2] = np.cross(axis, (-1.0, 0.0, 0.0))
    return tool_path(poses)


def straight_seam(length: float = 4.4, points: int = 401) -> ToolPath:
    """Along x at y = 0."""
    poses = np.tile(np.eye(4), (points, 1, 1))
    poses[:, 0, 3] = np.linspace(0.0, length, points)
    return tool_path(poses)


def grid(x: FloatArray, y: FloatArray, headings: FloatArray) -> FloatArray:
    """Return base poses (b, 3)."""
    return np.stack(np.meshgrid(x, y, headings, indexing="ij"), axis=-1).reshape(-1, 3)


def plain_scores(arm: PitchArm, bases: FloatArray, path: ToolPath) -> list[list[float]]:
    """Return the sure score in plain loops over Python's own numbers, out of reach left early."""
    l1, l2, l3 = arm.links
    marks = arm.marks(path).tolist()
    cos_yaw, cos_azimuth = math.cos(arm.yaw_limit), math.cos(arm.azimuth_tolerance)
    half, rows = 0.5 * (HIGH - LOW), []
    for base_x, base_y, heading in bases.tolist():
        ahead_x, ahead_y = math.cos(heading), math.sin(heading)
        shoulder_x, shoulder_y = base_x + arm.ahead * ahead_x, base_y + arm.ahead * ahead_y
        row = []
        for px, py, pz, kx, ky, kz, level_x, level_y, cos, sin, rate in marks:
            x, y, z = px - shoulder_x, py - shoulder_y, pz - arm.height
            distance = math.sqrt(x * x + y * y)
            wrist_r, wrist_z = distance - l3 * cos, z - l3 * sin
            far = math.sqrt(wrist_r * wrist_r + wrist_z * wrist_z)
            if far > l1 + l2 or far < abs(l1 - l2) or distance == 0.0 or far == 0.0:
                row.append(0.0)
                continue
            if ahead_x * x + ahead_y * y < cos_yaw * distance:
                row.append(0.0)
                continue
            if level_x * x + level_y * y < cos_azimuth * distance:
                row.append(0.0)
                continue
            turn = math.acos(max(-1.0, min(1.0, (far * far + l1 * l1 - l2 * l2) / (2.0 * l1 * far))))
            upper_angle = math.atan2(wrist_z, wrist_r) + turn
            ux, uz = math.cos(upper_angle), math.sin(upper_angle)
            vx, vz = (wrist_r - l1 * ux) / l2, (wrist_z - l1 * uz) / l2
            bend = ux * vz - uz * vx
            across, away = (ky * x - kx * y) / distance, (kx * x + ky * y) / distance
            largest = max(
                abs(across) * distance,
                abs(kz * distance - away * z),
                abs(kz * (distance - l1 * ux) - away * (z - l1 * uz)),
                l3 * abs(kz * cos - away * sin),
            )
            if bend == 0.0:
                row.append(0.0)
                continue
            wrist_away, wrist_up = away + rate * l3 * sin, kz - rate * l3 * cos
            upper = (wrist_away * vx + wrist_up * vz) / (l1 * bend)
            fore = -(wrist_away * ux + wrist_up * uz) / (l2 * bend)
            fastest = max(abs(across) / distance, abs(upper), abs(fore - upper), abs(rate - fore))
            row.append(
                max(0.0, min(1.0, (largest - LOW) / half, (HIGH - largest) / half, 1.0 - LOW * fastest))
            )
        rows.append(row)
    return rows


def words(division: Division, path: ToolPath) -> str:
    """Score of the paper's table C2 (of as many as there are points), and the shares of the path."""
    shares = [path.lengths[part.last] - path.lengths[part.first] for part in division.segments]
    return (
        f"{division.score / path.length * len(path.points):.1f} ("
        + " ".join(f"{share / path.length:.2f}" for share in shares)
        + ")"
    )


def speed_rows(quick: bool) -> list[Row]:
    """400 points x 20,000 base poses."""
    path, arm = arched_seam(4.6, 0.5), PitchArm()
    nx, ny, turns = PLACEMENTS
    bases = grid(
        np.linspace(-2.7, 2.7, nx),
        np.linspace(-1.6, -0.3, ny),
        np.linspace(-np.pi, np.pi, turns, endpoint=False),
    )
    rule = ScoreRule.uniform(Measure.SURE, LOW, HIGH, 4)
    scores = arm.scores(bases, path, rule)
    some = np.random.default_rng(0).choice(len(bases), 200 if quick else 1000, replace=False)
    plain_times, score_times, program_times = [], [], []
    for _ in range(3):
        begin = time.perf_counter()
        plain = plain_scores(arm, bases[some], path)
        plain_times.append((time.perf_counter() - begin) * len(bases) / len(some))
        score_times.append(least(lambda: arm.scores(bases, path, rule), 3))
        program_times.append(least(lambda: best_division(scores, path.lengths, 3), 3))
    worst = float(np.abs(np.array(plain) - scores.values[some]).max())
    score, plain_s, program = min(score_times), min(plain_times), min(program_times)
    return [
        Row(f"score of {len(bases)} x {len(path.points)} cells", f"{score:.3f} s"),
        Row(
            f"the same in plain loops ({len(some)} placements, scaled)",
            f"{plain_s:.1f} s, differs by {worst:.0e}",
        ),
        Row("times faster", f"{plain_s / score:.0f}", ">= 50"),
        Row("programming, 3 placements", f"{program:.3f} s", "<= 0.3 s"),
        Row("programming, 8 placements", f"{least(lambda: best_division(scores, path.lengths, 8), 3):.3f} s"),
        Row("programming, cost", f"{least(lambda: best_division_by_cost(scores, path.lengths, 0.1)):.3f} s"),
        Row("greedy", f"{least(lambda: greedy_division(scores, path.lengths)):.3f} s"),
        Row("in all", f"{score + program:.3f} s", "<= 2 s, aim 0.5 s"),
    ]


def seam_rows() -> list[Row]:
    """Scores of two seams as in the reproduction of figure 4."""
    rows, arm = [], PitchArm()
    for span, rise in ((2.6, 0.45), (5.0, 0.5)):
        path = arched_seam(span, rise)
        nx, ny, turns = PLACEMENTS
        bases = grid(
            np.linspace(-0.5 * span - 0.4, 0.5 * span + 0.4, nx),
            np.linspace(-1.6, -0.3, ny),
            np.linspace(-np.pi, np.pi, turns, endpoint=False),
        )
        for measure in (Measure.DIRECTIONAL, Measure.SURE):
            rule = ScoreRule.uniform(measure, LOW, HIGH, 4)
            scores = arm.scores(bases, path, rule)
            greedy = greedy_division(scores, path.lengths)
            best = best_division(scores, path.lengths, len(greedy.segments))
            name = f"seam {path.length:.2f} m, {measure.name.lower()}"
            rows += [Row(f"{name}, greedy", words(greedy, path)), Row(f"{name}, exact", words(best, path))]
            rows.append(_refined_row(name, arm, path, rule, bases, best))
    return rows


def _refined_row(
    name: str, arm: PitchArm, path: ToolPath, rule: ScoreRule, bases: FloatArray, best: Division
) -> Row:
    refined = refine(lambda some, part: arm.scores(some, part, rule), path, bases, best, 0.1, 0.3)
    far = 0.5 * path.length + 0.75
    corner, size = np.array((-far, -1.95)), np.array((2.0 * far, 2.0))
    bound = score_bound(arm, path, rule, corner, size, 0.01, len(best.segments))
    share = 100.0 * refined.division.score / bound
    return Row(f"{name}, refined", f"{words(refined.division, path)}, at least {share:.1f} % of the best")


def figure_rows() -> list[Row]:
    """Figure 2: the first placement's distance from the path, and the first length."""
    path, rows = straight_seam(), []
    bases = grid(np.linspace(0.0, 4.4, 89), -np.linspace(0.05, 1.95, 39), np.zeros(1))
    for measure in Measure:
        scores = PlanarArm().scores(bases, path, ScoreRule.uniform(measure, 0.5, 1.8, 2))
        for how, division in (
            ("greedy", greedy_division(scores, path.lengths)),
            ("exact", best_division(scores, path.lengths, 2)),
        ):
            first = division.segments[0]
            distance, length = -bases[first.placement, 1], path.lengths[first.last]
            rows.append(
                Row(
                    f"figure 2, {measure.name.lower()}, {how}",
                    f"distance {distance:.2f} m, first {length:.2f} m",
                )
            )
    return rows


def program_rows() -> list[Row]:
    """Top speeds of arms with a joint to spare: closed form beside the linear program."""
    rng = np.random.default_rng(0)
    jacobians, directions, limits = rng.normal(size=(200, 6, 7)), rng.normal(size=(200, 6)), np.ones(7)
    by_program = [top_speed_by_program(J, k, limits) for J, k in zip(jacobians, directions, strict=True)]
    worst = np.abs(top_speed(jacobians, directions, limits) / by_program - 1.0).max()
    closed = least(lambda: top_speed(jacobians, directions, limits)) / 200
    program = least(lambda: top_speed_by_program(jacobians[0], directions[0], limits))
    return [
        Row("top speed, 7 joints, closed form", f"{1e6 * closed:.0f} us, differs by {worst:.0e}"),
        Row("the same by HiGHS", f"{1e6 * program:.0f} us"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer placements in plain loops")
    quick = parser.parse_args().quick
    print(f"{'what':58} {'ours':44} wanted")
    for rows in (figure_rows(), speed_rows(quick), program_rows(), seam_rows()):
        for row in rows:
            print(f"{row.what:58} {row.ours:44} {row.wanted}")


if __name__ == "__main__":
    main()
