"""Campaigns: one task, many seeds."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable
from contextlib import closing
from functools import partial

from handcart.networks.coordination.interrupts import Interrupts

from .campaign_setting import CampaignSetting
from .trial import Trial
from .trial_log import TrialLog
from .trial_run import run_trial
from .workers import TOGETHER_S, Workers


def run_campaign(
    setting: CampaignSetting, seeds: Iterable[int], jobs: int, log: TrialLog | None = None
) -> Generator[Trial, None, None]:
    """Run the trials, each handed out when it has ended, and is in the log.

    A trial that was cancelled by itself is left out. An interrupt (Ctrl-C, SIGTERM, SIGHUP) stops the trials
    that run, and ends the campaign; a second one kills them.

    Args:
        setting: what they have in common.
        seeds: of each one; those that are in the log are left out.
        jobs: how many processes; 1: this one.
        log: where they are kept.

    Raises:
        KeyboardInterrupt: there was an interrupt.
        TrialLogError: the log can't be written.
        HandcartError: a trial can't be run.
    """
    left = (seed for seed in seeds if log is None or seed not in log)
    every = _one_by_one(setting, left) if jobs == 1 else Workers(partial(_beside, setting), jobs).trials(left)
    with Interrupts(), closing(every):
        for together in every:
            done = [each for each in together if not each.cancelled]
            if log is not None:
                log.append(done)
            yield from done
            if any(each.interrupted for each in together):
                raise KeyboardInterrupt


def _one_by_one(setting: CampaignSetting, seeds: Iterable[int]) -> Generator[list[Trial], None, None]:
    done: list[Trial] = []
    handed = time.monotonic()
    for seed in seeds:
        try:
            trial = run_trial(setting, seed)
        except KeyboardInterrupt:
            yield done
            raise
        done.append(trial)
        if trial.interrupted or time.monotonic() - handed > TOGETHER_S:
            yield done
            done, handed = [], time.monotonic()
    if done:
        yield done


def _beside(setting: CampaignSetting, seed: int) -> Trial:
    """A trial in a process that computes beside others."""
    if setting.level == "run":
        import cv2

        cv2.setNumThreads(1)
    return run_trial(setting, seed)
