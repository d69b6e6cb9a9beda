"""Options of `handcart check` that concern one kind of file, and are refused with another."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from handcart.files.errors import InputError

CONCERNED_FILES = {
    "--set": "a task",
    "--policy": "a task",
    "--picture": "a robot's file",
    "--allow": "a robot's file",
    "--backend": "a robot's file",
    "--draft": "a URDF",
}
"""Kind of file that each option concerns."""


def refuse_other_options(given: Iterable[str], concerned: str, file: object) -> None:
    """Raise `InputError` if an option does not concern the kind of file that is checked.

    Args:
        given: options on the command line, such as `--picture`; those that concern every file are ignored.
        concerned: kind of file that is checked, one of the values of `CONCERNED_FILES`, or another.
        file: path of the file, for the message.
    """
    wrong = [name for name in given if CONCERNED_FILES.get(name, concerned) != concerned]
    if wrong:
        each = "; ".join(f"{name} is for {CONCERNED_FILES[name]}" for name in wrong)
        allowed = (
            ", ".join(name for name, kind in CONCERNED_FILES.items() if kind == concerned) or "no such option"
        )
        raise InputError(f"{file} is {concerned}, but {each}; allowed: {allowed}")


def refuse_with_topics(given: Iterable[str]) -> None:
    """Raise `InputError` if an option that concerns a file alone is given together with `--ros2`."""
    wrong = [name for name in given if name in CONCERNED_FILES]
    if wrong:
        raise InputError(f"{', '.join(wrong)} with --ros2; allowed: --bench, --bag, --seconds")


def refuse_without_topics(options: Mapping[str, object]) -> None:
    """Raise `InputError` if an option that has an effect with `--ros2` alone is given without it.

    Args:
        options: values of these options by their names; None for one that is not given.
    """
    given = [name for name, value in options.items() if value is not None]
    if given:
        raise InputError(f"{', '.join(given)} without --ros2; needed: both")
