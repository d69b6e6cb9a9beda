"""Mutant of the conformance kit: a faulty primitive or backend, and how the kit has to find it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from handcart.backends.capabilities.capability import Capability
from handcart.evaluation.conformance.faults.fail_is_true import Batch
from handcart.evaluation.conformance.faults.fault import FaultKind
from handcart.evaluation.conformance.faults.rehearsal import Rehearsal
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.primitives.contract.action_primitive import ActionPrimitive

FAULT_INSTANTS = 10
"""Number of fault instants in a mutant's run; the first violation ends it."""
TRIAL_LIMIT_S = 60.0
"""Limit of the CPU time of a trial, in [s]."""


@dataclass(frozen=True)
class Mutant:
    """Deliberately faulty primitive or backend, and the part of the conformance kit that has to find it."""

    name: str
    lie: str
    """Fault of the mutant, in words for people."""
    look: Callable[[KitBench], list[str]]
    """Function that returns the violations found on a bench."""
    needs: tuple[type[Capability], ...] = ()
    """Capabilities that the robot must have."""
    by_truth: bool = False
    """True if only the ground truth reveals the mutant."""


def first_violations(batch: Batch) -> list[str]:
    """Return the violations of the first trial of a batch that has violations; empty if no trial has."""
    found = ([f"{trial.fault}: {wrong}" for wrong in trial.ending.wrong] for trial in batch.trials())
    return next((wrong for wrong in found if wrong), [])


def task_violations(
    task: Path, name: str, number: int, kind: type[ActionPrimitive], bench: KitBench
) -> list[str]:
    """Return the violations that are found when a faulty primitive is cancelled in a task.

    The primitive is cancelled at several instants, in one run each; the violations are those of the first
    such run that has any.

    Args:
        task: file of the task in which the mutant replaces a primitive.
        name: name of the replaced primitive in the file.
        number: number of the action in which the primitive is cancelled.
        kind: class of the faulty primitive.
        bench: bench whose backend runs the task.
    """
    rehearsal = Rehearsal(task, bench.backend, instead={name: kind}, simulated=bench.simulated)
    return first_violations(
        Batch(rehearsal, number, FAULT_INSTANTS, kinds=(FaultKind.CANCEL,), seconds=TRIAL_LIMIT_S)
    )
