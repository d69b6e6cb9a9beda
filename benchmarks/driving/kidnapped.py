"""Robots that are lifted and set down elsewhere, noticed or not: python -m benchmarks.driving.kidnapped

Each run drives to a place with MOVE_TO. In two of three runs the robot is lifted while it drives, otherwise
while it stands paused before; in a quarter of the runs it is set down 0.5 to 2 m away, otherwise anywhere on
the map. It is noticed where the robot says that it does not know where it is, or where its pose is true again
within 0.15 m and 5 degrees, within 5 s or 1 m of travel. An outcome is false where MOVE_TO is a Success and
the base is not at the place within 60 mm and 2 degrees, or a Fail and the base is not where it was when it
started.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.cut_off import CutOff
from benchmarks.driving.worlds.map_starts import (
    Chart,
    chosen_charts,
    floor_pose,
    start_options,
    written_world,
)
from handcart.evaluation.trials.rig import Rig, build_rig
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Fail, Outcome, Success
from handcart.robotics.geometry.pose2 import Pose2

NOTICED_S, NOTICED_M = 5.0, 1.0
TRUE_M, TRUE_DEG = 0.15, 5.0
ARRIVED_MM, ARRIVED_DEG = 60.0, 2.0
RESTORED_MM, RESTORED_DEG = 45.0, 2.0
PAUSE_S = 8.0  # of rest before a drive; the robot is lifted within it
NEAR_M = (0.5, 2.0)
MIN_GOAL_M = 4.0
MAX_DRAWS = 200
LONGEST_S = 400.0
PEOPLE_M = (0.9, 3.0)  # from the start, or from where the robot is set down, to the ends of a person's walk


class Case(NamedTuple):
    """One run."""

    seed: int
    start: Pose2
    goal: Pose2
    to: Pose2
    at_s: float
    is_paused: bool


class Kidnapped(NamedTuple):
    """Result of one run."""

    noticed: str
    """Check that noticed it; "late" or "unnoticed" otherwise; "not lifted" if the drive ended before."""
    seconds: float
    metres: float
    outcome: str
    reason: str
    false: bool


def draw(chart: Chart, seed: int) -> Case:
    """Draw the case of a seed."""
    rng = np.random.default_rng([seed, 42])
    start = chart.pose(rng)
    drawn = [chart.pose(rng) for _ in range(MAX_DRAWS)]
    goal = next((pose for pose in drawn if pose.distance(start) >= MIN_GOAL_M), None)
    goal = goal or max(drawn, key=start.distance)
    is_paused, is_near = seed % 3 == 2, rng.uniform() < 0.25
    at = rng.uniform(1.0, PAUSE_S - 1.0) if is_paused else rng.uniform(3.0, 2.0 + goal.distance(start) / 0.5)
    drawn = [chart.pose(rng) for _ in range(MAX_DRAWS)]
    far = [pose for pose in drawn if pose.distance(start) > NEAR_M[0]]
    near = [pose for pose in far if pose.distance(start) < NEAR_M[1]]
    to = (near if is_near and near else far)[0]
    return Case(seed, start, goal, to, float(round(at, 2)), is_paused)


def _people(chart: Chart, case: Case, count: int) -> list[dict[str, Any]]:
    """Return people who walk to and fro near the start and near where the robot is set down, in turn."""
    rng, found = np.random.default_rng([case.seed, 43]), list[dict[str, Any]]()
    while len(found) < count:
        around = (case.start, case.to)[len(found) % 2]
        drawn = [chart.pose(rng) for _ in range(MAX_DRAWS)]
        near = [pose for pose in drawn if PEOPLE_M[0] < pose.distance(around) < PEOPLE_M[1]]
        ends = near[:2] if len(near) > 1 else drawn[:2]
        points = [[round(pose.x, 3), round(pose.y, 3)] for pose in ends]
        found.append({"name": f"person {len(found)}", "waypoints_m": points, "pauses_s": [1.0, 2.0]})
    return found


class _Watch:
    """Looks in each period whether the robot has noticed."""

    def __init__(self, rig: Rig, case: Case) -> None:
        self._rig, self._at = rig, case.at_s
        self._count = rig.robot.localization.displacements
        self._before = 0.0
        self.since = -1.0
        self.metres = 0.0
        self.noticed = ""
        self.seconds = math.inf
        self.passed = 0.0

    def step(self) -> None:
        """Let a period pass."""
        robot = self._rig.robot
        robot.step()
        self.passed += robot.period
        travel = sum(robot.localization.travel) / 2.0
        if self.since < 0.0 and self.passed >= self._at - 1e-6:
            self.since, self._before = self.passed, travel
            self._count = robot.localization.displacements
        elif self.since >= 0.0 and not self.noticed:
            self.metres += abs(travel - self._before)
            self._before = travel
            self.noticed = self._by_what()
            self.seconds = self.passed - self.since if self.noticed else math.inf

    def _by_what(self) -> str:
        localization, truth = self._rig.robot.localization, self._rig.backend.ground_truth()
        assert truth is not None
        if localization.lifted is not None:
            return "lifted"
        if localization.lost is not None:
            return "lost"
        if localization.displacements > self._count:
            return "moved"
        off, turned = truth.base.distance(localization.pose), truth.base.turn(localization.pose)
        return "corrected" if off <= TRUE_M and math.degrees(turned) <= TRUE_DEG else ""


def kidnap_once(
    chart: Chart, seed: int, backend: str = "kinematic", robot: str = "cart", people: int = 0
) -> Kidnapped:
    """Lift a robot, with people around both places, and see what it says."""
    case = draw(chart, seed)
    more: dict[str, Any] = {"kidnap": {"at_s": case.at_s, "to": floor_pose(case.to)}}
    if people:
        more["passers"] = _people(chart, case, people)
    with tempfile.TemporaryDirectory() as folder:
        places = {"start": case.start, "goal": case.goal}
        files = written_world(Path(folder), chart, case.start, places, **more)
        with build_rig(files, robot, backend, seed) as rig:
            return _driven(rig, case)


def _driven(rig: Rig, case: Case) -> Kidnapped:
    watch = _Watch(rig, case)
    while case.is_paused and watch.passed < PAUSE_S:
        watch.step()
    begun = rig.backend.ground_truth()
    outcome = _outcome(rig, watch)
    lasted = watch.passed - watch.since
    while watch.since >= 0.0 and not watch.noticed and lasted < NOTICED_S:
        watch.step()
        lasted = watch.passed - watch.since
    after = rig.backend.ground_truth()
    assert begun is not None
    assert after is not None
    false = _is_false(outcome, case, begun.base, after.base)
    noticed = watch.noticed or "unnoticed"
    if watch.since < 0.0:
        noticed = "not lifted"
    word = "none" if outcome is None else type(outcome).__name__
    return Kidnapped(noticed, watch.seconds, watch.metres, word, getattr(outcome, "reason", ""), false)


def _outcome(rig: Rig, watch: _Watch) -> Outcome | None:
    """Return the outcome of MOVE_TO; None if it does not end."""
    periods = attempt(MoveTo(place="goal"), rig.robot, rig.model)
    while watch.passed < LONGEST_S:
        try:
            next(periods)
        except StopIteration as end:
            outcome: Outcome = end.value
            return outcome
        watch.step()
    return None


def _is_false(outcome: Outcome | None, case: Case, begun: Pose2, after: Pose2) -> bool:
    """Return whether the ground truth contradicts an outcome."""
    if isinstance(outcome, Success):
        off, turned = 1e3 * after.distance(case.goal), math.degrees(after.turn(case.goal))
        return off > ARRIVED_MM or turned > ARRIVED_DEG
    if isinstance(outcome, Fail):
        off, turned = 1e3 * after.distance(begun), math.degrees(after.turn(begun))
        return off > RESTORED_MM or turned > RESTORED_DEG
    return outcome is None


def main() -> None:
    words = start_options(__doc__, 200)
    words.add_argument("--people", type=int, default=0, help="number of people who walk about (default: 0)")
    chosen = words.parse_args()
    begun, noticed, outcomes, late, false = time.process_time(), Counter[str](), Counter[str](), 0, 0
    with tempfile.TemporaryDirectory() as folder:
        every = chosen_charts(Path(folder), chosen)
        lifted, seed = 0, chosen.first
        with CutOff() as cut:  # report the runs until then
            while lifted < chosen.runs:
                chart = every[seed % len(every)]
                print(
                    f"\rrun {lifted}, seed {seed}, {chart.name} ...   ", end="", file=sys.stderr, flush=True
                )
                found = kidnap_once(chart, seed, chosen.backend, chosen.robot, chosen.people)
                seed += 1
                if found.noticed == "not lifted":
                    continue
                lifted += 1
                is_late = found.noticed == "unnoticed" or (
                    found.seconds > NOTICED_S and found.metres > NOTICED_M
                )
                late += is_late
                false += found.false
                noticed[found.noticed] += 1
                outcomes[found.outcome] += 1
                if chosen.verbose or is_late or found.false:
                    print(f"\r{chart.name}, seed {seed - 1}: {found}")
    print(f"\r{lifted} lifted: {lifted - late} noticed within {NOTICED_S:g} s or {NOTICED_M:g} m")
    print(f"by {dict(noticed)}; outcomes {dict(outcomes)}")
    print(f"{false} false outcomes; {time.process_time() - begun:.0f} CPU s")
    raise SystemExit(cut.status(not lifted or bool(false)))


if __name__ == "__main__":
    main()
