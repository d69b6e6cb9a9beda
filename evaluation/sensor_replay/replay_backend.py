"""Backend that gives recorded readings, and expects the recorded commands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.saved_state import pack
from handcart.backends.sensors.all_kinds import all_capabilities
from handcart.evaluation.layers.layered_backend import EXTENDED_KINDS, Kind, layered_kind

from .plain_readings import plain, result_type, typed
from .recording_file import NoRecording, read_blocks
from .sensor_recorder import COMMAND, KNOWN_ERRORS, READING, WHOLE_ROBOT

Call = list[Any]
"""A recorded call, as kind of call, number of the capability, method, arguments, result and exception."""
ERRORS_BY_NAME = {known_error.__name__: known_error for known_error in KNOWN_ERRORS}
END_OF_RECORDING = "the recording ends"


class Parted(BaseException):
    """Exception that ends a replay when it differs from the recording; no other code may handle it."""


@dataclass
class RecordedPeriod:
    """Commands, readings and answers that were recorded in one control period of a run.

    Answers are results of calls with arguments.
    """

    commands: list[Call] = field(default_factory=list)
    readings: dict[tuple[int, str], Call] = field(default_factory=dict)
    answers: dict[tuple[int, str, int, bytes], Call] = field(default_factory=dict)
    """Answers to questions, by part, method, number of commands before, and arguments."""

    @classmethod
    def of(cls, calls: list[Call]) -> RecordedPeriod:
        """Group the recorded calls of a period; raise LookupError or TypeError for damaged data."""
        found = cls()
        for call in calls:
            what, number, method, words = call[:4]
            if what == COMMAND:
                found.commands.append(call)
            elif what == READING:
                found.readings.setdefault((number, method), call)
            else:
                found.answers[number, method, len(found.commands), pack(words)] = call
        return found


class ReplayBackend(Backend):
    """Backend that replays the readings of a recorded run; it has no world and no ground truth.

    The first difference from the recorded run raises `Parted`: a different, missing or additional command,
    or a reading that was not recorded.

    Attributes:
        periods: number of periods that have ended.
        commands: number of commands that equal the recorded ones, to the last bit.
        readings: number of readings that were returned.
        difference: first difference as text; empty without one.
    """

    simulated = True

    def __init__(self, folder: Path) -> None:
        """Open a run's recording; raises `NoRecording` without one."""
        self._folder = folder
        self._blocks = read_blocks(folder)
        self.periods = self.commands = self.readings = 0
        self.difference = ""
        head: Any = next(self._blocks, None)
        try:
            self.name, self.period = str(head["name"]), float(head["period_s"])
            self._parts = tuple(self._part(number, *row) for number, row in enumerate(head["parts"]))
        except (LookupError, TypeError, ValueError) as error:
            raise NoRecording(folder, f"its head makes no sense ({error})") from None
        self._names = [f"{kind or 'part'}{f' {name}' if name else ''}" for kind, name, _ in head["parts"]]
        self._following = self._read_periods()
        first = next(self._following, None)
        if first is None:
            raise NoRecording(folder, "it holds no whole block of periods")
        self._now, self._done = first, 0

    def _part(self, number: int, kind_name: str, sensor_name: str, properties: dict[str, Any]) -> Capability:
        every: tuple[Kind, ...] = (*all_capabilities(), *EXTENDED_KINDS)
        provided = next((kind_ for kind_ in every if kind_.__name__ == kind_name), None)
        if provided is None:
            raise NoRecording(self._folder, f"no kind of part is called {kind_name!r}")
        kind = next(capability for capability in all_capabilities() if issubclass(provided, capability))
        known = {name: typed(value, result_type(kind, name)) for name, value in properties.items()}
        inside = SimpleNamespace(number=number, sensor_name=sensor_name, **known)
        made: Capability = layered_kind(kind, provided)(self, inside)
        return made

    def _read_periods(self) -> Iterator[RecordedPeriod]:
        for block in self._blocks:
            try:
                yield from map(RecordedPeriod.of, block)
            except (LookupError, TypeError, ValueError) as error:
                raise NoRecording(self._folder, f"it makes no sense ({error})") from None

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> Backend:
        """Raise a TypeError, because this backend is made of a recording and never built from its name."""
        raise TypeError(f"{cls.__name__} is made of a recording")

    @override
    def capabilities(self) -> tuple[Capability, ...]:
        return self._parts

    def pass_on(self, part: Any, kind: Kind, method: str, *words: Any) -> Any:
        """Compare a call of a capability's method with the recorded run, and return its recorded result.

        Args:
            part: the capability.
            kind: kind of the capability.
            method: name of the method.
            *words: arguments of the call.
        """
        if method in kind.COMMANDS:
            self._command(part.number, method, [plain(word) for word in words])
            return None
        call = self._found(part.number, kind, method, [plain(word) for word in words])
        if call[5] is not None:
            raise ERRORS_BY_NAME.get(call[5][0], RuntimeError)(call[5][1])
        return typed(call[4], result_type(kind, method))

    def _found(self, number: int, kind: Kind, method: str, words: list[Any]) -> Call:
        if method in kind.READINGS:
            self.readings += 1
            found = self._now.readings.get((number, method))
        else:
            found = self._now.answers.get((number, method, self._done, pack(words)))
        if found is None:
            self.part_ways(f"it asks for {self._names[number]}.{method}, which the run did not")
        return found

    def _command(self, number: int, method: str, words: list[Any]) -> None:
        now = [number, method, words]
        expected = self._now.commands[self._done] if self._done < len(self._now.commands) else None
        if expected is None or pack(expected[1:4]) != pack(now):
            then = "no command" if expected is None else self._said(expected[1:4])
            self.part_ways(f"it commands {self._said(now)}; the run: {then}")
        self._done += 1
        self.commands += 1
        if expected[5] is not None:
            raise ERRORS_BY_NAME.get(expected[5][0], RuntimeError)(expected[5][1])

    def _said(self, call: list[Any]) -> str:
        number, method, words = call
        owner = "robot" if number == WHOLE_ROBOT else self._names[number]
        values = ", ".join(str(word.tolist() if hasattr(word, "tolist") else word) for word in words)
        return f"{owner}.{method}({values})"

    def part_ways(self, words: str) -> NoReturn:
        """Store the first difference from the recorded run in `difference`, and raise `Parted`."""
        self.difference = self.difference or words
        raise Parted(self.difference)

    @override
    def step(self) -> None:
        self.check_period_done()
        self._advance()
        self.periods += 1

    def check_period_done(self) -> None:
        """Raise `Parted` if the recorded run gave more commands in this period than the replay."""
        if self._done < len(self._now.commands):
            missing = self._said(self._now.commands[self._done][1:4])
            self.part_ways(f"it does not command {missing}, which the run did")

    def check_at_end(self) -> None:
        """Raise `Parted` (the replay differs from the recording) if the recorded run has more periods than
        the replay.
        """
        self.check_period_done()
        if next(self._following, None) is not None:
            self.part_ways("it is over, but the run continued")

    def _advance(self) -> None:
        found = next(self._following, None)
        if found is None:
            self.part_ways(END_OF_RECORDING)
        self._now, self._done = found, 0

    @override
    def stop(self) -> None:
        self._command(WHOLE_ROBOT, "stop", [])

    @override
    def close(self) -> None:
        return
