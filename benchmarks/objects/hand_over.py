"""Hand objects over to simulated persons: `python -m benchmarks.objects.hand_over`.

The robot stands at home with a parcel in its hand; a person pulls at it, or does something else, as drawn by
the seed. Printed is, for each kind of person, how often each outcome came, how many were false by the ground
truth, and the outcome that is wanted. Status 1 if one was false.

Persons: `pulls` (10 to 30 N with a tremor, in any direction but towards the robot, after 1 to 6 s),
`nobody`, `bumps` (20 to 60 N for 0.05 to 0.2 s, twice), `pushes` towards the robot, `lets_go` (pulls for 0.3
to 1.2 s: the object falls if the fingers open too late), `leans` (pulls without taking hold: it falls),
`early` (pulls while the arm is on its way, for 0.1 to 8 s), `holds` (pulls from about when the hand arrives,
for 6 s), `tears` (more than the fingers hold, at any time), `vibrates` (a force that changes its sign).
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from handcart.backends.simulation.world.thing import Rest
from handcart.primitives.objects.hand_over import HandOver
from handcart.primitives.outcomes.outcome import Fail, Outcome, Success

from .handing import OBJECT_NAME, rig_holding, scene_of, world_with

Pulls = Sequence[Mapping[str, Any]]
PULL_DIRECTIONS = ("away", "away", "up", "left", "right", "down")
WAIT_S = 10.0
MAX_OFF_RAD, MAX_OFF_M = 0.02, 0.015  # of joints and base after a Fail, from where they were


def main() -> None:
    """Print a row for each kind of person."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seeds", type=int, default=20, help="number of seeds, from --first")
    words.add_argument("--first", type=int, default=0)
    words.add_argument("--backend", default="kinematic")
    words.add_argument("--robot", default="librarian")
    words.add_argument("--persons", nargs="+", default=list(PERSON_KINDS), choices=list(PERSON_KINDS))
    asked = words.parse_args()
    false: list[str] = []
    print(f"{'person':<10}{'Success':>8}{'Fail':>6}{'GiveUp':>8}{'false':>7}  causes of Fails and GiveUps")
    for person in asked.persons:
        began, ends, wrong = time.process_time(), Counter[str](), 0
        for seed in range(asked.first, asked.first + asked.seeds):
            outcome, untrue = hand_over(person, seed, asked.backend, asked.robot)
            ends[type(outcome).__name__] += 1
            if not isinstance(outcome, Success):
                ends[outcome.cause.name] += 1
            wrong += bool(untrue)
            false += [f"{person}, seed {seed}: {type(outcome).__name__}, but {item}" for item in untrue]
        causes = ", ".join(f"{name} {count}" for name, count in sorted(ends.items()) if name.islower())
        row = "".join(f"{ends[name]:>{wide}}" for name, wide in (("Success", 8), ("Fail", 6), ("GiveUp", 8)))
        print(
            f"{person:<10}{row}{wrong:>7}  {causes}  ({time.process_time() - began:.0f} s of CPU)", flush=True
        )
    for text in false:
        print(text)
    sys.exit(bool(false))


def hand_over(person: str, seed: int, backend: str, robot: str) -> tuple[Outcome, list[str]]:
    """Return the outcome with a person of a kind, and how it is false."""
    with TemporaryDirectory(prefix="hand-over-") as folder:
        pulls = PERSON_KINDS[person](np.random.default_rng(seed))
        with rig_holding(world_with(Path(folder), pulls), robot, seed, backend) as rig:
            scene = scene_of(rig)
            joints, base = scene.joints.copy(), scene.base
            outcome = rig.do(HandOver(wait_s=WAIT_S))
            thing = scene.thing_named(f"object {OBJECT_NAME}")
            assert thing is not None
            moved = float(np.abs(scene.joints - joints).max()), scene.base.distance(base)
            return outcome, _untrue(outcome, thing.rest, *moved)


def _untrue(outcome: Outcome, rest: Rest, joints_off: float, base_off: float) -> list[str]:
    """Return how an outcome is false, by who has the object and how far arm and base are from their start."""
    if isinstance(outcome, Success):
        return [] if rest is Rest.PERSON else [f"the object's support is: {rest.value}"]
    if not isinstance(outcome, Fail):
        return []
    wrong = [] if rest is Rest.HAND else [f"the object's support is: {rest.value}"]
    wrong += [] if joints_off < MAX_OFF_RAD else [f"a joint is off by {joints_off:.3f}"]
    return wrong + ([] if base_off < MAX_OFF_M else [f"the base is off by {1e3 * base_off:.0f} mm"])


def _usual(rng: np.random.Generator, **others: Any) -> dict[str, Any]:
    usual = {
        "waits_s": float(rng.uniform(1.0, 6.0)),
        "force_n": float(rng.uniform(10.0, 30.0)),
        "sigma_deg": 15.0,
        "direction": str(rng.choice(PULL_DIRECTIONS)),
        "ramp_s": float(rng.uniform(0.0, 0.8)),
        "duration_s": 5.0,
        "tremor_n": float(rng.uniform(0.0, 1.5)),
    }
    return {**usual, **others}


def _bumps(rng: np.random.Generator) -> Pulls:
    def bump() -> dict[str, Any]:
        brief = {"ramp_s": 0.0, "duration_s": float(rng.uniform(0.05, 0.2)), "takes": False}
        return _usual(rng, force_n=float(rng.uniform(20.0, 60.0)), **brief)

    return [bump(), bump()]


def _early(rng: np.random.Generator) -> Pulls:
    when = {"at_s": float(rng.uniform(1.5, 3.5)), "duration_s": float(rng.uniform(0.1, 8.0))}
    return [_at(_usual(rng, **when))]


def _holds(rng: np.random.Generator) -> Pulls:
    return [_at(_usual(rng, at_s=float(rng.uniform(3.0, 4.5)), duration_s=6.0))]


def _tears(rng: np.random.Generator) -> Pulls:
    when = {"at_s": float(rng.uniform(1.0, 10.0)), "force_n": float(rng.uniform(150.0, 250.0))}
    return [_at(_usual(rng, **when))]


def _vibrates(rng: np.random.Generator) -> Pulls:
    period, size = float(rng.uniform(0.1, 0.3)), float(rng.uniform(10.0, 25.0))
    begun = float(rng.uniform(4.0, 6.0))
    return [
        _at(
            _usual(
                rng,
                at_s=begun + n * period / 2,
                force_n=size,
                direction=("left", "right")[n % 2],
                ramp_s=0.0,
                duration_s=period / 2,
                takes=False,
            )
        )
        for n in range(40)
    ]


def _at(pull: dict[str, Any]) -> dict[str, Any]:
    """Return a pull that begins at a time, whether the hand waits or not."""
    return {key: value for key, value in pull.items() if key != "waits_s"}


def _away(rng: np.random.Generator, **others: Any) -> Pulls:
    return [_usual(rng, **others)]


PERSON_KINDS: Mapping[str, Callable[[np.random.Generator], Pulls]] = {
    "pulls": lambda rng: _away(rng),
    "nobody": lambda rng: [],
    "bumps": _bumps,
    "pushes": lambda rng: _away(rng, direction="towards"),
    "lets_go": lambda rng: _away(rng, duration_s=float(rng.uniform(0.3, 1.2))),
    "leans": lambda rng: _away(rng, takes=False),
    "early": _early,
    "holds": _holds,
    "tears": _tears,
    "vibrates": _vibrates,
}
"""Pulls in a world's file, by the kind of person."""


if __name__ == "__main__":
    main()
