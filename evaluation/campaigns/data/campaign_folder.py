"""Folder of a campaign: `campaign.json` (arguments), `trials.jsonl` (ended trials) and `runs`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orjson

from handcart.files.errors import InputError
from handcart.files.printable import printable
from handcart.files.regular_file import open_regular
from handcart.files.whole_file import write_whole

from .trial_log import TrialFile, TrialLog, read_offsets

CAMPAIGN_FORMAT = "handcart-campaign/1"
TRIALS, ARGUMENTS, RUNS = "trials.jsonl", "campaign.json", "runs"
_MOST = 16 * 2**20
Arguments = Mapping[str, Any]
"""Arguments that decide how trials end, ready for JSON; shards of a campaign differ only in `shard`."""
_NAMES_ALONE = (
    "format",
    "task",
    "vary_file",
    "faults",
    "learned_from",
)  # where they lie says nothing; their content does


class NoCampaign(InputError):
    """Error for a folder without a campaign that can be read or continued."""

    def __init__(self, folder: Path, wrong: str) -> None:
        words = f"{folder}: {wrong}; allowed: the folder of a campaign, made by handcart campaign --out"
        super().__init__(printable(words))


class OtherCampaign(InputError):
    """Error for a folder that belongs to a campaign with other arguments."""

    def __init__(self, folder: Path, different: list[str]) -> None:
        listed = "".join(f"\n  {text}" for text in different)
        words = f"{folder} holds another campaign:{listed}\nallowed: the same arguments, or another folder"
        super().__init__("\n".join(map(printable, words.split("\n"))))


@dataclass(frozen=True)
class CampaignFolder:
    """Folder with arguments, trials and runs of a campaign, or of a shard (one part of a campaign)."""

    folder: Path
    arguments: Arguments

    @classmethod
    def made(cls, folder: Path, arguments: Arguments) -> CampaignFolder:
        """Create a campaign's folder, or open the existing folder of the same campaign.

        Raises:
            NoCampaign: the folder holds other files, or it cannot be created.
            OtherCampaign: the folder belongs to a campaign with other arguments.
        """
        asked: Arguments = orjson.loads(orjson.dumps({"format": CAMPAIGN_FORMAT, **arguments}))
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if (folder / ARGUMENTS).exists():
                there = cls.read(folder).arguments
                if different := differences(there, asked):
                    raise OtherCampaign(folder, different)
                return cls(folder, there)
            if any(not path.name.startswith(".") for path in folder.iterdir()):
                raise NoCampaign(folder, "the folder holds other files")
            write_whole(folder / ARGUMENTS, orjson.dumps(asked, option=orjson.OPT_INDENT_2))
        except OSError as error:
            raise NoCampaign(folder, f"can't be written: {error.strerror}") from None
        return cls(folder, asked)

    @classmethod
    def read(cls, folder: Path) -> CampaignFolder:
        """Open an existing campaign folder.

        Raises:
            NoCampaign: the folder holds no campaign.
        """
        path = folder / ARGUMENTS
        try:
            with open_regular(path) as file:
                arguments = orjson.loads(file.read(_MOST))
        except FileNotFoundError:
            raise NoCampaign(folder, f"there is no {ARGUMENTS} in it") from None
        except (OSError, orjson.JSONDecodeError) as error:
            raise NoCampaign(folder, f"{ARGUMENTS} in it can't be read: {error}") from None
        if not isinstance(arguments, dict) or arguments.get("format") != CAMPAIGN_FORMAT:
            raise NoCampaign(folder, f"{ARGUMENTS} in it is not of the format {CAMPAIGN_FORMAT}")
        return cls(folder, arguments)

    @classmethod
    def read_runs(cls, folder: Path) -> CampaignFolder:
        """Open the folder of a campaign that runs its task, not of one that estimates a rare outcome.

        The task may be run in simulation, or only by its network's probabilities (a random walk).

        Raises:
            NoCampaign: the folder holds no campaign, or one that estimates a rare outcome.
        """
        found = cls.read(folder)
        if found.arguments.get("rare"):
            raise NoCampaign(folder, "its trials are populations that were asked for a rare end")
        return found

    @property
    def runs(self) -> Path:
        """Folder that holds one folder for each run of the campaign."""
        return self.folder / RUNS

    def log(self) -> TrialLog:
        """Open the log of trials for appending.

        Raises:
            CampaignAlive: another process writes the log.
            TrialLogError: the log cannot be opened, or a line is damaged.
        """
        return TrialLog(self.folder / TRIALS)

    def trials(self) -> TrialFile:
        """Return the trials that have ended so far, read-only.

        Raises:
            TrialLogError: a line is damaged.
        """
        path = self.folder / TRIALS
        if not path.exists():
            return TrialFile(path, ())
        found = read_offsets(path)
        return TrialFile(path, found.by_seed.items(), found.skipped_bytes)


def differences(there: Arguments, asked: Arguments, but: tuple[str, ...] = ()) -> list[str]:
    """Describe the differences between the arguments of two campaigns, one text for each.

    Args:
        there: arguments in a campaign's folder.
        asked: arguments that were requested now.
        but: keys to ignore.
    """
    words = []
    for key in dict.fromkeys([*there, *asked]):
        mine, given = there.get(key), asked.get(key)
        if mine == given or key in (*_NAMES_ALONE, *but):
            continue
        if isinstance(mine, dict) and isinstance(given, dict):
            names = [name for name in dict.fromkeys([*mine, *given]) if mine.get(name) != given.get(name)]
            if key == "files":
                words += [f"{name} has another content" for name in names]
            else:
                words += [
                    f"{key} {name}: {_said(mine, name)} there, {_said(given, name)} now" for name in names
                ]
        else:
            words.append(f"{key}: {_said(there, key)} there, {_said(asked, key)} now")
    return words


def _said(arguments: Arguments, key: str) -> str:
    value = arguments.get(key)
    return (
        "nothing"
        if value is None
        else orjson.dumps(value).decode()
        if isinstance(value, list)
        else str(value)
    )
