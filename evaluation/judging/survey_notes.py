"""Notes of a survey, kept in the run's folder."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import orjson
from pydantic import TypeAdapter, ValidationError

from handcart.backends.saved_state import NotAState
from handcart.files.whole_file import write_whole
from handcart.networks.journal.journal_record import MAX_JOURNAL
from handcart.networks.run_files.run_folder import read_file

T = TypeVar("T")


class SurveyNotes:
    """File of what surveys (observers that evaluate a run) have noted, from which a resumed run continues.

    Each line holds the observations noted at one time. If writing fails, for example on a full disk, the line
    is missing, but the run goes on.
    """

    def __init__(self, folder: Path, name: str) -> None:
        """Use a file in a run's folder; the file need not exist."""
        self._path = folder / name

    def until(self, time_s: float) -> list[dict[str, Any]]:
        """Return the observations noted up to a time in [s], oldest first; delete later ones from the file.

        The run is continued at this time, so it makes the later observations again.

        Raises:
            NoRun: the file is not readable, or is larger than a run makes it.
        """
        content = read_file(self._path.parent, self._path.name, MAX_JOURNAL, missing=True)
        if content is None:
            return []
        kept = []
        for line in content.splitlines():
            with suppress(orjson.JSONDecodeError):  # a crash may have truncated the last line
                note = orjson.loads(line)
                if isinstance(note, dict) and isinstance(note.get("time_s"), float | int):
                    kept += [note] if note["time_s"] <= time_s + 1e-9 else []
        write_whole(self._path, b"".join(map(_line, kept)))
        return kept

    def checked(self, note: object, kind: type[T]) -> T:
        """Return an observation that a survey noted in the file, converted to the type `kind`.

        Raises:
            NotAState: the observation is not of this type.
        """
        try:
            return as_noted(note, kind)
        except ValueError as error:
            raise NotAState(f"{self._path}: {error}") from None

    def add(self, time_s: float, note: Mapping[str, Any]) -> None:
        """Append the observations that the surveys (observers of a run) saved to the file, with the run's
        time in [s].
        """
        with suppress(OSError), self._path.open("ab") as file:
            file.write(_line({"time_s": time_s, **note}))


def _line(note: Mapping[str, Any]) -> bytes:
    return orjson.dumps(note, default=lambda array: array.tolist(), option=orjson.OPT_APPEND_NEWLINE)


def as_noted(read: object, kind: type[T]) -> T:
    """Return a value read from a JSON file as a value of type `kind`.

    Raises:
        ValueError: the value does not have this type; the message names the element and its fault.
    """
    try:
        return TypeAdapter(kind).validate_json(orjson.dumps(read), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        at = ".".join(map(str, first["loc"]))
        raise ValueError(f"no such notes: {at}{at and ': '}{first['msg']}") from None
