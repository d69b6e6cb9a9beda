"""Checksums of the files that a campaign depends on."""

from __future__ import annotations

import hashlib
import os
import posixpath
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from handcart.evaluation.campaigns.data.campaign_folder import TRIALS
from handcart.files.errors import InputError
from handcart.files.regular_file import open_regular
from handcart.files.yaml.yaml_document import read_document
from handcart.files.yaml.yaml_node import Node
from handcart.networks.runs.run_header import robot_fingerprint
from handcart.networks.task.task_file import Task
from handcart.networks.task.task_model import MAX_TASK_BYTES, MAX_TASK_NODES

from .campaign_setting import CampaignSetting

_YAML = (".yaml", ".yml")


def checksums(setting: CampaignSetting, task: Task) -> dict[str, str]:
    """Return the SHA-256 of each file that a campaign depends on, by its name as seen from the task.

    These are the task's file, all files that it names, directly or through other files, and the file of
    faults. Trials that run the robot also depend on its description; trials that are random walks depend on
    the trials from which their probabilities are learned.

    Raises:
        FileError: the robot's file is invalid.
    """
    files, path = _Files(), Path(task.document.file)
    files.add(path.name, path, _words(task.document.root))
    if setting.faults is not None:
        files.add(f"--faults {setting.faults.name}", setting.faults, ())
    sums = files.sums
    if setting.walks:
        for number, folder in enumerate(setting.learned_from, start=1):
            with open_regular(folder / TRIALS) as file:
                learned = file.read()
            sums[f"trials learned from, {number}"] = hashlib.sha256(learned).hexdigest()
        return sums
    from handcart.backends.loading.robot_loading import load_robot

    return {**sums, "the robot": robot_fingerprint(load_robot(task.robot, drives=False))}


class _Word(NamedTuple):
    """Text that may be the name of a file."""

    text: str
    given: bool
    """True for a word of the command line, which is relative to the current folder."""


class _Files:
    """Set of files that are named by other files."""

    def __init__(self) -> None:
        self.sums: dict[str, str] = {}
        self._known: set[Path] = set()

    def add(self, name: str, path: Path, words: Iterable[_Word]) -> None:
        """Add a file, and the files that it names."""
        self._known.add(path.resolve())
        self.sums[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        for text, given in words:
            other = Path(text) if given else path.parent / text
            # A text of any length may look like a name: `isfile` says no where a `Path` would raise.
            if os.path.isfile(other) and other.resolve() not in self._known:
                beside = posixpath.normpath(posixpath.join(posixpath.dirname(name), text))
                self.add(f"--set {text}" if given else beside, other, _words_in(other))


def _words_in(path: Path) -> Iterator[_Word]:
    if path.suffix in _YAML:
        try:
            yield from _words(read_document(path, max_bytes=MAX_TASK_BYTES, max_nodes=MAX_TASK_NODES).root)
        except InputError:
            return  # the reader of that file reports its errors


def _words(node: Node) -> Iterator[_Word]:
    """Yield all words in a file that may be the name of a file."""
    content = node.content
    if isinstance(content, dict):
        for item in content.values():
            yield from _words(item)
    elif isinstance(content, list):
        for item in content:
            yield from _words(item)
    elif isinstance(content, str) and "." in content and len(content) < 1000 and "\n" not in content:
        yield _Word(content, node.line == 0)
