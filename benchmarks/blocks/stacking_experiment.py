"""Experiments as in Hatano et al. (2000), section 5: trials of some blocks each, and their errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handcart.evaluation.campaigns.campaign import run_campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.robotics.numerics.arrays import FloatArray

TRIAL_COUNT = 20  # of an experiment
COLUMN_NAMES = ("x", "y", "processed_x", "processed_y", "yaw_mrad", "lean_mrad")


@dataclass(frozen=True)
class Experiment:
    """20 trials. `errors` is (trials, blocks, columns): NaN for a block that isn't where it should be."""

    errors: FloatArray
    sim_time: FloatArray
    """(n,) simulated times of the trials [s]."""
    frames: FloatArray
    """Pictures of each trial (n,)."""
    lost: tuple[str, ...]
    """Seed and reason of each trial that did not reach its goal."""

    @property
    def raw(self) -> FloatArray:
        """Size of each block's error, x and y together, in [mm]."""
        sizes = np.hypot(self.errors[..., 0], self.errors[..., 1])
        return np.asarray(sizes[np.isfinite(sizes)])

    @property
    def processed(self) -> FloatArray:
        """Without the effects of the base's turning and leaning; x and y each by itself, as in the paper."""
        sizes = np.abs(self.errors[..., 2:4])
        return np.asarray(sizes[np.isfinite(sizes)])


@dataclass(frozen=True)
class Experiments:
    """Several experiments of one kind, with different seeds."""

    each: tuple[Experiment, ...]

    @property
    def mean(self) -> float:
        """Return the mean of all blocks' raw errors [mm]."""
        return float(np.mean([experiment.raw.mean() for experiment in self.each]))

    def median_of_maxima(self, processed: bool = False) -> float:
        """Median over the experiments of each one's largest error, in [mm]."""
        return float(np.median([(e.processed if processed else e.raw).max() for e in self.each]))

    def growth(self) -> tuple[float, float]:
        """Return the growth of |E_x| and |E_y| per block [mm]: the slopes of lines through their means."""
        errors = np.abs(np.concatenate([e.errors[..., 0:2] for e in self.each]))
        means = np.nanmean(errors, axis=0)
        slopes = np.polyfit(np.arange(len(means)), means, 1)[0]
        return float(slopes[0]), float(slopes[1])

    @property
    def lost(self) -> list[str]:
        """All trials that didn't reach their goal."""
        return [text for experiment in self.each for text in experiment.lost]

    @property
    def sim_time(self) -> float:
        """Mean of a trial, in [s]."""
        return float(np.mean([e.sim_time.mean() for e in self.each]))

    @property
    def frames(self) -> float:
        """Mean of a trial."""
        return float(np.mean([e.frames.mean() for e in self.each]))


def run_trials(
    task: Path,
    settings: Mapping[str, str],
    seeds: Sequence[int],
    runs: Path,
    backend: str | None = None,
    jobs: int = 2,
) -> Iterator[Trial]:
    """Return the trials, each as it ends."""
    return run_campaign(CampaignSetting(task, backend, settings, None, runs), seeds, jobs)


def experiments_of(trials: Sequence[Trial], blocks: int) -> Experiments:
    """Group trials by 20 in the order of their seeds; an incomplete last group is dropped."""
    ordered = sorted(trials, key=lambda trial: trial.seed)
    size = min(TRIAL_COUNT, len(ordered))
    groups = [ordered[i : i + size] for i in range(0, len(ordered) - size + 1, size)]
    return Experiments(tuple(_experiment(group, blocks) for group in groups))


def _experiment(trials: Sequence[Trial], blocks: int) -> Experiment:
    errors = np.full((len(trials), blocks, len(COLUMN_NAMES)), np.nan)
    for i, trial in enumerate(trials):
        for block in trial.summary["metrics"].get("blocks", []):
            errors[i, int(block["number"]) - 1] = [block[name] for name in COLUMN_NAMES]
    return Experiment(
        errors,
        np.array([trial.summary["sim_time_s"] for trial in trials], dtype=float),
        np.array([trial.summary["metrics"].get("frames", 0) for trial in trials], dtype=float),
        tuple(
            f"seed {t.seed}: {t.summary['outcome']}, {t.summary['reason']}" for t in trials if not t.success
        ),
    )
