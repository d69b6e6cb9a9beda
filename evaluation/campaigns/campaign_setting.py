"""What all trials of a campaign have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from handcart.evaluation.rare.rare_event import RareEvent

from .variation import Variation

WorldGenerator = Callable[[int, Path], Mapping[str, str]]
"""Writes the files of a world, by a seed, into a folder, and gives the settings of a task that name them."""

Level = Literal["run", "fitted", "network"]
"""What a trial is: a run on a backend; or a walk through the network, outcomes drawn as recorded campaigns
show them, or by the file's `p`."""


@dataclass(frozen=True)
class CampaignSetting:
    """What each trial is told, beside its seed."""

    task: Path
    backend: str | None = None
    settings: Mapping[str, str] | None = None
    world: WorldGenerator | None = None
    """What makes each trial a world of its own, by its seed; None: the task's own."""
    runs: Path = Path("runs")
    """Where the runs' folders are made."""
    level: Level = "run"
    varied: Variation | None = None
    """What varies from trial to trial."""
    seeds: range = range(0)
    """Of all trials, in whatever parts they are run: what varies is spread over them."""
    faults: Path | None = None
    """A file of faults that come in each trial."""
    learned_from: tuple[Path, ...] = ()
    """Folders of the campaigns that show how actions end."""

    rare: RareEvent | None = None
    """What makes each trial a population of runs that shows how often runs end so; None: each is one run."""

    @property
    def walks(self) -> bool:
        """Whether no robot moves."""
        return self.level != "run"
