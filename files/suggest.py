"""The nearest of the names that would have been valid."""

from collections.abc import Iterable
from difflib import get_close_matches

_SHOWN = 12


def suggest(name: str, allowed: Iterable[str]) -> str:
    """Give the second half of a message about an unknown name.

    `"; did you mean 'speed'? allowed: place, speed"`; the question only when a name is near, the
    list in the given order and cut after twelve names, `"; allowed: nothing"` when there is none.
    """
    names = list(dict.fromkeys(allowed))
    near = nearest(name, names)
    question = f"did you mean {near!r}? " if near is not None else ""
    return f"; {question}allowed: {listed(names)}"


def nearest(name: str, allowed: Iterable[str]) -> str | None:
    """The allowed name most like `name` (case apart), or None when none is like it."""
    folded = {candidate.casefold(): candidate for candidate in allowed}
    # Longer names are never meant, and difflib is quadratic.
    matches = get_close_matches(name.casefold()[:100], folded, n=1, cutoff=0.6)
    return folded[matches[0]] if matches else None


def listed(names: Iterable[str]) -> str:
    """The names separated by commas, cut after twelve with the number of those left out."""
    every = list(names)
    if not every:
        return "nothing"
    left_out = len(every) - _SHOWN
    shown = ", ".join(every[:_SHOWN])
    return f"{shown} and {left_out} more" if left_out > 0 else shown
