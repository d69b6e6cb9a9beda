"""Test that primitives refuse to start with the wrong object in the hand, for the true reason.

    python -m benchmarks.contract.preconditions [--backend kinematic] [--seeds 1] [--tasks WORD]

Each shipped task that its domain rehearses is run action by action. Before each action, every primitive of
the task is tried in a copy of the process, with the parameters of its actions and with another object: so
it starts with the hand empty, full, with another object, and at the wrong place. If the object in the hand
contradicts the declared precondition, the outcome must be a Fail that moves nothing and names the hand;
every other attempt must end truly. Prints a line for each stage, and the sum; status 1 if anything is
wrong.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.evaluation.conformance.faults.forked import Died, Hung, forkable, forked
from handcart.evaluation.conformance.faults.rehearsal import Rehearsal
from handcart.evaluation.conformance.faults.repertoire import declared
from handcart.evaluation.conformance.faults.underway import Underway
from handcart.evaluation.judging.hand_claims import things_held
from handcart.networks.graph.network import NotBound
from handcart.networks.task.primitive_parameters import named_entry
from handcart.networks.task.task_file import load_task
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.preconditions.hand_use import Hand

STILL_M = 1e-4
"""Sum of the motions of base, joints and fingers below which nothing has moved [m], [rad]."""
NAMES_HAND = ("the hand ", "no book has been recognized")
"""Beginnings of reasons that refuse a start because of the hand."""


@dataclasses.dataclass(frozen=True)
class Tried:
    """One primitive started in one stage of a task."""

    name: str
    held: str
    """Objects in the hand, by ground truth."""
    refused: bool
    """True if the declared precondition did not hold, by ground truth."""
    outcome: str
    reason: str
    moved: float
    """Commanded motion away from the start, in [m] and [rad] together."""
    wrong: tuple[str, ...]

    @property
    def faults(self) -> list[str]:
        """What is wrong with it, in words."""
        found = [f"{item} ({self.reason})" for item in self.wrong]
        if self.refused and self.outcome != "Fail":
            found.append(f"{self.outcome} although the hand holds {self.held or 'nothing'}")
        if self.refused and self.moved > STILL_M:
            found.append(f"it moved by {self.moved:.4f} before it refused")
        if self.refused and not self.reason.startswith(NAMES_HAND):
            found.append(f"the reason does not name the hand: {self.reason}")
        return found


def candidates(rehearsal: Rehearsal, underway: Underway) -> Iterator[ActionPrimitive]:
    """Give every primitive of the task with the parameters that it has there, and with another object."""
    given: set[str] = set()
    task = load_task(rehearsal.task, rehearsal.settings)
    known = task.knowledge.names()
    for action in task.network.actions:
        if action.binding is None:
            continue
        try:
            made = action.binding.make(underway.model)
        except NotBound:
            continue
        for item in (made, *_with_another(made, known)):
            key = f"{item.label()} {item.model_dump_json()}"
            if key not in given and sum(name.startswith(item.label() + " ") for name in given) < MOST_ALIKE:
                given.add(key)
                yield item


MOST_ALIKE = 3
"""Sets of parameters with which a primitive is tried in a stage."""


def _with_another(
    primitive: ActionPrimitive, known: Mapping[str, Collection[object]]
) -> Iterator[ActionPrimitive]:
    """Give it with another known thing, place or target for each parameter that names one."""
    for key, field in type(primitive).model_fields.items():
        now = getattr(primitive, key)
        others = [name for name in known.get(named_entry(field) or "", ()) if name != now]
        if isinstance(now, str | int) and others:
            yield primitive.model_copy(update={key: others[0]})


def started(primitive: ActionPrimitive, rehearsed: Underway) -> Tried:
    """Run a primitive at the current stage of a rehearsal, and compare its outcome with the truth."""
    truth = rehearsed.backend.ground_truth()
    held = "" if truth is None else ", ".join(sorted(things_held(truth)))
    use, thing = primitive.hand_use(), primitive.thing(rehearsed.model.view(primitive))
    full = use.before is Hand.FULL
    refused = (use.before is Hand.EMPTY and held != "") or (full and (not held or thing not in ("", held)))
    robot: Any = rehearsed.robot
    moved = [0.0]
    begun, step = _commands(robot), robot.step
    driven = [0.0]

    def stepping(paused: bool = False) -> None:
        step(paused)
        driven[0] += abs(robot.driven[0]) * robot.period
        moved[0] = max(moved[0], driven[0] + float(np.abs(_commands(robot) - begun).max(initial=0.0)))

    robot.step = stepping
    trial = Underway(primitive, robot, rehearsed.backend, rehearsed.model, rehearsed.spec, rehearsed.seed)
    ending = trial.finish()
    return Tried(primitive.label(), held, refused, ending.outcome, ending.reason, moved[0], ending.wrong)


def _commands(robot: Any) -> np.ndarray:
    arm, gripper = robot.backend.get(Arm), robot.backend.get(Gripper)
    return np.concatenate([arm.command() if arm else [], [gripper.command()] if gripper else []])


def stages(rehearsal: Rehearsal, seconds: float) -> Iterator[tuple[str, list[Tried], int]]:
    """Yield each stage of a task, the primitives tried in it, and the number that did not end in time."""
    with forkable():
        for number, name, underway in rehearsal.attempts():
            tried, cut = [], 0
            for primitive in candidates(rehearsal, underway):
                try:
                    work = lambda each=primitive, at=underway: started(each, at)  # noqa: E731
                    tried.append(forked(work, Tried, seconds))
                except Hung:
                    cut += 1
                except Died as died:
                    tried.append(Tried(primitive.label(), "", False, "Error", str(died), 0.0, (str(died),)))
            yield f"{number}. before {name}", tried, cut


def main() -> int:
    """Print what came of it."""
    words = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    words.add_argument("--backend", default="kinematic")
    words.add_argument("--seeds", type=int, default=1)
    words.add_argument("--tasks", default="", help="only those with this in their path")
    words.add_argument("--seconds", type=float, default=20.0, help="of CPU time that a trial gets")
    wanted = words.parse_args()
    every: list[Tried] = []
    names: set[str] = set()
    cut, began = 0, time.monotonic()
    tasks = [(task, given) for task, given in declared().items() if wanted.tasks in str(task)]
    for task, settings in tasks:
        for seed in range(wanted.seeds):
            rehearsal = Rehearsal(task, wanted.backend, seed, settings=settings)
            print(f"{task.parent.name}/{task.name}, seed {seed}", flush=True)
            for stage, tried, late in stages(rehearsal, wanted.seconds):
                every += tried
                names |= {item.name for item in tried}
                cut += late
                refused = [item for item in tried if item.refused]
                print(f"  {stage}: {len(tried)} tried, {len(refused)} to be refused, {late} cut", flush=True)
                for item in tried:
                    for fault in item.faults:
                        print(f"    WRONG {item.name} ({item.outcome}, hand {item.held or 'empty'}): {fault}")
    return _sum_up(every, names, cut, time.monotonic() - began)


def _sum_up(every: list[Tried], names: set[str], cut: int, seconds: float) -> int:
    refused = [tried for tried in every if tried.refused]
    right = sum(not tried.faults for tried in refused)
    false = sum(bool(tried.wrong) for tried in every)
    shares = {word: sum(tried.outcome == word for tried in every) for word in ("Success", "Fail", "GiveUp")}
    print(f"{len(names)} primitives ({', '.join(sorted(names))}), {len(every)} starts: {shares}, {cut} cut")
    print(f"refused before anything moved, with the true reason: {right} of {len(refused)}")
    print(f"false outcomes: {false}; {seconds:.0f} s")
    return int(bool(false) or right < len(refused))


if __name__ == "__main__":
    raise SystemExit(main())
