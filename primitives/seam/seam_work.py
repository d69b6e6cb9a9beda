"""How far the work on a seam is, and from where it goes on."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.geometry.pose2 import Pose2


class DrivesTo(NamedTuple):
    """The end of a straight way."""

    place: str
    """Name of the place there."""
    pose: Pose2
    """map_T_base there."""


class SeamPart(NamedTuple):
    """What of a seam is tracked from one place, or on the straight way from it."""

    place: str
    """Name of the place that the base is to stand at."""
    pose: Pose2
    """map_T_base there."""
    first: int
    """Point of the seam where it begins."""
    last: int
    """Where it ends; the next part begins there."""
    score: float
    """Integral along it, in [m]: up to its length."""
    end: DrivesTo | None = None
    """Where the base drives meanwhile, straight on and level with the tool; None: it stands."""

    @property
    def empty(self) -> bool:
        """Whether there is nothing to track."""
        return self.first == self.last


class SeamWork(NamedTuple):
    """A seam divided among places."""

    tracked: int = 0
    """Up to this point it is done."""
    next: SeamPart | None = None
    """What is tracked next; None: it isn't divided. When all is tracked, an empty part at the last place."""
    after: tuple[SeamPart, ...] = ()
    """What follows then."""
    named: int = 0
    """Places that were named so far."""
    avoided: tuple[Pose2, ...] = ()
    """Where the base stood, or was to stand, and the arm could not do its part."""

    @property
    def rest(self) -> tuple[SeamPart, ...]:
        """All that is divided and not yet tracked."""
        return () if self.next is None or self.next.empty else (self.next, *self.after)

    def done(self) -> SeamWork:
        """The next part is tracked."""
        if self.next is None:
            return self
        end = self.next._replace(first=self.next.last, score=0.0, end=None)
        if self.next.end is not None:
            end = end._replace(place=self.next.end.place, pose=self.next.end.pose)
        following = self.after[0] if self.after else end
        return self._replace(tracked=self.next.last, next=following, after=self.after[1:])
