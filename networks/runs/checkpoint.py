"""State of a run between two actions, on disk."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handcart.backends.saved_state import MAX_BYTES, NotAState, digest, pack, unpack
from handcart.files.errors import HandcartError
from handcart.files.printable import printable
from handcart.networks.journal.journal import plain_json
from handcart.networks.journal.run_records import RECORD_VALIDATORS
from handcart.networks.run_files.run_folder import read_file
from handcart.networks.task.preparing import Prepared

CHECKPOINT_FILE = "checkpoint"
_FORMAT = "handcart-checkpoint/8"
_KEYS = {"format", "after", "result", "time_s", "backend", "robot", "model"}


class NotKeptError(HandcartError):
    """Error, because a checkpoint cannot be written. Exit status 5."""


@dataclass(frozen=True)
class Checkpoint:
    """State of a run after an action, with simulated world, robot's estimates, world model and result.

    The checkpoint of a real robot has no simulated world.
    """

    digest: str
    """Identifier of the checkpoint: the SHA-256 of its file."""
    after: str
    """Checksum of the journal's record before the action's RESULT."""
    result: Mapping[str, Any]
    time_s: float
    """The robot's time, in [s]."""
    backend: object
    """State of the simulated world; None for a real robot, whose world persists by itself."""
    robot: object
    model: object

    def put_back(self, prepared: Prepared) -> None:
        """Restore the state of a run that was prepared again from the same files and seed.

        If the robot is real, only the world model is restored.

        Raises:
            NotAState: the checkpoint belongs to another robot or world.
        """
        if self.backend is None and prepared.backend.simulated:
            raise NotAState("the checkpoint is of a real robot: it holds no world")
        if self.backend is not None:
            prepared.backend.set_state(self.backend)
            prepared.robot.set_state(self.robot)
        prepared.model.set_state(self.model)


def keep_checkpoint(
    folder: Path, prepared: Prepared, durable: bool, result: Mapping[str, Any], after: str
) -> str | None:
    """Write a checkpoint of a run into its folder, atomically, before an action's result is written to the
    journal.

    A checkpoint is not written after a GiveUp, because the person who acknowledges the GiveUp has restored
    the state before the action.

    Args:
        folder: the run's folder.
        prepared: the run.
        durable: True if the checkpoint must be on the disk before its action's result is.
        result: RESULT of the action that has ended, as the journal will contain it.
        after: checksum of the journal's last record.

    Returns:
        The checkpoint's digest, by which the journal names it; None if none is written, after a GiveUp or
        because the simulated world's state cannot be saved.

    Raises:
        NotKeptError: it cannot be written.
    """
    backend = prepared.backend.state()
    if (backend is None and prepared.backend.simulated) or result["outcome"] == "GiveUp":
        return None
    content = pack(
        {
            "format": _FORMAT,
            "after": after,
            "result": plain_json(result),
            "time_s": prepared.robot.time,
            "backend": backend,
            "robot": prepared.robot.state(),
            "model": prepared.model.state(),
        }
    )
    try:
        _replace(folder / CHECKPOINT_FILE, content, durable)
    except OSError as error:
        raise NotKeptError(
            printable(f"{folder / CHECKPOINT_FILE} can't be written: {error.strerror}")
        ) from None
    return digest(content)


def _replace(path: Path, content: bytes, durable: bool) -> None:
    new = path.with_suffix(".new")
    new.unlink(missing_ok=True)
    file = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
    with os.fdopen(file, "wb") as stream:
        stream.write(content)
        stream.flush()
        if durable:
            os.fsync(file)
    os.replace(new, path)


def load_checkpoint(folder: Path) -> Checkpoint | None:
    """Load the checkpoint from a run's folder; None if the folder has none.

    Raises:
        NotAState: the file is not a valid checkpoint.
        NoRun: it is not a readable file.
    """
    bytes_ = read_file(folder, CHECKPOINT_FILE, MAX_BYTES, missing=True)
    if bytes_ is None:
        return None
    try:
        kept = unpack(bytes_)
        if not isinstance(kept, dict) or kept.keys() != _KEYS:
            raise NotAState(f"no checkpoint of the format {_FORMAT}")
        if (written := kept.pop("format")) != _FORMAT:
            wrong = f"is of the format {str(written)[:40]!r}, which another version of handcart wrote"
            raise NotAState(f"{wrong}; allowed: {_FORMAT}, or begin a new run")
        kept["result"] = RECORD_VALIDATORS["RESULT"].validate_python(kept["result"])
    except ValueError as error:
        raise NotAState(printable(f"{folder / CHECKPOINT_FILE}: {str(error).splitlines()[0]}")) from None
    if not isinstance(kept["time_s"], float) or not isinstance(kept["after"], str):
        raise NotAState(printable(f"{folder / CHECKPOINT_FILE}: its time is not a number"))
    return Checkpoint(digest(bytes_), **kept)
