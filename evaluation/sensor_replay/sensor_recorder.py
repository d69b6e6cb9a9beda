"""Backend that records every reading and command that passes between a program and a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from handcart.backends.backend import Backend, CommandError, RobotFault
from handcart.backends.capabilities.capability import Capability
from handcart.backends.sensors.all_kinds import all_capabilities
from handcart.evaluation.layers.layered_backend import Kind, LayeredBackend, provided_kind

from .plain_readings import plain
from .recording_file import BLOCK_PERIODS, FORMAT_HEADER, SENSORS_FILE, write_block

WHOLE_ROBOT = -1
"""Number in place of a part's for commands to the whole robot: stop."""
READING, QUESTION, COMMAND = "reading", "question", "command"
"""Kinds of calls. A question is answered by the program's own side: the last command of the arm."""
KNOWN_ERRORS: tuple[type[Exception], ...] = (CommandError, RobotFault)
"""Exceptions that are recorded, and raised again in a replay."""


class SensorRecorder(LayeredBackend):
    """Backend that passes all calls on to another backend and records them, period by period."""

    def __init__(self, inner: Backend) -> None:
        super().__init__(inner)
        self.simulated, self.address, self.remarks = inner.simulated, inner.address, inner.remarks
        self.recording = inner.recording
        self.lost = ""
        self._parts = {id(part): number for number, part in enumerate(inner.capabilities())}
        self._period: list[list[Any]] = []
        self._periods: list[list[list[Any]]] = []
        self._taken: set[tuple[int, str]] = set()
        self._file: IO[bytes] | None = None

    def open(self, folder: Path) -> None:
        """Write all recorded calls of the backend to a run's folder from now on, including those recorded
        before.
        """
        with self._losing():
            self._file = (folder / SENSORS_FILE).open("xb")
            self._file.write(FORMAT_HEADER)
            write_block(self._file, self._head())

    def _head(self) -> dict[str, Any]:
        kinds = all_capabilities()
        parts = []
        for part in self.inner.capabilities():
            kind = next((class_ for class_ in kinds if isinstance(part, class_)), None)
            name = provided_kind(part, kind).__name__ if kind else ""
            parts.append([name, part.sensor_name, _properties(part, kind)])
        return {"name": self.name, "period_s": self.period, "parts": parts}

    @override
    def pass_on(self, part: Capability, kind: Kind, method: str, *words: Any) -> Any:
        number = self._parts[id(part)]
        if method not in kind.READINGS:
            what = COMMAND if method in kind.COMMANDS else QUESTION
            return self._passed(what, number, method, lambda: getattr(part, method)(*words), words)
        if (number, method) in self._taken:
            return getattr(part, method)()
        self._taken.add((number, method))
        return self._passed(READING, number, method, getattr(part, method), ())

    def _passed(
        self, what: str, number: int, method: str, call: Callable[[], Any], words: tuple[Any, ...]
    ) -> Any:
        entry = [what, number, method, [_copy(plain(word)) for word in words]]
        try:
            result = call()
        except KNOWN_ERRORS as error:
            self._period.append([*entry, None, [type(error).__name__, str(error)]])
            raise
        self._period.append([*entry, None if what == COMMAND else _copy(plain(result)), None])
        return result

    @override
    def step(self) -> None:
        self._end_period()
        self.inner.step()

    @override
    def stop(self) -> None:
        self._passed(COMMAND, WHOLE_ROBOT, "stop", self.inner.stop, ())

    @override
    def close(self) -> None:
        self._end_period()
        self._write()
        if self._file is not None:
            self._file.close()
            self._file = None
        self.inner.close()

    def _end_period(self) -> None:
        self._periods.append(self._period)
        self._period, self._taken = [], set()
        if self._file is not None and len(self._periods) >= BLOCK_PERIODS:
            self._write()

    def _write(self) -> None:
        if self._file is None:
            return
        if not self.lost:
            with self._losing():
                write_block(self._file, self._periods)
        self._periods = []

    @contextmanager
    def _losing(self) -> Iterator[None]:
        """Return a context in which a failed write, such as on a full disk, ends the recording."""
        try:
            yield
        except OSError as error:
            self.lost = str(error.strerror)

    @override
    def state(self) -> object | None:
        return self.inner.state()

    @override
    def set_state(self, state: object) -> None:
        self.inner.set_state(state)

    @override
    def figures(self) -> Mapping[str, Any]:
        lost = {"sensors_lost": self.lost} if self.lost else {}
        return {**self.inner.figures(), **lost}

    @override
    def view(self) -> NDArray[np.uint8] | None:
        return self.inner.view()


def _copy(value: Any) -> Any:
    """Return plain data with copies of its arrays, so that later changes do not affect it."""
    if isinstance(value, list):
        return [_copy(item) for item in value]
    return value.copy() if isinstance(value, np.ndarray) else value


def _properties(part: Capability, kind: Kind | None) -> dict[str, Any]:
    """Return the properties of a capability, such as a camera's model, as far as it has values for them."""
    found = {}
    for name in dir(kind) if kind else ():
        if not name.startswith("_") and isinstance(getattr(kind, name), property):
            try:
                found[name] = plain(getattr(part, name))
            except ValueError:  # such as the hand's pose of a camera that is elsewhere
                continue
    return found
