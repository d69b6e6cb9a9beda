"""Merge of the shards of one campaign."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from handcart.files.errors import InputError
from handcart.files.printable import printable

from .campaign_folder import CampaignFolder, differences


class NotOneCampaign(InputError):
    """Error for folders that are not the shards (parts) of one campaign."""


def merged(parts: Sequence[Path], out: Path) -> CampaignFolder:
    """Write a folder with the trials of all shards (parts of a campaign that ran separately), and return it.

    Args:
        parts: folders of one campaign, each made with another `--shard`.
        out: new folder, or one with the same content; it has links to the runs of the shards.

    Raises:
        NotOneCampaign: the shards differ in more than `--shard`, share a trial, or lack one.
        NoCampaign, OtherCampaign, TrialLogError: a folder cannot be read or written.
    """
    found = [CampaignFolder.read(part) for part in parts]
    wrong = _faults(found)
    if wrong:
        raise NotOneCampaign("\n".join(printable(item) for item in wrong))
    whole = CampaignFolder.made(out, {**found[0].arguments, "shard": None})
    with whole.log() as log:
        for item in found:
            log.append(list(item.trials()))
            _link_runs(item, whole)
    return whole


def _link_runs(part: CampaignFolder, whole: CampaignFolder) -> None:
    """Link the runs of all shards into the merged folder, where the file system allows links."""
    with suppress(OSError):
        whole.runs.mkdir(exist_ok=True)
        for trial in part.trials():
            run, link = part.runs / trial.run_name, whole.runs / trial.run_name
            if trial.run_name and run.is_dir() and not os.path.lexists(link):
                os.symlink(os.path.relpath(run, whole.runs), link)


def _faults(found: Sequence[CampaignFolder]) -> list[str]:
    first, wrong = found[0], []
    for folder in found[1:]:
        different = differences(first.arguments, folder.arguments, ("shard",))
        wrong += [f"{folder.folder} and {first.folder}: {words}" for words in different]
    if wrong:
        return [*wrong, "allowed: parts of one campaign, each with another --shard"]
    held: dict[int, Path] = {}
    for folder in found:
        seeds = {trial.seed for trial in folder.trials()}
        twice = sorted(seeds & held.keys())
        if twice:
            wrong.append(f"{folder.folder} and {held[twice[0]]} both hold the trial of seed {twice[0]}")
        held |= dict.fromkeys(seeds, folder.folder)
    asked = range(first.arguments["first"], first.arguments["first"] + first.arguments["trials"])
    missing = [seed for seed in asked if seed not in held]
    if missing:
        shards = ", ".join(str(folder.arguments["shard"]) for folder in found)
        words = f"{len(missing)} of {len(asked)} trials are in none of the folders (parts {shards})"
        wrong.append(f"{words}, the first is seed {missing[0]}; needed: all parts, each run to its end")
    return wrong
