"""Common setting of all trials of a campaign."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from handcart.evaluation.campaigns.rare.rare_event import RareEvent

from .variation import Variation

WorldGenerator = Callable[[int, Path], Mapping[str, str]]
"""Function that writes the files of a world for a seed into a folder, and returns the task's settings that
name them.
"""

Level = Literal["run", "fitted", "network"]
"""Kind of a trial: a run on a backend, or a walk through the network with outcomes drawn by the odds of
recorded campaigns (`fitted`) or by the file's `p` (`network`).
"""


@dataclass(frozen=True)
class CampaignSetting:
    """Settings that all trials of a campaign share; only their seeds differ."""

    task: Path
    backend: str | None = None
    settings: Mapping[str, str] | None = None
    world: WorldGenerator | None = None
    """Generator of a separate world for each trial, by its seed; None: the task's own world."""
    runs: Path = Path("runs")
    """Folder in which the runs' folders are created."""
    level: Level = "run"
    varied: Variation | None = None
    """Variation of values from trial to trial."""
    seeds: range = range(0)
    """Seeds of all trials, over all shards; variations are spread over them."""
    faults: Path | None = None
    """File of faults that are injected into each trial."""
    learned_from: tuple[Path, ...] = ()
    """Folders of the campaigns from which the odds of actions are learned."""

    rare: RareEvent | None = None
    """Rare event that each trial estimates with a population of runs; None: each trial is one run."""

    @property
    def walks(self) -> bool:
        """True if trials are random walks through the task's network of actions, without a robot."""
        return self.level != "run"
