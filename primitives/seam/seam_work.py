"""Progress of the work on a seam, and its remaining parts."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.geometry.pose2 import Pose2


class DrivesTo(NamedTuple):
    """Place (by name) and pose at which the straight drive of a base along a seam ends."""

    place: str
    """Name of the place there."""
    pose: Pose2
    """map_T_base there."""


class SeamPart(NamedTuple):
    """Part of a seam, tracked while the base is at one place or drives straight on from that place."""

    place: str
    """Name of the base's place at the begin of the part."""
    pose: Pose2
    """map_T_base at that place."""
    first: int
    """Index of its first point on the seam."""
    last: int
    """Index of its last point; the next part begins there."""
    score: float
    """Integral of the score along the part, in [m]; at most the part's length for scores up to 1."""
    end: DrivesTo | None = None
    """End of the base's straight way level with the tool; None for a base at rest."""

    @property
    def empty(self) -> bool:
        """True if the part has no length, because its first and last point are the same."""
        return self.first == self.last


class SeamWork(NamedTuple):
    """Progress of the work on a seam, with the part that is tracked and the parts that are still planned."""

    tracked: int = 0
    """Index of the point up to which the seam is tracked."""
    next: SeamPart | None = None
    """Next part; None before a division. When all is tracked, an empty part at the last place."""
    after: tuple[SeamPart, ...] = ()
    """Parts after the next one."""
    named: int = 0
    """Number of places that were named so far."""
    avoided: tuple[Pose2, ...] = ()
    """Poses of the base, reached or planned, at which the arm could not do its part."""

    @property
    def rest(self) -> tuple[SeamPart, ...]:
        """Parts of the seam that are planned but not tracked yet, the next one first; empty if there are
        none.
        """
        return () if self.next is None or self.next.empty else (self.next, *self.after)

    def done(self) -> SeamWork:
        """Return this work after the next part of the seam was tracked; unchanged if no part is next."""
        if self.next is None:
            return self
        end = self.next._replace(first=self.next.last, score=0.0, end=None)
        if self.next.end is not None:
            end = end._replace(place=self.next.end.place, pose=self.next.end.pose)
        following = self.after[0] if self.after else end
        return self._replace(tracked=self.next.last, next=following, after=self.after[1:])
