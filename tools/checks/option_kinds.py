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


def refuse_other_topics(ros2: bool, for_topics: Mapping[str, object], for_files: Iterable[str]) -> None:
    """Raise `InputError` if an option has no effect, because topics are compared or because they are not.

    Args:
        ros2: True with `--ros2`.
        for_topics: values of the options that have an effect with `--ros2` alone, by name; None: not given.
        for_files: given options that concern a file alone.
    """
    wrong = [name for name in for_files if name in CONCERNED_FILES]
    if ros2 and wrong:
        raise InputError(f"{', '.join(wrong)} with --ros2; allowed: --bench, --bag, --seconds")
    given = [name for name, value in for_topics.items() if value is not None]
    if given and not ros2:
        raise InputError(f"{', '.join(given)} without --ros2; needed: both")
