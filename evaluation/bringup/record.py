"""What a rung of a bring-up found, as a file."""

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
    """That a rung was climbed, or tried."""

    format: Literal["handcart-bringup/1"] = "handcart-bringup/1"
    rung: str
    passed: bool
    reason: str = ""
    """Why it was not."""
    robot: str
    """As it was named."""
    fingerprint: str
    """Of what in the robot's file was tried: another one has to be tried anew."""
    bench: str
    """The simulated backend behind simulated drives; "" for a real robot."""
    when: str
    """Date and time, ISO 8601."""
    facts: Mapping[str, Any] = {}
    """What was found; the unit stands at the end of each name."""
    answers: Mapping[str, Answer] = {}
    """What a person said, by question."""


def save(record: RungRecord, path: Path) -> None:
    """Write a record; raises OSError."""
    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.default_flow_style = False
    yaml.width = 4096  # what is folded reads badly
    out = StringIO()
    yaml.dump(record.model_dump(mode="json"), out)
    write_whole(path, out.getvalue())


def read(path: Path) -> RungRecord:
    """Read a record back; raises `FileError`."""
    return load(path, RungRecord)
