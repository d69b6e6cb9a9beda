"""Texts on a campaign's estimate of a rare event, as lines and as fields."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.rare.rare_estimate import RareEstimate
from handcart.evaluation.campaigns.statistics.exact_value import exact_end


class RareWords:
    """Formatter of the report on a campaign that estimates the probability of a rare outcome by populations
    of runs.
    """

    def __init__(self, trials: Sequence[Trial], arguments: Mapping[str, Any], interrupted: bool) -> None:
        """Create the texts.

        Args:
            trials: trials of the campaign, each a population of runs.
            arguments: arguments that the campaign's folder keeps.
            interrupted: True if the campaign was interrupted.
        """
        self._trials, self._arguments, self._interrupted = trials, arguments, interrupted
        self._event: Mapping[str, Any] = arguments["rare"]

    @cached_property
    def _found(self) -> RareEstimate:
        return RareEstimate.of(self._trials)

    @cached_property
    def _exact(self) -> float | str:
        task = Path(self._arguments["task"])
        return exact_end(task, self._arguments["settings"], self._event["outcome"])

    @cached_property
    def _untrue(self) -> list[str]:
        return [f"seed {trial.seed}: {item}" for trial in self._trials for item in trial.untrue]

    @cached_property
    def _broken(self) -> list[str]:
        return [f"seed {trial.seed}: {trial.summary['reason']}" for trial in self._trials if trial.broken]

    def lines(self) -> Iterator[str]:
        """Yield lines of text that report, for people, the estimated probability of the rare outcome."""
        found, count = self._found, len(self._trials) - len(self._broken)
        yield f"{self._event['outcome']}: {found.probability:.3g} of all runs, {_between(found)}"
        if found.unseen:
            most = f"at most {found.unseen:.2g} (95 %)"
            yield f"  not included: runs straight from a level at which none was seen, {most}"
        if not isinstance(self._exact, str):
            verdict = "they agree" if found.agrees(self._exact) else "they differ"
            yield f"handcart check computes {self._exact:.3g}: {verdict}"
        yield (
            f"{count} populations of {self._event['runs']} runs at each level; {found.steps} actions, as of "
            f"{found.cost:,.0f} runs from beginning to end; as accurate as {found.worth:,.0f} of those"
        )
        if self._broken:
            yield f"left out, because handcart itself failed: {len(self._broken)} populations"
            yield from (f"  {text}" for text in self._broken[:10])
        if self._interrupted:
            yield f"interrupted after {len(self._trials)} of {self._arguments['trials']} populations"
        yield f"outcomes that the ground truth contradicts: {len(self._untrue)}"
        yield from (f"  {text}" for text in self._untrue[:10])
        counted = {"fails": "Fails", "attempts": "attempts of one action"}[self._event["importance"]]
        names = ("share of runs", "begun", "came nearer", self._event["outcome"], "adds")
        yield f"\n{counted:<24}" + "".join(f"{item:>14}" for item in names)
        for number, level in enumerate(found.levels):
            figures = f"{level.runs:>14}{level.reached:>14}{level.hits:>14}{level.part:>14.3g}"
            yield f"{number:<24}{level.share:>14.3g}{figures}"
        kept = [name for trial in self._trials for name in _kept(trial)]
        if kept:
            yield f"\nrun folders of some that ended so: {', '.join(kept[:10])}"

    def facts(self) -> dict[str, Any]:
        """Return the report on a rare outcome's estimated probability as fields for `--json`."""
        found = self._found
        return {
            "rare": dict(self._event),
            "trials": len(self._trials),
            "asked": self._arguments["trials"],
            "interrupted": self._interrupted,
            "probability": found.probability,
            "interval": None if found.low is None else [found.low, found.high],
            "unseen": found.unseen,
            "exact": {"unknown": self._exact}
            if isinstance(self._exact, str)
            else {"p": self._exact, "agrees": found.agrees(self._exact)},
            "actions": found.steps,
            "cost_runs": found.cost,
            "worth_runs": found.worth,
            "levels": [{**level._asdict(), "adds": level.part} for level in found.levels],
            "untrue": self._untrue,
            "broken": self._broken,
            "runs_kept": [name for trial in self._trials for name in _kept(trial)],
        }


def _between(found: RareEstimate) -> str:
    if found.low is not None:
        return f"by the spread of the populations {found.low:.3g} to {found.high:.3g} (95 %)"
    if found.probability:
        return "with no interval: one population bounds nothing"
    return "none was seen"


def _kept(trial: Trial) -> list[str]:
    """Return the names of the run folders that a population has kept."""
    return list(trial.summary["metrics"].get("runs_kept", []))
