"""Numbers in a task's files that vary from trial to trial of a campaign."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from random import Random
from typing import Annotated, Literal

from pydantic import Field, model_validator

from handcart.backends.description.robot_names import robot_path
from handcart.files.errors import FileError
from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import Changes, Document, read_document
from handcart.files.yaml.yaml_node import KeyPath, Node
from handcart.networks.task.task_file import Task
from handcart.networks.task.task_model import MAX_TASK_BYTES, MAX_TASK_NODES
from handcart.robotics.numerics.arrays import FloatArray

Pair = Annotated[list[float], Field(min_length=2, max_length=2)]


class Grid(FileModel):
    """Evenly spaced values of a parameter that a campaign varies, from a lower limit to an upper one,
    including both.
    """

    least: float
    most: float
    count: Annotated[int, Field(ge=2, le=10_000)]


class Varied(FileModel):
    """Number in a file that varies from trial to trial.

    One of `list`, `grid`, `uniform`, `log_uniform` and `normal` gives its values.
    """

    file: Literal["task", "robot", "world"]
    key: str
    """Path of the number in its file: keys, and indices of list items from 0, joined by dots:
    `actions.0.cost_s`.
    """
    list: Annotated[Sequence[int | float], Field(min_length=1)] | None = None
    grid: Grid | None = None
    uniform: Pair | None = None
    """Smallest and largest value."""
    log_uniform: Pair | None = None
    """Smallest and largest value, uniform in the logarithm."""
    normal: Pair | None = None
    """Mean and standard deviation."""

    @model_validator(mode="after")
    def _whole(self) -> Varied:
        given = (self.list, self.grid, self.uniform, self.log_uniform, self.normal)
        if sum(item is not None for item in given) != 1:
            raise ValueError("which values? needed: one of list, grid, uniform, log_uniform, normal")
        for pair in (self.uniform, self.log_uniform):
            if pair is not None and pair[0] >= pair[1]:
                raise ValueError("the least isn't below the most")
        if self.log_uniform is not None and self.log_uniform[0] <= 0.0:
            raise ValueError("log_uniform: the least isn't above 0")
        if self.normal is not None and self.normal[1] <= 0.0:
            raise ValueError("normal: the standard deviation isn't above 0")
        return self

    @property
    def name(self) -> str:
        """Name of the varied number in reports, from its file and key, such as `robot errors.slip`."""
        return f"{self.file} {self.key}"

    @property
    def path(self) -> KeyPath:
        """Keys and indices that lead from the top of the file to the varied number."""
        return tuple(int(step) if step.isdecimal() else step for step in self.key.split("."))

    def values(self) -> Sequence[float] | None:
        """All values that the list or grid gives to the varied number; None if a distribution gives them."""
        if self.grid is not None:
            step = (self.grid.most - self.grid.least) / (self.grid.count - 1)
            return [self.grid.least + number * step for number in range(self.grid.count)]
        return self.list

    def at(self, share: float) -> float:
        """Return the varied number's value at a quantile of its distribution, or from its list or grid.

        Args:
            share: quantile, or position in the list or grid, from 0 to below 1.
        """
        values = self.values()
        if values is not None:
            return values[int(share * len(values))]
        if self.uniform is not None:
            return self.uniform[0] + share * (self.uniform[1] - self.uniform[0])
        if self.log_uniform is not None:
            low, high = map(math.log, self.log_uniform)
            return math.exp(low + share * (high - low))
        from scipy.special import ndtri

        assert self.normal is not None
        return self.normal[0] + self.normal[1] * float(ndtri(min(max(share, 1e-12), 1.0 - 1e-12)))


class Variation(FileModel):
    """Content of a variations file, with the numbers that vary between trials and how values are chosen."""

    format: Literal["handcart-vary/1"]
    design: Literal["grid", "random", "latin_hypercube"] = "random"
    """Design of experiments: `grid` takes all combinations in order; `random` draws by the trial's seed;
    `latin_hypercube` divides the values of each number into as many equal shares as there are trials, and
    uses each share once.
    """
    vary: Annotated[list[Varied], Field(min_length=1)]

    @model_validator(mode="after")
    def _whole(self) -> Variation:
        endless = [item.name for item in self.vary if item.values() is None]
        if self.design == "grid" and endless:
            raise ValueError(f"a grid of a distribution ({endless[0]}); allowed: list, grid")
        return self

    def row(self, seed: int, seeds: range) -> Mapping[str, float]:
        """Return the values that the varied numbers have in one trial, by the numbers' names.

        Args:
            seed: seed of the trial, one of `seeds`.
            seeds: seeds of all trials of the campaign, also of those that other machines run.
        """
        if self.design == "grid":
            every = [item.values() or () for item in self.vary]
            at, combined = seed % math.prod(map(len, every)), []
            for values in reversed(every):
                at, step = divmod(at, len(values))
                combined.append(values[step])
            return self._named(combined[::-1])
        if self.design == "random":
            return self._at(self._drawn(seed))
        shares = _hypercube(len(self.vary), len(seeds), seeds.start)
        return self._at(shares[seeds.index(seed)].tolist())

    def _drawn(self, seed: int) -> list[float]:
        return [Random(f"{seed} varied {item.name}").random() for item in self.vary]

    def _at(self, shares: Sequence[float]) -> Mapping[str, float]:
        return self._named([item.at(share) for item, share in zip(self.vary, shares, strict=True)])

    def _named(self, values: Sequence[float]) -> Mapping[str, float]:
        return {item.name: value for item, value in zip(self.vary, values, strict=True)}

    def changes(self, row: Mapping[str, float], task: Task) -> Changes:
        """Return the values to replace in the files of a task, by file and key.

        Args:
            row: values of the varied numbers in a trial, by the numbers' names.
            task: the task.
        """
        changed: dict[Path, dict[KeyPath, float]] = {}
        for item in self.vary:
            changed.setdefault(file_of(item.file, task).resolve(), {})[item.path] = row[item.name]
        return changed


@lru_cache(maxsize=4)
def _hypercube(numbers: int, trials: int, seed: int) -> FloatArray:
    from scipy.stats.qmc import LatinHypercube

    shares: FloatArray = LatinHypercube(numbers, rng=seed).random(trials)
    return shares


def file_of(name: str, task: Task) -> Path:
    """Return the path of a file in which a campaign may vary numbers from trial to trial.

    Args:
        name: `task`, `robot` or `world`; a task that names no file of a world contains the world itself.
        task: the task.
    """
    files = {
        "task": Path(task.document.file),
        "robot": robot_path(task.robot),
        "world": task.path("world"),
    }
    return files[name] or Path(task.document.file)


def load_variation(path: Path, task: Task | None = None) -> Variation:
    """Load a file that states which numbers of a task's files vary between trials.

    Args:
        path: path of the file.
        task: task whose files must contain the varied numbers; None if that was checked already.

    Raises:
        FileError: the file is invalid, or names a key that is not a number in the task's files.
    """
    read = load(path, Variation)
    if task is None:
        return read
    document = read_document(path, max_bytes=MAX_TASK_BYTES, max_nodes=MAX_TASK_NODES)
    wrong = []
    for number, item in enumerate(read.vary):
        other = read_document(file_of(item.file, task))
        fault = _fault(item, other)
        if fault:
            wrong.append(document.finding(("vary", number, "key"), fault))
    if wrong:
        raise FileError(wrong)
    return read


def _fault(varied: Varied, other: Document) -> str:
    node, there = other.root.deepest(varied.path)
    if there and isinstance(node.content, int | float) and not isinstance(node.content, bool):
        return ""
    if there:
        return f"{other.file}:{node.line}: {varied.key} is no number; allowed: one that is given in the file"
    known = _keys(node)
    return f"{other.file} has no number {varied.key}{suggest(varied.key.split('.')[-1], known)}"


def _keys(node: Node) -> list[str]:
    if isinstance(node.content, dict):
        return list(node.content)
    return [str(at) for at in range(len(node.content))] if isinstance(node.content, list) else []
