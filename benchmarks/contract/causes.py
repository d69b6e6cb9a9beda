"""Inject faults into primitives, and count those that lead to a cause of theirs.

    python -m benchmarks.contract.causes [--backend kinematic] [--robots librarian,cart]
                                         [--instants 2] [--actions 1,2] [--seed 0]

The faults are those of the conformance kit, at some instants of each action of the tasks that it tries a
robot in. Of the Fails and GiveUps those are right that name a cause which the kind of fault may lead to
(`evaluation/conformance/faults/expected_causes.py`), and derived that name one of those which the
primitive can raise by its code (`handcart describe`). Prints a line for each action, then the sums; status
1 below 95 %, or if a cause is not derived.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import replace

from benchmarks.cut_off import CutOff
from handcart.evaluation.conformance.faults.fail_is_true import Batch, FaultTrial
from handcart.evaluation.conformance.faults.rehearsal import Rehearsal
from handcart.evaluation.conformance.kit import KitSetting
from handcart.evaluation.conformance.report import MIN_CAUSE_SHARE
from handcart.evaluation.conformance.rig.reach import Reach
from handcart.primitives.contract.raised_causes import possible_causes
from handcart.primitives.registry import primitive_class

ROBOT_NAMES = "librarian,cart,toyama,el_verde"


def is_derived(trial: FaultTrial) -> bool:
    """Return whether the code of the primitive names the cause, or any attempt may have it."""
    kind = Reach if trial.primitive == Reach.label() else primitive_class(trial.primitive)
    return trial.ending.cause in {cause.name for cause in possible_causes(kind)}


def seeded(batch: Batch, seed: int) -> Batch:
    """Return the batch with another seed of the simulated errors."""
    source = batch.rehearsal
    return replace(batch, rehearsal=replace(source, seed=seed)) if isinstance(source, Rehearsal) else batch


def main() -> None:
    """Print the share."""
    words = argparse.ArgumentParser(
        prog="python -m benchmarks.contract.causes",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    words.add_argument("--backend", default="kinematic")
    words.add_argument("--robots", default=ROBOT_NAMES)
    words.add_argument("--instants", type=int, default=2, help="of each action")
    words.add_argument("--actions", default="", help="numbers of actions (default: all)")
    words.add_argument("--seed", type=int, default=0)
    given = words.parse_args()
    chosen = {int(part) for part in given.actions.split(",") if part}
    judged: Counter[str] = Counter()
    right: Counter[str] = Counter()
    lacking = 0
    with CutOff() as cut:  # report the faults until then
        for robot in given.robots.split(","):
            for batch in KitSetting(given.backend, robot, instants=given.instants).batches():
                if chosen and batch.action not in chosen:
                    continue
                print(f"{robot}, {batch}; so far {right.total()} of {judged.total()}", flush=True)
                for trial in seeded(batch, given.seed).trials():
                    if trial.names_its_cause is None:
                        continue
                    judged[trial.kind] += 1
                    right[trial.kind] += bool(trial.names_its_cause)
                    derived = is_derived(trial)
                    lacking += not derived
                    if not trial.names_its_cause or not derived:
                        word = "not derived" if not derived else "another cause"
                        ended = f"{trial.ending.cause} ({trial.ending.reason})"
                        print(f"  {word}: {trial.title}, {trial.fault}: {ended}", flush=True)
    for kind, count in sorted(judged.items()):
        print(f"{kind:<18}{right[kind]:>5} of {count:>5}")
    total = judged.total()
    share = right.total() / total if total else 0.0
    named = f"{right.total()} of {total} name a cause of their fault"
    print(f"{named}: {100 * share:.1f} %; not derived: {lacking}")
    raise SystemExit(cut.status(share < MIN_CAUSE_SHARE or bool(lacking)))


if __name__ == "__main__":
    main()
