"""Running one trial of a campaign."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.run_options import RunOptions

from .campaign_setting import CampaignSetting
from .trial import Trial


def run_trial(setting: CampaignSetting, seed: int) -> Trial:
    """One seeded run, in a world of its own where the setting says so; or a walk through the network."""
    chosen = dict(setting.settings or {})
    if setting.level == "network":
        from .network_trial import network_trials

        return network_trials(setting.task, chosen).trial(seed)
    if setting.world is None:
        return _run(setting, chosen, seed)
    with tempfile.TemporaryDirectory() as folder:
        named = setting.world(seed, Path(folder))
        return _run(setting, {**named, **chosen}, seed)


def _run(setting: CampaignSetting, settings: Mapping[str, str], seed: int) -> Trial:
    from handcart.evaluation.trials.running import run_task

    from .action_ends import ActionEnds

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
    return Trial(seed, status, summary, ends.ends, heard.came, faults.injected)
