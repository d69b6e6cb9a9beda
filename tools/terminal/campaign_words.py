"""A campaign's report for people and for programs: the same bytes for the same trials."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.evaluation.campaigns.statistics.exact_value import compare_share, exact_goal
from handcart.evaluation.campaigns.statistics.rerun import rerun

if TYPE_CHECKING:
    from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
    from handcart.evaluation.campaigns.learned.learned import Learned
    from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport, Spread
    from handcart.evaluation.campaigns.statistics.claim import Settling
    from handcart.tools.terminal.rare_words import RareWords


class CampaignWords:
    """Formatter of a campaign's report, as lines for people or as JSON values for programs."""

    def __init__(
        self,
        report: CampaignReport,
        arguments: Mapping[str, Any],
        interrupted: bool,
        settling: Settling | None = None,
        learned: Learned | None = None,
    ) -> None:
        """Create the texts.

        Args:
            report: the report.
            arguments: arguments that the campaign's folder keeps.
            interrupted: True if the campaign was interrupted.
            settling: result of the test of a claim.
            learned: outcomes that the trials were drawn from.
        """
        self._report, self._arguments, self._interrupted = report, arguments, interrupted
        self._settling, self._learned = settling, learned

    def lines(self) -> Iterator[str]:
        """Yield the campaign's report as lines of text for people."""
        report = self._report
        low, high = report.wilson
        count = len(report.trials)
        yield f"Success {report.successes} of {count}; by Wilson {100 * low:.1f} to {100 * high:.1f} % (95 %)"
        if self._settling is not None:
            yield self._settling.words()
        if self._learned is not None:
            yield from self._learned.words()
        yield from self._exact_lines()
        yield f"outcomes that the ground truth contradicts: {len(report.untrue)} of {count} trials"
        for outcome, times in report.outcomes.most_common():
            yield f"  {times:4d} x {outcome}"
        if self._interrupted:
            yield f"interrupted after {count} of {self._arguments['trials']} trials"
        yield from self._metric_lines()
        yield from self._action_lines()
        yield from self._blame_lines()
        yield from self._worst_lines()

    def _exact_lines(self) -> Iterator[str]:
        goal = self._exact()
        if isinstance(goal, str):
            return
        found = compare_share(goal, self._report.successes, len(self._report.trials))
        verdict = "they agree" if found.agrees else "they differ: the probabilities in the file don't hold"
        yield f"handcart check computes {100 * goal:.2f} %: {verdict} (exact test, p = {found.p_value:.3g})"

    def _claim(self) -> dict[str, Any] | None:
        if self._settling is None:
            return None
        return {"claim": str(self._settling.claim), "holds": self._settling.verdict}

    def _metric_lines(self) -> Iterator[str]:
        names = ("trials", "least", "median", "95 %", "most")
        yield f"\n{'metric':<20}" + "".join(f"{item:>11}" for item in names) + f"{'95 % interval':>25}"
        for name, spread in self._report.spreads().items():
            figures = (spread.least, spread.median, spread.most_95, spread.most)
            shown = "".join(f"{figure:>11.2f}" for figure in figures)
            interval = _interval(spread, name in self._report.tally.yes_no)
            yield f"{name:<20}{spread.count:>11}{shown}{interval:>25}"

    def _action_lines(self) -> Iterator[str]:
        yield f"\n{'action':<56}{'attempts':>9}{'p':>7}{'95 %':>15}{'p_give_up':>11}"
        for share in self._report.shares:
            low, high = share.wilson
            ends = f"{share.p:>7.3f}{f'{low:.3f} to {high:.3f}':>17}{share.give_up / share.attempts:>9.3f}"
            yield f"{share.action:<56}{share.attempts:>9}{ends}"

    def _blame_lines(self) -> Iterator[str]:
        blames = self._report.blames
        if blames:
            yield "\nFails and GiveUps by primitive and cause"
        for blame, times in blames:
            found = f" ({blame.check})" if blame.check else ""
            kind = f" {blame.cause}" if blame.cause else ""
            yield f"{times:>6} x {blame.primitive} {blame.outcome}{kind}{found}: {blame.reason}"

    def _worst_lines(self) -> Iterator[str]:
        from handcart.evaluation.campaigns.statistics.divergence import first_difference

        median = self._report.median_run
        for trial in self._report.worst():
            words = "; ".join(trial.untrue) or trial.summary["reason"] or "with Fails"
            varied = ", ".join(f"{name} {value:g}" for name, value in trial.varied.items())
            yield f"\nseed {trial.seed}: {words}{f' (with {varied})' if varied else ''}"
            if median is not None and (found := first_difference(trial, median)):
                yield f"  {found.words('it', f'the median run (seed {median.seed})')}"
            yield f"  {rerun(self._arguments, trial.seed)}"

    def _exact(self) -> float | str:
        if not self._report.trials:
            return "no trial has ended"
        return exact_goal(Path(self._arguments["task"]), self._arguments["settings"])

    def facts(self) -> dict[str, Any]:
        """Return the report on the campaign as a dictionary of JSON values, for the option `--json`."""
        from handcart.evaluation.campaigns.statistics.divergence import first_difference

        report, median, goal = self._report, self._report.median_run, self._exact()
        exact: dict[str, Any] = {"unknown": goal} if isinstance(goal, str) else {"p_goal": goal}
        if not isinstance(goal, str):
            found = compare_share(goal, report.successes, len(report.trials))
            exact |= {"p_value": found.p_value, "agrees": found.agrees}
        return {
            "trials": len(report.trials),
            "asked": self._arguments["trials"],
            "interrupted": self._interrupted,
            "successes": report.successes,
            "wilson": list(report.wilson),
            "exact": exact,
            "until": self._claim(),
            "learned": None if self._learned is None else self._learned.facts(),
            "untrue": {str(trial.seed): list(trial.untrue) for trial in report.untrue},
            "outcomes": dict(report.outcomes),
            "metrics": {name: asdict(spread) for name, spread in report.spreads().items()},
            "actions": [
                {
                    "action": share.action,
                    "attempts": share.attempts,
                    "p": share.p,
                    "p_wilson": share.wilson,
                    "p_give_up": share.give_up / share.attempts,
                }
                for share in report.shares
            ],
            "blames": [{**blame._asdict(), "times": times} for blame, times in report.blames],
            "median_seed": None if median is None else median.seed,
            "worst": [
                {
                    "seed": trial_.seed,
                    "outcome": trial_.summary["outcome"],
                    "reason": trial_.summary["reason"],
                    "rerun": rerun(self._arguments, trial_.seed),
                    "differs": None if median is None else _difference(first_difference(trial_, median)),
                }
                for trial_ in report.worst()
            ],
        }


def _difference(found: Any) -> Any:
    return None if found is None else {"action": found.number, "words": found.words("it", "the median run")}


def _interval(spread: Spread, yes_no: bool) -> str:
    if spread.low is None or spread.high is None:
        return ""
    of = "yes" if yes_no else "median"
    return f"{of} {spread.low:.2f} to {spread.high:.2f}"


def report_of(found: CampaignFolder) -> tuple[CampaignReport, CampaignWords | RareWords]:
    """Return the report on the campaign in a folder, and the formatter of the report."""
    from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport
    from handcart.tools.terminal.rare_words import RareWords

    report = CampaignReport(found.trials())
    if found.arguments.get("rare"):
        return report, RareWords(report.trials, found.arguments, False)
    return report, CampaignWords(report, found.arguments, False)
