"""Check that outcomes are true under every fault at every instant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .expected_causes import expected_causes
from .fault import NO_FAULT, PRIMITIVE_FAULTS, Fault, FaultKind, all_sensors, faults_of, variant
from .forked import Died, Hung, forkable, forked
from .rehearsal import Rehearsal, Solo
from .underway import AttemptEnding, Underway


class FaultTrial(NamedTuple):
    """Result of injecting one fault at one instant of a primitive's run."""

    primitive: str
    action: int
    """Number of the rehearsed action, from 1; 0: a primitive alone."""
    period: int
    """Number of periods of the attempt before the fault."""
    fault: str
    kind: str
    ending: AttemptEnding
    expected: tuple[str, ...] = ()
    """Causes that a Fail or GiveUp after the fault may name; empty: any."""

    def __str__(self) -> str:
        head = f"{self.title}, period {self.period}, {self.fault}: {self.ending.outcome}"
        return f"{head}: {'; '.join(self.ending.wrong)} ({self.ending.reason})"

    @property
    def names_its_cause(self) -> bool | None:
        """True if the Fail or GiveUp after the fault names one of its expected causes.

        None for a Success, for a fault without effect, or if any cause is allowed.
        """
        judged = self.ending.outcome in ("Fail", "GiveUp") and self.ending.bitten and self.expected
        return self.ending.cause in self.expected if judged else None

    @property
    def title(self) -> str:
        """Number of the action and name of its primitive; only the name if the primitive was run without a
        task.
        """
        return f"{self.action}. {self.primitive}" if self.action else self.primitive


@dataclass(frozen=True)
class Batch:
    """Faults to inject at some instants of one action's run, as the unit of work of one process."""

    rehearsal: Rehearsal | Solo
    action: int
    instants: int
    """Number of instants over the whole run of the action."""
    part: int = 0
    parts: int = 1
    kinds: tuple[FaultKind, ...] = PRIMITIVE_FAULTS
    seconds: float = 120.0
    """Limit of a trial's CPU time, in [s]; a longer trial counts as hanging."""

    def __str__(self) -> str:
        return f"faults in action {self.action}, part {self.part + 1} of {self.parts}"

    def __call__(self) -> list[FaultTrial]:
        """Return all trials."""
        return list(self.trials())

    def trials(self) -> Iterator[FaultTrial]:
        """Inject each fault at each instant of the action, and yield the results.

        The action is run once; at each instant, a forked copy of the process continues it with one fault.
        """
        with forkable():
            for number, name, underway in self.rehearsal.attempts():
                if number == self.action:
                    yield from self._trials(name, underway)
                    return
        raise ValueError(f"there is no action {self.action}")

    def _trials(self, name: str, underway: Underway) -> Iterator[FaultTrial]:
        nominal = self._tried(underway, None)
        if nominal.outcome != "Success" or nominal.wrong:
            wrong = nominal.wrong or ("nothing is broken, yet it doesn't succeed",)
            yield FaultTrial(name, self.action, 0, NO_FAULT, NO_FAULT, replace(nominal, wrong=wrong))
            return
        period = 0
        for number, instant in enumerate(spread(self.instants, nominal.periods)):
            if number % self.parts != self.part:
                continue
            while period < instant:
                underway.advance()
                period += 1
            for fault in self.faults(name, number, nominal.sensors or all_sensors()):
                ending = self._tried(underway, fault)
                words, expected = (str(fault), fault.kind.value), expected_causes(fault)
                yield FaultTrial(name, self.action, period, *words, ending, expected)

    def faults(self, name: str, number: int, sensors: Sequence[str]) -> list[Fault]:
        """Return the faults to inject at one instant, one of each kind in `kinds` and those that the domain
        declares.

        Args:
            name: name of the primitive, whose application domain may declare faults of its own.
            number: number of the instant; it selects one variant of each kind, such as the affected sensor.
            sensors: sensors that may be affected.
        """
        own = faults_of(name) if self.kinds == PRIMITIVE_FAULTS else ()
        general = [variant(kind, number + at + self.action, sensors) for at, kind in enumerate(self.kinds)]
        return [*general, *own]

    def _tried(self, underway: Underway, fault: Fault | None) -> AttemptEnding:
        try:
            return forked(lambda: underway.finish(fault), AttemptEnding, self.seconds)
        except Hung:
            return AttemptEnding("none", "", 0, wrong=("it hangs",))
        except Died as died:
            return AttemptEnding("none", str(died), 0, wrong=("the process died",))


def spread(count: int, periods: int) -> Sequence[int]:
    """Return at most `count` instants, as numbers of periods, evenly distributed over a run of an action.

    Args:
        count: largest number of instants.
        periods: number of periods of the run; instant 0, before its start, is excluded.
    """
    instants = np.linspace(1, max(2, periods), count, endpoint=False)
    return sorted({int(instant) for instant in instants})
