"""The nearest of the names that would have been valid."""

import os
from collections.abc import Iterable
from difflib import get_close_matches
from itertools import islice
from pathlib import Path

MISSPELLED = 0.85
"""Similarity, 0 to 1, from which an unknown name is a misspelled one, not the name of something else."""
_SHOWN = 12
_MAX_ENTRIES = 5000  # of a folder that are looked at


def suggest(name: str, allowed: Iterable[str]) -> str:
    """Return the second half of a message about an unknown name.

    An example is `"; did you mean 'speed'? allowed: place, speed"`. The text contains the question only if an
    allowed name is similar. Allowed names are listed in the given order, at most twelve of them; without any
    allowed name, the text ends in `allowed: nothing`.

    Args:
        name: the unknown name.
        allowed: names that would have been valid.
    """
    names = list(dict.fromkeys(allowed))
    near = nearest(name, names)
    question = f"did you mean {near!r}? " if near is not None else ""
    return f"; {question}allowed: {listed(names)}"


def nearest(name: str, allowed: Iterable[str], similarity: float = 0.6) -> str | None:
    """Return the allowed name most similar to `name`, apart from upper and lower case; None if none is
    similar.

    Args:
        name: the unknown name.
        allowed: names that would have been valid.
        similarity: least ratio of `difflib`, from 0 to 1. Use the larger `MISSPELLED` for a key whose unknown
            names are valid too, so that only likely misspellings are found.
    """
    folded = {candidate.casefold(): candidate for candidate in allowed}
    # Longer names are never meant, and difflib is quadratic.
    matches = get_close_matches(name.casefold()[:100], folded, n=1, cutoff=similarity)
    return folded[matches[0]] if matches else None


def listed(names: Iterable[str]) -> str:
    """Return the names separated by commas, cut after twelve with the number of the remaining ones."""
    every = list(names)
    if not every:
        return "nothing"
    left_out = len(every) - _SHOWN
    shown = ", ".join(every[:_SHOWN])
    return f"{shown} and {left_out} more" if left_out > 0 else shown


def similar_file(path: Path) -> Path | None:
    """Return the existing regular file most similar to a missing path; None if there is none.

    The file's name may differ in letters, the names of its folders only in upper and lower case, because a
    user rarely means a file of another folder.
    """
    there = path.parent
    missing: list[str] = []
    while not there.is_dir() and there != there.parent:
        missing.insert(0, there.name)
        there = there.parent
    for name in missing:
        same = next((entry for entry in _entries(there) if entry.casefold() == name.casefold()), None)
        if same is None:
            return None
        there = there / same
    found = nearest(path.name, (entry for entry in _entries(there) if (there / entry).is_file()))
    return None if found is None else there / found


def did_you_mean(path: Path) -> str:
    """Return "did you mean ...? " for the message of a missing file; "" if no file has a similar name.

    The question shows the end of the similar file's path, from the first part that is spelled differently.
    """
    try:
        found = similar_file(path)
    except (OSError, ValueError, RuntimeError):  # a name that no file system takes, a folder that is closed
        return ""
    if found is None:
        return ""
    pairs = list(zip(path.parts[-len(found.parts) :], found.parts, strict=False))
    first = next((number for number, (asked, there) in enumerate(pairs) if asked != there), -1)
    return f"did you mean {Path(*found.parts[first:]).as_posix()!r}? "


def _entries(folder: Path) -> list[str]:
    with os.scandir(folder) as entries:
        return sorted(entry.name for entry in islice(entries, _MAX_ENTRIES))
