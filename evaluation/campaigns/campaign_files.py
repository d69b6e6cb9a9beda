"""The files that a campaign depends on, by their content."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from handcart.files.errors import InputError
from handcart.files.yaml.yaml_document import read_document
from handcart.networks.journal.run_header import robot_fingerprint
from handcart.networks.task.task_file import Task

from .campaign_folder import TRIALS
from .campaign_setting import CampaignSetting

_YAML = (".yaml", ".yml")


def checksums(setting: CampaignSetting, task: Task) -> dict[str, str]:
    """SHA-256 of the task's file and of those that it names, and they in turn, by their names; and of the
    robot's description, where there is a robot.

    Raises:
        FileError: the robot's file is wrong.
    """
    found: dict[Path, str] = {}
    _add(found, Path(task.document.file), _values(task.document.data))
    if setting.faults is not None:
        _add(found, setting.faults, iter(()))
    sums = {path.name: digest for path, digest in sorted(found.items(), reverse=True)}
    if setting.walks:
        for number, folder in enumerate(setting.learned_from, start=1):
            learned = (folder / TRIALS).read_bytes()
            sums[f"trials learned from, {number}"] = hashlib.sha256(learned).hexdigest()
        return sums
    from handcart.backends.description.robot_loading import load_robot

    return {**sums, "the robot": robot_fingerprint(load_robot(task.robot, drives=False))}


def _add(found: dict[Path, str], path: Path, named: Iterator[str]) -> None:
    found[path.resolve()] = hashlib.sha256(path.read_bytes()).hexdigest()
    for name in named:
        for start in (path.parent, Path()):
            other = (start / name).resolve()
            if other not in found and other.is_file():
                _add(found, other, _named(other))


def _named(path: Path) -> Iterator[str]:
    if path.suffix in _YAML:
        try:
            yield from _values(read_document(path).data)
        except InputError:
            return  # who reads it tells what is wrong with it


def _values(data: Any) -> Iterator[str]:
    """All words in a file that may be a file's name."""
    if isinstance(data, dict):
        for each in data.values():
            yield from _values(each)
    elif isinstance(data, list):
        for each in data:
            yield from _values(each)
    elif isinstance(data, str) and "." in data and len(data) < 1000 and "\n" not in data:
        yield data
