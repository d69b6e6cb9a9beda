"""Which activities can be made, and why the others can't."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from handcart.files.errors import FileError

from .definition import activity_names
from .making import plan_activity

SHOWN_REASONS = 40


class ListedActivity(NamedTuple):
    """An activity, with the number of things that it moves, or the reasons why its files cannot be made."""

    name: str
    moves: int
    """Number of things to move; 0 if it can't be made."""
    reasons: tuple[str, ...]
    """Requirements of the activity that our worlds or the robot do not meet."""


def list_activities(robot: str, scale: bool = False) -> Iterator[ListedActivity]:
    """Yield every activity, in alphabetical order.

    Args:
        robot: name or file of the robot.
        scale: True to make things narrower that are too wide for the robot's fingers.

    Raises:
        NoBddl: the package `bddl` is missing or cannot be imported.
    """
    for name in activity_names():
        try:
            _, room, _ = plan_activity(name, 0, robot, scale)
        except FileError as error:
            yield ListedActivity(name, 0, tuple(finding.message for finding in error.findings))
        else:
            yield ListedActivity(name, len(room.at_end), ())


def summary_lines(listed: list[ListedActivity]) -> Iterator[str]:
    """Yield lines of text: the activities whose files can be made, then the reasons why others cannot."""
    made = [activity for activity in listed if activity.moves]
    yield f"{len(made)} of {len(listed)} activities can be made:"
    yield from (f"  {activity.name:<44} {activity.moves} to move" for activity in made)
    counts = Counter(
        kind for activity in listed for kind in {_kind_of(reason) for reason in activity.reasons}
    )
    yield "the others need, by the number of activities:"
    yield from (f"  {count:>4}  {kind}" for kind, count in counts.most_common(SHOWN_REASONS))
    if len(counts) > SHOWN_REASONS:
        more = len(counts) - SHOWN_REASONS
        yield f"        and {more} other reasons; `handcart activity NAME -o FOLDER` reports those of one"


def _kind_of(reason: str) -> str:
    """Return a reason without its instances and without what is allowed."""
    first = re.split("; did you mean|; allowed", reason)[0]
    return re.sub(r"(\.n\.\d+)_\d+", r"\1", first)
