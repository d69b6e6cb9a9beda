"""CAN frames around a Fail, as text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import NamedTuple

from pydantic import ValidationError

from handcart.backends.can.bus.frame_log import FRAME_NAMES_FILE
from handcart.backends.can.bus.frame_names import FrameNames
from handcart.backends.can.bus.frame_words import FrameDescription, FrameWords

from .bus_log import read_log

MAX_LINES = 40  # those nearest in time
_SILENT = 2.5  # multiples of its usual spacing after which a frame counts as missing


class FrameLine(NamedTuple):
    """CAN frame of a log, with its time and a description of its meaning."""

    time: float
    """Time of the frame on the robot's clock, in [s]."""
    cob_id: int
    description: FrameDescription


@dataclass(frozen=True)
class FramesAround:
    """CAN frames near one instant of a log, without repetitions of an unchanged state.

    It also has the last frames of those cyclic messages that stop while others continue.
    """

    file: Path
    """The log with all frames."""
    frames: int
    """Number of frames in the log."""
    lines: tuple[FrameLine, ...]
    """Frames that show a change: commands, states, errors, settings."""
    left_out: int
    """Number of further changes that are farther from the instant."""
    silent: tuple[FrameLine, ...]
    """The last frame of each cyclic message that stops while others continue."""


def frames_around(file: Path, run: Path, instant: float) -> FramesAround:
    """Read the frames around an instant from a log in a run's evidence.

    Args:
        file: log, written when the action or the run had ended.
        run: the run's folder.
        instant: time of the fault, in [s] of the log's stamps; a time after the last frame means the
            last frame.

    Raises:
        OSError, ValueError: the log, or the file of node names next to the journal, cannot be read.
    """
    try:
        names = FrameNames.model_validate_json((run / FRAME_NAMES_FILE).read_bytes())
    except ValidationError as error:
        raise ValueError(f"{run / FRAME_NAMES_FILE} is damaged: {error.error_count()} faults") from None
    frames = read_log(file)
    if not frames:
        return FramesAround(file, 0, (), 0, ())
    words = FrameWords(names)
    all_lines = [FrameLine(frame.timestamp, frame.arbitration_id, words.describe(frame)) for frame in frames]
    telling, instant = list(_changes(all_lines)), min(instant, all_lines[-1].time)
    nearest = sorted(sorted(telling, key=lambda line: abs(line.time - instant))[:MAX_LINES])
    silent = tuple(_silent(all_lines))
    return FramesAround(file, len(frames), tuple(nearest), len(telling) - len(nearest), silent)


def _changes(lines: Sequence[FrameLine]) -> Iterator[FrameLine]:
    before: dict[int, str] = {}
    for line in lines:
        state = line.description.state
        if state is None:
            yield line
            continue
        if before.setdefault(line.cob_id, state) != state:
            before[line.cob_id] = state
            yield line


def _silent(lines: Sequence[FrameLine]) -> Iterator[FrameLine]:
    """Yield the last frame of each node's TPDO or heartbeat that stops while others continue."""
    for kind in ("TPDO", "heartbeat"):
        came: dict[int, list[FrameLine]] = {}
        for line in lines:
            if line.description.state is not None and line.description.what.startswith(kind):
                came.setdefault(line.cob_id, []).append(line)
        last = max((group[-1].time for group in came.values()), default=0.0)
        for group in came.values():
            usual = median(b.time - a.time for a, b in pairwise(group)) if group[1:] else 0.0
            if usual > 0.0 and last - group[-1].time > _SILENT * usual:
                yield group[-1]


def in_words(around: FramesAround) -> Iterator[str]:
    """Yield the CAN frames around an instant as lines of text."""
    if around.left_out:
        yield f"{around.left_out} lines further away are left out"
    width = max((len(line.description.who) for line in (*around.lines, *around.silent)), default=0)
    for line in around.lines:
        yield _line(line, line.description.words, width)
    for item in around.silent:
        yield _line(item, "the last one: none came after", width)
    if not around.lines and not around.silent:
        yield "nothing but the same orders and states again and again"


def _line(line: FrameLine, words: str, width: int) -> str:
    return (
        f"{line.time:9.3f} s  {line.description.who:<{width}}  {line.description.what:<9}  {words}".rstrip()
    )
