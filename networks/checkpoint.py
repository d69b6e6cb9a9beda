"""Where a run stands between two actions, on disk."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from backends.saved_state import NotAState, pack, unpack

from .preparing import Prepared

NAME = "checkpoint"
_FORMAT = "handcart-checkpoint/1"


@dataclass(frozen=True)
class Checkpoint:
    """World, estimates and knowledge after an action, and its result as the journal is to hold it.

    A real robot's holds what is known, and no world.
    """

    result: Mapping[str, Any]
    time_s: float
    """The robot's, in [s]."""
    backend: object
    """None of a real robot, whose world stands by itself."""
    robot: Mapping[str, Any]
    model: Mapping[str, Any]

    def put_back(self, prepared: Prepared) -> None:
        """Put a run, prepared anew from the same files and seed, where it stood; a real robot only learns."""
        if self.backend is not None:
            prepared.backend.set_state(self.backend)
            prepared.robot.set_state(self.robot)
        prepared.model.set_state(self.model)


class CheckpointKeeper:
    """Keeps the latest checkpoint of a run in its folder; before the journal has the action's RESULT.

    A GiveUp is not kept: who acknowledges it has put everything back as it was before that action.
    """

    def __init__(self, folder: Path, prepared: Prepared) -> None:
        self._path, self._prepared = folder / NAME, prepared

    def keep(self, result: Mapping[str, Any]) -> None:
        """Replace the checkpoint in one step; does nothing where a simulated world can't be kept."""
        backend = self._prepared.backend.state()
        if (backend is None and self._prepared.backend.simulated) or result["outcome"] == "GiveUp":
            return
        robot, model = self._prepared.robot, self._prepared.model
        content = {
            "format": _FORMAT,
            "result": dict(result),
            "time_s": robot.time,
            "backend": backend,
            "robot": robot.state(),
            "model": model.state(),
        }
        new = self._path.with_suffix(".new")
        new.write_bytes(pack(content))
        os.replace(new, self._path)


def load_checkpoint(folder: Path) -> Checkpoint | None:
    """The checkpoint in a run's folder; None where there is none.

    Raises:
        NotAState: it isn't one.
    """
    path = folder / NAME
    if not path.exists():
        return None
    content = unpack(path.read_bytes())
    if not isinstance(content, dict) or content.pop("format", None) != _FORMAT:
        raise NotAState(f"{path} is no checkpoint of the format {_FORMAT}")
    return Checkpoint(**content)
