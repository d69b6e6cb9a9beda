"""Options of a run apart from the task itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import time
from pathlib import Path

from handcart.backends.backend import Backend
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.operator.permits import Permits


@dataclass(frozen=True)
class RunOptions:
    """Options of a run; the defaults are those of `handcart run`."""

    backend: str | None = None
    """Another backend than the task names; None: that of the task."""
    settings: Mapping[str, str] = field(default_factory=dict)
    """Parameters of the task, values unparsed."""
    seed: int = 0
    """Seed of the simulated errors."""
    situation: str | None = None
    """Situation in which the run begins; None: the task's start."""
    errors: bool = True
    """True if the simulated robot has the errors that its file states."""
    bench: str | None = None
    """Name of the simulated backend behind simulated drives; None without simulated drives."""
    window: bool = False
    """True to show robot and world in a window."""
    video: Path | None = None
    """Path of the MP4 to which the run is recorded; None: no video."""
    draw: bool = False
    """True to draw `overview.svg`."""
    report: bool = False
    """True to write `report.html`."""
    playback: bool = False
    """True to record the data for `handcart view` and `handcart export`."""
    checkpoints: bool = False
    """True to keep the simulated world after each action, so that `handcart resume` can continue the run."""
    sync: bool | None = None
    """True to bring the journal to the disk; None: as the backend needs it."""
    permits: Permits | None = None
    """Permissions for actions that need one; None: only a simulated robot may start them."""
    interrupts: Interrupts | None = None
    """Handler of Ctrl-C; None: the run uses a handler of its own until the folder is complete."""
    around: Callable[[Backend], Backend] | None = None
    """Function that wraps a simulated backend, for example to inject faults; None: it is used as it is."""
    record_sensors: bool = False
    """True to record every reading and command, so that `handcart replay --sensors` can check the run."""
    begins_at: time | None = None
    """Time of day at which a simulated run begins; None: the first one of the task's rounds or interrupts."""
    observers: tuple[RunObserver, ...] = ()
    """Observers of the run, notified in this order."""
