"""Record of a bring-up step, as a file."""

from __future__ import annotations

from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from typing import Any, Literal

from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.files.whole_file import write_whole

Answer = bool | float


class RungRecord(FileModel):
    """Record of one run of a bring-up step, with result, measured values and the operator's answers."""

    format: Literal["handcart-bringup/1"] = "handcart-bringup/1"
    rung: str
    passed: bool
    reason: str = ""
    """Reason why the step did not pass; empty if it passed."""
    robot: str
    """Name of the robot as it was given."""
    fingerprint: str
    """Fingerprint of the tested part of the robot's file; after a change the step has to run again."""
    bench: str
    """The simulated backend behind simulated drives; "" for a real robot."""
    when: str
    """Date and time, ISO 8601."""
    facts: Mapping[str, Any] = {}
    """Measured values; each name ends with its unit."""
    answers: Mapping[str, Answer] = {}
    """Answers of the operator, by question."""


def save(record: RungRecord, path: Path) -> None:
    """Write the record of a bring-up step to a YAML file; raises OSError if it cannot be written."""
    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.default_flow_style = False
    yaml.width = 4096  # folded lines are hard to read
    out = StringIO()
    yaml.dump(record.model_dump(mode="json"), out)
    write_whole(path, out.getvalue())


def read(path: Path) -> RungRecord:
    """Read the record of a run of a bring-up step from its file; raises `FileError` if it is missing or
    invalid.
    """
    return load(path, RungRecord)
