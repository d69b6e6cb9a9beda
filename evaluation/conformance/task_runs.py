"""Runs of whole shipped tasks on a backend, compared with those on a reference backend."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from handcart.evaluation.conformance.checks.check import CheckResult
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

REFERENCE_BACKEND = "kinematic"
SUCCESS_OUTCOME = "Success"
SIGNIFICANCE_LEVEL = 0.05  # probability by chance below which success rates count as different


class Ran(NamedTuple):
    """Result of running a task once on a backend, with those outcomes of its actions that ground truth
    contradicts.
    """

    task: str
    backend: str
    seed: int
    errors: bool
    """True if the simulated robot had errors."""
    outcome: str
    situation: str
    reason: str
    untrue: tuple[str, ...]
    """Outcomes that the ground truth contradicts, in words."""

    @property
    def ends(self) -> str:
        """Text of how the run ended, with outcome, situation and reason."""
        why = f" ({self.reason})" if self.reason else ""
        return f"{self.outcome} in {self.situation}{why}"


@dataclass(frozen=True)
class OneRun:
    """Job that runs a task once on a backend, with or without the robot's simulated errors."""

    task: Path
    backend: str
    seed: int = 0
    errors: bool = True
    settings: Mapping[str, str] = field(default_factory=dict)
    simulated: str | None = None
    """Name of the simulated backend behind the drives or topics; None: the backend needs none."""

    def __str__(self) -> str:
        how = f"with seed {self.seed}" if self.errors else "without errors"
        return f"{self.task.parent.name} on {self.backend} {how}"

    def __call__(self) -> Ran:
        """Run the task once, and return how it ended."""
        with tempfile.TemporaryDirectory() as folder:
            summary, _ = run_task(
                self.task,
                Path(folder),
                RunOptions(self.backend, self.settings, self.seed, errors=self.errors, bench=self.simulated),
            )
        return Ran(
            self.task.parent.name,
            self.backend,
            self.seed,
            self.errors,
            summary["outcome"],
            summary["situation"],
            summary["reason"],
            tuple(summary["metrics"].get("untrue", ())),
        )


def task_runs(
    tasks: Sequence[Path],
    backend: str,
    seeds: int,
    settings: Mapping[str, str],
    simulated: str | None = None,
) -> list[OneRun]:
    """Return the runs of each task on the tested backend and on the reference backend.

    Each task runs once without simulated errors, and once for each seed with them.

    Args:
        tasks: files of the tasks.
        backend: name of the tested backend.
        seeds: number of seeds, from 0.
        settings: values of the tasks' parameters, by name.
        simulated: name of the simulated backend whose robot the drives or topics of `backend` control; None:
            `backend` needs no simulation.
    """
    backends = dict.fromkeys((backend, REFERENCE_BACKEND))
    return [
        OneRun(task, name, seed, errors, settings, simulated if name == backend else None)
        for task in tasks
        for name in backends
        for errors, count in ((False, 1), (True, seeds))
        for seed in range(count)
    ]


def compared(runs: Sequence[Ran], backend: str) -> list[CheckResult]:
    """Compare the runs of a backend with those of the reference backend, task by task.

    Return two results for each task: one for its runs without simulated errors, one for runs with errors.
    """
    return [
        finding
        for task in dict.fromkeys(run.task for run in runs)
        for finding in _of_task([run for run in runs if run.task == task], task, backend)
    ]


def _of_task(runs: Sequence[Ran], task: str, backend: str) -> Iterator[CheckResult]:
    ideal, erring = ([run for run in runs if run.errors is errors] for errors in (False, True))
    if ideal:
        yield _ideal(ideal, task, backend)
    if erring:
        yield _rates(erring, task, backend)


def _ideal(runs: Sequence[Ran], task: str, backend: str) -> CheckResult:
    alone = backend == REFERENCE_BACKEND
    finding = CheckResult(
        task, f"without errors it {'succeeds' if alone else f'ends as on {REFERENCE_BACKEND}'}"
    )
    ends = {run.backend: run.ends for run in runs}
    finding.measured += [f"{name}: {end}" for name, end in ends.items()]
    if alone:
        finding.expect(all(run.outcome == SUCCESS_OUTCOME for run in runs), "; ".join(finding.measured))
    else:
        finding.expect(ends.get(backend) == ends.get(REFERENCE_BACKEND), "; ".join(finding.measured))
    finding.wrong += _untrue(runs)
    return finding


def _rates(runs: Sequence[Ran], task: str, backend: str) -> CheckResult:
    from scipy.stats import fisher_exact

    alone = backend == REFERENCE_BACKEND
    against = (
        "its outcomes are true"
        if alone
        else f"it succeeds as often as on {REFERENCE_BACKEND}, at the 5 % level"
    )
    finding = CheckResult(task, f"with errors {against}")
    names = tuple(dict.fromkeys((backend, REFERENCE_BACKEND)))
    table = [_counted([run for run in runs if run.backend == name]) for name in names]
    rates = [f"{name}: Success {won} of {won + lost}" for name, (won, lost) in zip(names, table, strict=True)]
    if not alone:
        chance = float(fisher_exact(table).pvalue)
        rates.append(f"by chance with p = {chance:.3g} (Fisher)")
        finding.expect(chance >= SIGNIFICANCE_LEVEL, ", ".join(rates))
    finding.measured += rates
    finding.wrong += _untrue([run for run in runs if run.backend == backend])
    return finding


def _counted(runs: Sequence[Ran]) -> tuple[int, int]:
    """Return the numbers of runs that reached the goal, and of the others."""
    won = sum(run.outcome == SUCCESS_OUTCOME for run in runs)
    return won, len(runs) - won


def _untrue(runs: Sequence[Ran]) -> list[str]:
    return [f"seed {run.seed} on {run.backend}: {'; '.join(run.untrue)}" for run in runs if run.untrue]
