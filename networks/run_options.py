"""How a task is run: all that may be chosen beside the task itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from handcart.backends.backend import Backend
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.operator.permits import Permits

from .run_observer import RunObserver


@dataclass(frozen=True)
class RunOptions:
    """What is left out is as `handcart run` has it by default."""

    backend: str | None = None
    """Another one than the task names."""
    settings: Mapping[str, str] = field(default_factory=dict)
    """Parameters of the task, values unparsed."""
    seed: int = 0
    """Of the simulated errors."""
    situation: str | None = None
    """Where the run begins, instead of the task's start."""
    errors: bool = True
    """Whether the simulated robot errs."""
    bench: str | None = None
    """Simulated drives are put before the simulated backend of that name."""
    window: bool = False
    """Whether robot and world are shown."""
    video: Path | None = None
    """Where the run is recorded, as MP4."""
    draw: bool = False
    """Whether `overview.svg` is drawn."""
    report: bool = False
    """Whether `report.html` is written."""
    playback: bool = False
    """Whether what `handcart view` and `handcart export` show is recorded."""
    checkpoints: bool = False
    """Whether `handcart resume` can go on with it in a simulated world: that is kept after each action."""
    sync: bool | None = None
    """Whether the journal is brought to the disk; None: as the backend needs it."""
    permits: Permits | None = None
    """Who permits actions that need it; None: nobody is asked, so only a simulated robot may start them."""
    interrupts: Interrupts | None = None
    """Who hears of Ctrl-C; None: somebody of its own, until the folder is whole."""
    around: Callable[[Backend], Backend] | None = None
    """Puts another backend around a simulated one: faults, say."""
    observers: tuple[RunObserver, ...] = ()
    """They hear of all that happens, in this order."""
