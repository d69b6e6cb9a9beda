"""Odds learned from campaign folders, with their cross-validation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import chain
from pathlib import Path

from handcart.evaluation.campaigns.data.action_ends import action_names
from handcart.evaluation.campaigns.data.campaign_folder import TRIALS, CampaignFolder
from handcart.evaluation.campaigns.data.walked_trials import WalkedTrials
from handcart.files.errors import InputError
from handcart.files.printable import printable
from handcart.networks.task.task_file import Task, load_task

from .held_out import Trust, hold_out
from .learned_odds import LearnedOdds
from .prediction import Prediction, predict
from .seen_actions import SeenActions

MIN_TRIALS = 20
"""Minimum number of trials for learning."""


class NothingLearned(InputError):
    """Error for campaigns from which no prediction for the task can be learned."""


@dataclass(frozen=True)
class Learned:
    """Action outcomes from recorded trials, to predict the success and duration of a task.

    The task may arrange the actions differently than the trials' task did.
    """

    task: Task
    folders: tuple[Path, ...]
    seen: SeenActions

    @classmethod
    def read(cls, task: Task, folders: Sequence[Path]) -> Learned:
        """Read the trials in campaign folders, as far as they contain a task's actions.

        Raises:
            NoCampaign, TrialLogError: a folder cannot be read.
            NothingLearned: the trials were not run, are too few, or contain none of the task's actions.
        """
        found = [recorded_campaign(folder) for folder in folders]
        seen = SeenActions.of(
            task, chain.from_iterable(campaign_folder.trials() for campaign_folder in found)
        )
        names = ", ".join(map(str, folders))
        if len(seen.success) < MIN_TRIALS:
            count = len(seen.success)
            raise NothingLearned(printable(f"{names}: {count} trials; needed: at least {MIN_TRIALS}"))
        if not len(seen.entry):
            raise NothingLearned(printable(f"{names}: none of {task.document.file}'s actions; needed: some"))
        return cls(task, tuple(folders), seen)

    def check(self) -> None:
        """Raise `NothingLearned` if the results of one half of the trials differ significantly from those
        that the other half predicts.
        """
        wrong = self.trust.wrong
        if wrong is not None:
            raise NothingLearned(
                f"odds learned from one half of the trials predict {wrong.name} {wrong.predicted:.3g} "
                f"for the other, in which it is {wrong.measured:.3g} (p = {wrong.p_value:.2g}); needed: "
                "trials whose actions depend on no more than their own Fails and on whether the one before "
                "failed"
            )

    @cached_property
    def trust(self) -> Trust:
        """Result of predicting each half of the trials from the other half."""
        return hold_out(self.task, self.seen)

    @cached_property
    def prediction(self) -> Prediction:
        """Probability of the task's success and its mean duration, predicted from all recorded trials."""
        return predict(self.task, self.seen)

    @property
    def unknown(self) -> list[str]:
        """Names of the task's actions that no trial has started."""
        odds = LearnedOdds(self.task, self.seen, 1.0)
        return [name for number, name in enumerate(action_names(self.task)) if odds.unknown(number)]

    def words(self) -> Iterator[str]:
        """Yield lines of text about the predicted success and mean time, their cross-validation, and actions
        that no trial has started.
        """
        low, high = self.prediction.success_95
        short, long = self.prediction.time_95_s
        count = len(self.seen.success)
        yield (
            f"learned from {count} trials, which alone bound it to {100 * low:.1f} to {100 * high:.1f} % "
            f"and a mean time of {short:.4g} to {long:.4g} s (95 %), however many are walked"
        )
        for item in self.trust.tried:
            words = f"predicts {item.predicted:.3g}, there it is {item.measured:.3g} (p = {item.p_value:.2g})"
            yield f"  one half of them for the other: {item.name}: {words}"
        for name in self.unknown:
            yield f"  never started in them, so a walk that comes to it ends: {name}"

    def facts(self) -> dict[str, object]:
        """Return the prediction of a task's success and mean time as JSON values: 95 % intervals,
        cross-validation, and actions that no trial has started.
        """
        return {
            "trials": len(self.seen.success),
            "success_95": self.prediction.success_95,
            "mean_time_95_s": self.prediction.time_95_s,
            "halves": [item._asdict() for item in self.trust.tried],
            "never_started": self.unknown,
        }


def recorded_campaign(folder: Path) -> CampaignFolder:
    """Open the folder of a campaign whose trials were run, and are therefore evidence about its task.

    Raises:
        NoCampaign: the folder holds no campaign, or one that estimates a rare outcome.
        NothingLearned: its trials are random walks, or none has ended.
    """
    found = CampaignFolder.read_runs(folder)
    if (level := found.arguments["level"]) != "run":
        wrong = f"{folder}: its trials are of --level {level}; allowed: those that were run"
        raise NothingLearned(printable(wrong))
    if not (folder / TRIALS).exists():
        raise NothingLearned(
            printable(f"{folder}: there is no {TRIALS} in it; needed: trials that have ended")
        )
    return found


def learned_trials(task: Path, settings: Mapping[str, str], folders: Sequence[Path]) -> WalkedTrials:
    """Return a source of trials that simulates a task with probabilities learned from campaigns.

    The files are read again only if one was changed since the last call.

    Args:
        task: the task's file.
        settings: values of the task's parameters, by name.
        folders: folders of the campaigns.
    """
    changed = tuple(item.stat().st_mtime_ns for item in (task, *(one / TRIALS for one in folders)))
    return _read(task, tuple(settings.items()), tuple(folders), changed)


@lru_cache(maxsize=4)
def _read(
    task: Path, settings: tuple[tuple[str, str], ...], folders: tuple[Path, ...], changed: tuple[int, ...]
) -> WalkedTrials:
    read = load_task(task, dict(settings))
    return WalkedTrials(read, LearnedOdds(read, Learned.read(read, folders).seen))
