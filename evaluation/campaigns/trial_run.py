"""Run of one trial of a campaign."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.files.yaml.yaml_document import changed_numbers
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.task_file import load_task

from .campaign_setting import CampaignSetting

if TYPE_CHECKING:
    from handcart.evaluation.campaigns.data.walked_trials import WalkedTrials
    from handcart.evaluation.campaigns.rare.rare_event import RareEvent


def run_trial(setting: CampaignSetting, seed: int) -> Trial:
    """Execute one trial of a campaign, and return its result.

    Depending on the setting, the trial is a run of the robot or a random walk through the network of actions.
    """
    if setting.varied is None:
        return _trial(setting, seed)
    row = setting.varied.row(seed, setting.seeds)
    task = load_task(setting.task, setting.settings)
    with changed_numbers(setting.varied.changes(row, task)):
        return replace(_trial(setting, seed), varied=row)


def run_beside(setting: CampaignSetting, seed: int) -> Trial:
    """Execute one trial in one of several parallel processes, with only one thread for OpenCV."""
    if setting.level == "run":
        import cv2

        cv2.setNumThreads(1)
    return run_trial(setting, seed)


def _trial(setting: CampaignSetting, seed: int) -> Trial:
    chosen = dict(setting.settings or {})
    if setting.rare is not None:
        return _population(setting, setting.rare, seed)
    if setting.walks:
        return walked_trials(setting).trial(seed)
    if setting.world is None:
        return _run(setting, chosen, seed)
    with tempfile.TemporaryDirectory() as folder:
        named = setting.world(seed, Path(folder))
        return _run(setting, {**named, **chosen}, seed)


def _population(setting: CampaignSetting, event: RareEvent, seed: int) -> Trial:
    from handcart.evaluation.campaigns.rare.rare_trial import run_population, stopped, walked_population

    if setting.walks:
        return walked_population(walked_trials(setting), event, seed)
    with Interrupts() as heard:
        options = RunOptions(setting.backend, dict(setting.settings or {}), interrupts=heard)
        try:
            return run_population(setting.task, setting.runs, options, event, seed)
        except KeyboardInterrupt:
            return stopped(seed)


def walked_trials(setting: CampaignSetting) -> WalkedTrials:
    """Return the random walks through a network of actions that serve as the trials of a campaign.

    Raises:
        FileError: the task's file is invalid, or lacks probabilities.
        InputError: the campaigns to learn from do not cover the task.
    """
    chosen = dict(setting.settings or {})
    if setting.level == "fitted":
        from handcart.evaluation.campaigns.learned.learned import learned_trials

        return learned_trials(setting.task, chosen, setting.learned_from)
    from handcart.evaluation.campaigns.data.walked_trials import WalkedTrials, network_trials
    from handcart.evaluation.campaigns.walks.file_odds import FileOdds

    if setting.varied is None:
        return network_trials(setting.task, chosen)
    task = load_task(setting.task, chosen)
    return WalkedTrials(task, FileOdds(task), side_by_side=1)


def _run(setting: CampaignSetting, settings: Mapping[str, str], seed: int) -> Trial:
    from handcart.evaluation.campaigns.data.action_ends import ActionEnds
    from handcart.evaluation.trials.running import run_task

    ends = ActionEnds()
    with Interrupts() as heard:
        options = RunOptions(setting.backend, settings, seed, interrupts=heard, observers=(ends,))
        if setting.faults is None:
            summary, status = run_task(setting.task, setting.runs, options)
            return Trial(seed, status, summary, ends.ends, heard.came)
        from .fault_plan import InjectedFaults, load_faults

        faults = InjectedFaults(load_faults(setting.faults), seed)
        options = replace(options, observers=(ends, faults), around=faults.around)
        summary, status = run_task(setting.task, setting.runs, options)
    return Trial(seed, status, summary, ends.ends, heard.came, faults=faults.injected)
