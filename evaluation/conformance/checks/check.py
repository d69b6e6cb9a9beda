"""Check of a requirement, and its result."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.skipped import Skipped


@dataclass
class CheckResult:
    """Result of a conformance check, with violations in `wrong` and observed values in `measured`.

    If the check does not apply to the robot, `skipped` has the reason.
    """

    name: str
    holds: str
    """Property that must hold."""
    wrong: list[str] = field(default_factory=list)
    measured: list[str] = field(default_factory=list)
    skipped: str = ""

    @property
    def ok(self) -> bool:
        """True if the check found no violation."""
        return not self.wrong

    def expect(self, holds: bool, words: str) -> None:
        """Record a violation, described by `words`, unless the condition holds."""
        if not holds:
            self.wrong.append(words)

    def at_most(self, what: str, size: float, most: float, unit: str = "") -> None:
        """Record a measured size, and report a violation if it is NaN or larger than a limit.

        Args:
            what: name of the size, as text.
            size: the size, in `unit`.
            most: largest allowed size, in `unit`.
            unit: unit as text; empty for none.
        """
        words = f"{what} {size:.3g}{unit and ' '}{unit}"
        self.measured.append(words)
        self.expect(size <= most, f"{words}; at most {most:.3g} is allowed")


@dataclass(frozen=True)
class Check:
    """Conformance check, with the property that every backend must have and the function that tests it."""

    name: str
    holds: str
    """Property that must hold, as text for the table."""
    look: Callable[[KitBench, CheckResult], None]

    def __call__(self, bench: KitBench) -> CheckResult:
        """Run the check on a bench; an exception of the backend is recorded as a violation."""
        finding = CheckResult(self.name, self.holds)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)  # a sum of NaN, an overflow
                self.look(bench, finding)
        except Skipped as reason:
            finding.skipped = str(reason)
        except Exception as error:
            finding.wrong.append(f"it broke the check: {type(error).__name__}: {error}")
        return finding
