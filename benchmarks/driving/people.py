"""Drives among walking people: `python -m benchmarks.driving.people [--runs N] [--first SEED]`.

Five people walk to and fro at 1.2 m/s, in offices and corridors in turn; no map shows them, and they do not
stop for the robot (a disc of 0.22 m, up to 1 m/s). `tasks/drive_map` drives 8 m and more, as `handcart run`
does it. A run counts as reached if it ended in Success, Fails on the way included. Contacts by the robot are
those while its base moved; a person who walks into it while it stands is counted apart. Status 1 if a contact
by the robot or a false outcome happened.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.cut_off import CutOff
from benchmarks.driving.cluttered import SLOW_MS, TASK_PATH, Trial, run_watched
from benchmarks.driving.cluttered_robot import write_robot
from benchmarks.driving.worlds.people_worlds import PeopleWorld, people_world, write_people_world
from handcart.evaluation.judging.contact_survey import ContactSurvey
from handcart.evaluation.judging.judge import Judge
from handcart.networks.task.preparing import prepare

RADIUS_M = 0.22  # of the robot's footprint
GIVEN_S = 600.0  # simulated time after which a run is interrupted
WAIT_S = 15.0  # that MOVE_TO waits for people


@dataclass
class PeopleTrial(Trial):
    """Result of one run."""

    kind: str = ""
    by_robot: int = 0
    """Contacts while the base moved."""
    while_standing: int = 0
    others: list[str] = field(default_factory=list)
    """Contacts with anything else than a person."""

    @property
    def arrived(self) -> bool:
        """True if the goal was reached, with or without Fails on the way."""
        return self.outcome == "Success"


def try_people(world: PeopleWorld, chosen: argparse.Namespace) -> PeopleTrial:
    """Drive among the people of a world."""
    result = PeopleTrial(world.seed, 0.0, best_m=world.best_m, given_s=GIVEN_S, kind=world.kind)
    with TemporaryDirectory(prefix="people-") as name:
        folder = Path(name)
        write_people_world(world, folder, chosen.walk, chosen.body, chosen.yields)
        settings = {key: str(folder / f"{key}.yaml") for key in ("map", "world", "places")}
        settings |= {
            "robot": str(write_robot(folder, (RADIUS_M,), chosen.speed, "scan")),
            "tour": "[goal]",
            "wait_s": f"{WAIT_S}",
        }
        with prepare(TASK_PATH, backend=chosen.backend, settings=settings, seed=world.seed) as prepared:
            judge = run_watched(prepared, folder, result)
            _count(judge, prepared.backend.scene, result)  # type: ignore[attr-defined]
    return result


def _count(judge: Judge, scene: Any, result: PeopleTrial) -> None:
    survey = judge.surveys.of(ContactSurvey)
    assert survey is not None
    of_people = [contact for contact in survey.contacts if contact.other in scene.passers.names]
    result.while_standing = sum(person.ran_into_it for person in of_people)
    result.by_robot = len(of_people) - result.while_standing
    result.others = [
        f"{contact.body} touched {contact.other}" for contact in survey.contacts if contact not in of_people
    ]
    moving = (person for person in of_people if not person.ran_into_it)
    result.others += [f"at {item.speed_m_s} m/s, {item.from_s} s" for item in moving]


def people_report(results: list[PeopleTrial], speed: float) -> str:
    """Return the summary of all runs as text."""
    arrived = [result for result in results if result.arrived]
    touched = sum(len(result.others) - result.by_robot for result in results)
    lines = [
        f"{len(results)} runs: contacts by the robot {sum(result.by_robot for result in results)}; "
        "goal reached "
        f"{len(arrived)} ({100.0 * len(arrived) / max(1, len(results)):.1f} %), without a Fail "
        f"{sum(result.reached for result in results)}; was run into while standing "
        f"{sum(result.while_standing for result in results)} times; other contacts {touched}; "
        f"false outcomes {sum(len(result.false) for result in results)}"
    ]
    ends = Counter(f"{result.kind}: {result.outcome}" for result in results)
    lines.append(", ".join(f"{count} {end}" for end, count in sorted(ends.items())))
    if arrived:
        ratios = np.array([trial.seconds * speed / trial.best_m for trial in arrived])
        low, middle, high = np.percentile(ratios, [5, 50, 95])
        spread = f"(5 % {low:.2f}, 95 % {high:.2f})"
        lines.append(f"time over (best way / top speed): median {middle:.2f} {spread}")
    taken = np.concatenate([result.periods_ms for result in results])
    if not len(taken):
        return "\n".join([*lines, "no period was measured: the runs ended before they drove"])
    lines.append(
        f"CPU of a period: mean {taken.mean():.2f} ms, 99 % {np.percentile(taken, 99):.2f} ms, "
        f"above {SLOW_MS:g} ms {100.0 * float((taken > SLOW_MS).mean()):.2f} %"
    )
    return "\n".join(lines)


def main() -> None:
    """Try the worlds one after the other."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--runs", type=int, default=200, help="number of runs (default: 200)")
    words.add_argument("--first", type=int, default=0, metavar="SEED", help="seed of the first (default: 0)")
    words.add_argument("--people", type=int, default=5, help="number of people (default: 5)")
    words.add_argument("--walk", type=float, default=1.2, help="their speed in m/s (default: 1.2)")
    words.add_argument(
        "--body", choices=("legs", "disc"), default="legs", help="parts of them that the lidar sees"
    )
    words.add_argument("--yields", action="store_true", help="they stand before the robot")
    words.add_argument("--speed", type=float, default=1.0, help="top speed of the robot in m/s (default: 1)")
    words.add_argument("--backend", default="kinematic", help="kinematic (default), mujoco, pybullet")
    chosen = words.parse_args()
    print(
        f"{chosen.runs} runs on {chosen.backend}, {chosen.people} people at {chosen.walk:g} m/s", flush=True
    )
    results = []
    with CutOff() as cut:  # report the runs until then
        for seed in range(chosen.first, chosen.first + chosen.runs):
            result = try_people(people_world(seed, chosen.people, RADIUS_M), chosen)
            results.append(result)
            seconds = "-" if math.isnan(result.seconds) else f"{result.seconds:.1f}"
            print(
                f"run {seed} ({result.kind}): {result.outcome}, {result.fails} Fails, {seconds} s for "
                f"{result.best_m:.1f} m, by robot {result.by_robot}, while standing {result.while_standing}"
                + ("" if result.reached else f"; {result.reason}")
                + "".join(f"\n  {other}" for other in result.others)
                + "".join(f"\n  FALSE: {item}" for item in result.false),
                flush=True,
            )
    print(people_report(results, chosen.speed))
    raise SystemExit(cut.status(not results or any(item.by_robot or item.false for item in results)))


if __name__ == "__main__":
    main()
