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
    """A part of the kit that could not be run."""

    name: str
    reason: str


Result = CheckResult | Caught | Broken | list[FaultTrial] | Ran


@dataclass(frozen=True)
class KitReport:
    """All that was found on one backend."""

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
        """Return a report of results in any order."""
        trials = (trial for each in results if isinstance(each, list) for trial in each)
        return cls(
            backend,
            robot,
            quick,
            tuple(each for each in results if isinstance(each, CheckResult)),
            tuple(sorted(trials, key=lambda each: (each.action, each.primitive, each.period))),
            tuple(sorted((each for each in results if isinstance(each, Caught)), key=lambda each: each.name)),
            tuple(each for each in results if isinstance(each, Broken)),
            tuple(compared([each for each in results if isinstance(each, Ran)], backend)),
        )

    @property
    def injected(self) -> int:
        """Number of injected faults."""
        return sum(trial.kind != NO_FAULT for trial in self.trials)

    @property
    def bitten(self) -> int:
        """Number of faults that changed anything."""
        return sum(trial.kind != NO_FAULT and trial.ending.bitten for trial in self.trials)

    @property
    def violations(self) -> list[FaultTrial]:
        """Trials after which something wasn't true."""
        return [trial for trial in self.trials if trial.ending.wrong]

    @property
    def judged_causes(self) -> list[FaultTrial]:
        """Trials that ended in Fail or GiveUp after a fault with known causes."""
        return [trial for trial in self.trials if trial.names_its_cause is not None]

    @property
    def wrong_causes(self) -> list[FaultTrial]:
        """Faults of `judged_causes` that led to another cause."""
        return [trial for trial in self.judged_causes if not trial.names_its_cause]

    @property
    def causes_hold(self) -> bool:
        """True if injected faults lead to their causes; too few show nothing."""
        judged = len(self.judged_causes)
        return judged < MIN_JUDGED_CAUSES or len(self.wrong_causes) <= (1.0 - MIN_CAUSE_SHARE) * judged

    @property
    def planted(self) -> list[Caught]:
        """Liars that could be planted on this robot."""
        return [each for each in self.mutants if not each.skipped]

    @property
    def missed(self) -> list[Caught]:
        """Mutants that the kit did not find."""
        return [each for each in self.planted if not each.by]

    @property
    def ok(self) -> bool:
        """True if every check holds."""
        looked_at = (*self.checks, *self.tasks)
        wrong = self.violations or self.missed or self.broken or not self.causes_hold
        return not wrong and all(each.ok for each in looked_at)

    def as_dict(self) -> dict[str, Any]:
        """Return the report as values for JSON."""
        return {
            "ok": self.ok,
            "backend": self.backend,
            "robot": self.robot,
            "quick": self.quick,
            "checks": [asdict(each) | {"ok": each.ok} for each in self.checks],
            "faults": {
                "injected": self.injected,
                "bitten": self.bitten,
                "outcomes": self._outcomes(),
                "violations": [_violation(each) for each in self.violations],
                "causes": {
                    "judged": len(self.judged_causes),
                    "wrong": [f"{each}: {each.ending.cause}" for each in self.wrong_causes],
                },
            },
            "mutants": {
                "planted": len(self.planted),
                "caught": len(self.planted) - len(self.missed),
                "each": [asdict(each) for each in self.mutants],
            },
            "tasks": [asdict(each) | {"ok": each.ok} for each in self.tasks],
            "broken": [asdict(each) for each in self.broken],
        }

    def _outcomes(self) -> dict[str, Mapping[str, int]]:
        """Return the counts of outcomes by action and by kind of fault."""
        found: dict[str, Counter[str]] = {}
        for trial in self.trials:
            for key in (trial.title, trial.kind):
                found.setdefault(key, Counter())[trial.ending.outcome] += 1
        return {key: dict(count) for key, count in found.items()}

    def lines(self) -> Iterator[str]:
        """Yield the table, line by line."""
        if self.checks:
            yield f"checks of {self.backend} with {self.robot}"
            for each in self.checks:
                yield from _check_lines(each)
        if self.trials:
            yield from self._fault_lines()
        if self.mutants:
            yield from self._mutant_lines()
        if self.tasks:
            yield ""
            yield f"shipped tasks on {self.backend}"
            for each in self.tasks:
                yield from _check_lines(each)
                yield from (f"        {line}" for line in each.measured)
        for broken in self.broken:
            yield f"BROKEN  {broken.name}: {broken.reason}"
        yield ""
        yield self.summary

    @property
    def summary(self) -> str:
        """Summary of the report in one line."""
        wrong = sum(not each.ok for each in self.checks)
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
            f"{each:>9}" for each in OUTCOME_NAMES
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
            row = "".join(f"{ended[each]:>9}" for each in OUTCOME_NAMES)
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
        for each in self.mutants:
            word = "-" if each.skipped else "caught" if each.by else "MISSED"
            yield f"  {word:<8}{each.name:<20}{each.lie}: {each.skipped or each.by or 'nothing is found'}"


def _check_lines(each: CheckResult) -> Iterator[str]:
    word = "-" if each.skipped else "ok" if each.ok else "WRONG"
    yield f"  {word:<6}{each.name:<14}{each.skipped or each.holds}"
    for wrong in each.wrong:
        yield f"        {wrong}"


def _violation(trial: FaultTrial) -> dict[str, Any]:
    return trial._asdict() | {"ending": asdict(trial.ending), "told": str(trial)}
