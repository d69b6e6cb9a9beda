"""Campaigns: one task, many seeds."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable
from contextlib import closing
from functools import partial

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.trial_log import TrialLog
from handcart.networks.coordination.interrupts import Interrupts

from .campaign_setting import CampaignSetting
from .trial_run import run_beside, run_trial
from .workers import TOGETHER_S, Workers


def run_campaign(
    setting: CampaignSetting,
    seeds: Iterable[int],
    jobs: int,
    log: TrialLog | None = None,
    cluster: str | None = None,
) -> Generator[Trial, None, None]:
    """Run trials and yield each one once it has ended and is in the log.

    A trial that a person cancelled without ending the campaign is neither logged nor yielded. An interrupt
    (Ctrl-C, SIGTERM, SIGHUP) stops the running trials and ends the campaign; a second interrupt kills them.

    Args:
        setting: common setting of all trials.
        seeds: one seed for each trial; seeds that are already in the log are skipped.
        jobs: number of processes; 1 runs the trials in this process.
        log: file of ended trials.
        cluster: address or file of a Dask scheduler whose workers run the trials; None: local processes.

    Raises:
        KeyboardInterrupt: an interrupt arrived.
        NoCluster, ClusterLost: the scheduler does not answer, or stopped answering.
        TrialLogError: the log cannot be written.
        HandcartError: a trial cannot be run.
    """
    left = (seed for seed in seeds if log is None or seed not in log)
    with Interrupts(), closing(_every(setting, left, jobs, cluster)) as every:
        for together in every:
            done = [item for item in together if not item.cancelled]
            if log is not None:
                log.append(done)
            yield from done
            if any(item.interrupted for item in together):
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
