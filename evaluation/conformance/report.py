"""Results of the conformance kit for people and for programs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from handcart.evaluation.conformance.checks.check import CheckResult
from handcart.evaluation.conformance.faults.fail_is_true import FaultTrial
from handcart.evaluation.conformance.faults.fault import NO_FAULT
from handcart.evaluation.conformance.planted.mutants import Caught

from .task_runs import Ran, compared

MIN_CAUSE_SHARE = 0.95  # of the Fails and GiveUps after faults that must name a cause of the fault
MIN_JUDGED_CAUSES = 20  # fewer show nothing
OUTCOME_NAMES = ("Success", "Fail", "GiveUp")


@dataclass(frozen=True)
class Broken:
    """Job of the conformance kit that could not be run, and the reason."""

    name: str
    reason: str


Result = CheckResult | Caught | Broken | list[FaultTrial] | Ran


@dataclass(frozen=True)
class KitReport:
    """Results of all checks, fault trials, mutants and tasks with which the conformance kit has tested one
    backend.
    """

    backend: str
    robot: str
    quick: bool
    checks: tuple[CheckResult, ...]
    trials: tuple[FaultTrial, ...]
    mutants: tuple[Caught, ...]
    broken: tuple[Broken, ...]
    tasks: tuple[CheckResult, ...] = ()
    """Whole shipped tasks."""

    @classmethod
    def of(cls, backend: str, robot: str, quick: bool, results: Sequence[Result]) -> KitReport:
        """Return a report of results, which may be in any order.

        Args:
            backend: name of the tested backend.
            robot: name or file of the robot.
            quick: True for the quick mode.
            results: results of all jobs.
        """
        trials = (trial for result in results if isinstance(result, list) for trial in result)
        return cls(
            backend,
            robot,
            quick,
            tuple(result for result in results if isinstance(result, CheckResult)),
            tuple(sorted(trials, key=lambda item: (item.action, item.primitive, item.period))),
            tuple(
                sorted(
                    (result for result in results if isinstance(result, Caught)),
                    key=lambda result: result.name,
                )
            ),
            tuple(result for result in results if isinstance(result, Broken)),
            tuple(compared([result for result in results if isinstance(result, Ran)], backend)),
        )

    @property
    def injected(self) -> int:
        """Number of injected faults."""
        return sum(trial.kind != NO_FAULT for trial in self.trials)

    @property
    def bitten(self) -> int:
        """Number of injected faults that changed a reading, a command or the simulated world."""
        return sum(trial.kind != NO_FAULT and trial.ending.bitten for trial in self.trials)

    @property
    def violations(self) -> list[FaultTrial]:
        """Trials whose outcome the ground truth contradicts."""
        return [trial for trial in self.trials if trial.ending.wrong]

    @property
    def judged_causes(self) -> list[FaultTrial]:
        """Trials that ended in Fail or GiveUp after an injected fault, and whose named cause can be compared
        with the causes that the fault may have.
        """
        return [trial for trial in self.trials if trial.names_its_cause is not None]

    @property
    def wrong_causes(self) -> list[FaultTrial]:
        """Trials with an injected fault whose Fail or GiveUp named a cause which this fault does not have."""
        return [trial for trial in self.judged_causes if not trial.names_its_cause]

    @property
    def causes_hold(self) -> bool:
        """True if enough of the Fails and GiveUps name a cause of the injected fault (`MIN_CAUSE_SHARE`).

        It is also True if fewer than `MIN_JUDGED_CAUSES` Fails and GiveUps have causes that could be compared
        with the injected fault.
        """
        judged = len(self.judged_causes)
        return judged < MIN_JUDGED_CAUSES or len(self.wrong_causes) <= (1.0 - MIN_CAUSE_SHARE) * judged

    @property
    def planted(self) -> list[Caught]:
        """Results of the mutants (backends or primitives with a planted fault) that were tried on this robot.

        Other mutants need parts that the robot lacks.
        """
        return [mutant for mutant in self.mutants if not mutant.skipped]

    @property
    def missed(self) -> list[Caught]:
        """Mutants (backends and primitives with a planted fault) that the conformance kit did not find."""
        return [caught for caught in self.planted if not caught.by]

    @property
    def ok(self) -> bool:
        """True if the kit found no violation, every check and task passed, and every mutant was found.

        It is False as well if a job could not be run, or if too few Fails and GiveUps named a cause of the
        injected fault (`causes_hold`).
        """
        looked_at = (*self.checks, *self.tasks)
        wrong = self.violations or self.missed or self.broken or not self.causes_hold
        return not wrong and all(item.ok for item in looked_at)

    def as_dict(self) -> dict[str, Any]:
        """Return the report as values for JSON."""
        return {
            "ok": self.ok,
            "backend": self.backend,
            "robot": self.robot,
            "quick": self.quick,
            "checks": [asdict(check) | {"ok": check.ok} for check in self.checks],
            "faults": {
                "injected": self.injected,
                "bitten": self.bitten,
                "outcomes": self._outcomes(),
                "violations": [_violation(violation) for violation in self.violations],
                "causes": {
                    "judged": len(self.judged_causes),
                    "wrong": [f"{cause}: {cause.ending.cause}" for cause in self.wrong_causes],
                },
            },
            "mutants": {
                "planted": len(self.planted),
                "caught": len(self.planted) - len(self.missed),
                "each": [asdict(mutant) for mutant in self.mutants],
            },
            "tasks": [asdict(task) | {"ok": task.ok} for task in self.tasks],
            "broken": [asdict(item) for item in self.broken],
        }

    def _outcomes(self) -> dict[str, Mapping[str, int]]:
        """Return the counts of outcomes by action and by kind of fault."""
        found: dict[str, Counter[str]] = {}
        for trial in self.trials:
            for key in (trial.title, trial.kind):
                found.setdefault(key, Counter())[trial.ending.outcome] += 1
        return {key: dict(count) for key, count in found.items()}

    def lines(self) -> Iterator[str]:
        """Yield the report as lines of text: tables of checks, faults, mutants and tasks, and a summary."""
        if self.checks:
            yield f"checks of {self.backend} with {self.robot}"
            for check in self.checks:
                yield from _check_lines(check)
        if self.trials:
            yield from self._fault_lines()
        if self.mutants:
            yield from self._mutant_lines()
        if self.tasks:
            yield ""
            yield f"shipped tasks on {self.backend}"
            for task in self.tasks:
                yield from _check_lines(task)
                yield from (f"        {line}" for line in task.measured)
        for broken in self.broken:
            yield f"BROKEN  {broken.name}: {broken.reason}"
        yield ""
        yield self.summary

    @property
    def summary(self) -> str:
        """Summary of the report in one line."""
        wrong = sum(not check.ok for check in self.checks)
        parts = [f"{len(self.checks)} checks, {wrong} wrong"] if self.checks else []
        if self.trials:
            parts.append(f"{self.injected} faults, {len(self.violations)} violations")
        if self.mutants:
            parts.append(f"{len(self.planted) - len(self.missed)} of {len(self.planted)} liars caught")
        if self.tasks:
            parts.append(f"{len(self.tasks)} comparisons of tasks, {sum(not t.ok for t in self.tasks)} wrong")
        if self.broken:
            parts.append(f"{len(self.broken)} parts broken")
        return "; ".join(parts)

    def _fault_lines(self) -> Iterator[str]:
        yield ""
        yield f"{'faults injected':<20}{'tried':>8}{'felt':>8}" + "".join(
            f"{name:>9}" for name in OUTCOME_NAMES
        )
        groups: dict[str, list[FaultTrial]] = {}
        for trial in self.trials:
            if trial.kind != NO_FAULT:
                groups.setdefault(trial.title, []).append(trial)
        for trial in self.trials:
            if trial.kind != NO_FAULT:
                groups.setdefault(trial.kind, []).append(trial)
        for title, trials in groups.items():
            ended = Counter(trial.ending.outcome for trial in trials)
            felt = sum(trial.ending.bitten for trial in trials)
            row = "".join(f"{ended[name]:>9}" for name in OUTCOME_NAMES)
            yield f"  {title:<18}{len(trials):>8}{felt:>8}{row}"
        yield from self._cause_lines()
        for trial in self.violations:
            yield f"  VIOLATION  {trial}"

    def _cause_lines(self) -> Iterator[str]:
        judged, wrong = len(self.judged_causes), self.wrong_causes
        word = "" if self.causes_hold else "WRONG  "
        right = f"{judged - len(wrong)} of {judged} Fails and GiveUps"
        yield f"  {word}{right} name a cause that the fault may lead to"
        for trial in wrong:
            yield f"    {trial.title}, period {trial.period}, {trial.fault}: {trial.ending.cause}"

    def _mutant_lines(self) -> Iterator[str]:
        yield ""
        yield f"liars caught: {len(self.planted) - len(self.missed)} of {len(self.planted)}"
        for mutant in self.mutants:
            word = "-" if mutant.skipped else "caught" if mutant.by else "MISSED"
            found = mutant.skipped or mutant.by or "nothing is found"
            yield f"  {word:<8}{mutant.name:<20}{mutant.lie}: {found}"


def _check_lines(each: CheckResult) -> Iterator[str]:
    word = "-" if each.skipped else "ok" if each.ok else "WRONG"
    yield f"  {word:<6}{each.name:<14}{each.skipped or each.holds}"
    for wrong in each.wrong:
        yield f"        {wrong}"


def _violation(trial: FaultTrial) -> dict[str, Any]:
    return trial._asdict() | {"ending": asdict(trial.ending), "told": str(trial)}
