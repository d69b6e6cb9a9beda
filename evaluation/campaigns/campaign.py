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
from .trial_run import run_beside, run_trial
from .workers import TOGETHER_S, Workers


def run_campaign(
    setting: CampaignSetting,
    seeds: Iterable[int],
    jobs: int,
    log: TrialLog | None = None,
    cluster: str | None = None,
) -> Generator[Trial, None, None]:
    """Run the trials, each handed out when it has ended, and is in the log.

    A trial that was cancelled by itself is left out. An interrupt (Ctrl-C, SIGTERM, SIGHUP) stops the trials
    that run, and ends the campaign; a second one kills them.

    Args:
        setting: what they have in common.
        seeds: of each one; those that are in the log are left out.
        jobs: how many processes; 1: this one.
        log: where they are kept.
        cluster: address, or file, of a Dask scheduler whose workers run them; None: processes do.

    Raises:
        KeyboardInterrupt: there was an interrupt.
        NoCluster, ClusterLost: the scheduler doesn't answer, or no more.
        TrialLogError: the log can't be written.
        HandcartError: a trial can't be run.
    """
    left = (seed for seed in seeds if log is None or seed not in log)
    with Interrupts(), closing(_every(setting, left, jobs, cluster)) as every:
        for together in every:
            done = [each for each in together if not each.cancelled]
            if log is not None:
                log.append(done)
            yield from done
            if any(each.interrupted for each in together):
                raise KeyboardInterrupt


def _every(
    setting: CampaignSetting, seeds: Iterable[int], jobs: int, cluster: str | None
) -> Generator[list[Trial], None, None]:
    if cluster is not None:
        from .cluster import Cluster, TrialThere

        return Cluster(TrialThere.of(setting), cluster).trials(seeds)
    return (
        _one_by_one(setting, seeds)
        if jobs == 1
        else Workers(partial(run_beside, setting), jobs).trials(seeds)
    )


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
