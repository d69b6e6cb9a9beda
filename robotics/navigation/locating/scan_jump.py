"""Detection of a base that was lifted and set down elsewhere: its scans change at once, its wheels do not."""

from __future__ import annotations

import math

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.scans.start_search import ScanBeams
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled

from .moved_scan import beam_step, moved_echoes, rolled_motion, same_ranges

MAX_CHANGED_SHARE = 0.3
"""Share of beams that may differ from those of the scan before; people and doors change fewer."""
CHANGED_M, CHANGED_RATIO = 0.15, 0.05  # of a range, from the scan before it: more is a change
SIDE_BEAMS = 2  # to each side, among which a beam of the scan before is looked for
CONFIRMED_CHANGES = 6  # scans in a row that differ from the last one before the change
CONFIRMED_CHANGES_AT_REST = 2
MIN_COMPARED = 20  # beams
MAX_REFERENCE_M, MAX_REFERENCE_RAD = 1.0, 0.6  # of motion, after which the last scan before is too old


class ScanJump:
    """Detector of a base that was lifted, which compares each scan with an earlier one moved by the wheels.

    The earlier scan is the last one that agreed with its predecessor. A base that slides off an obstacle
    moves differently from its wheels. Then a scan is also compared with the earlier one moved by the
    estimated motion.
    """

    def __init__(self) -> None:
        """Start without a scan."""
        self._reference: ScanBeams | None = None
        self._moved = Pose2(0.0, 0.0, 0.0)  # since the reference, in its frame
        self._pose = Pose2(0.0, 0.0, 0.0)  # estimated at the reference
        self._changes = 0
        self.share = 0.0
        """Share of the last scan's beams that differ from those of the reference."""

    def roll(self, left: float, right: float, tread: float, sideways: float = 0.0) -> None:
        """Add the travel of the wheels in a period, by which an earlier scan is moved before the comparison.

        Args:
            left: travel of the left wheels, in [m].
            right: travel of the right wheels, in [m].
            tread: distance between the left and right wheels, in [m].
            sideways: travel to the left, in [m].
        """
        self._moved = self._moved.compose(rolled_motion(left, right, sideways, tread))

    @property
    def is_doubtful(self) -> bool:
        """True if the last scans disagree with an earlier one, but too few of them to conclude that the base
        was lifted.
        """
        return self._changes > 0

    def take(self, beams: ScanBeams, at_rest: bool, pose: Pose2, slides: bool = False) -> bool:
        """Compare a scan with an earlier one; return whether the latest scans show that the base was lifted.

        They show this if `CONFIRMED_CHANGES` scans in a row differ from the earlier one. The scans kept for
        comparison are then discarded.

        Args:
            beams: beams of the scan.
            at_rest: True if the base is at rest: `CONFIRMED_CHANGES_AT_REST` scans then suffice.
            pose: estimated map_T_base.
            slides: True if the base may slide: the scan is then also compared by the estimated motion.
        """
        before = self._reference
        if before is not None and same_ranges(before.ranges, beams.ranges):
            return False  # an old scan given again says nothing of where the base is now
        estimated = pose.relative_to(self._pose) if slides else None
        changed = before is not None and self._is_changed(before, beams, estimated)
        self._changes = self._changes + 1 if changed else 0
        if self._changes >= (CONFIRMED_CHANGES_AT_REST if at_rest else CONFIRMED_CHANGES):
            self.reset()
            return True
        if not changed:
            self._reference, self._moved, self._pose = beams, Pose2(0.0, 0.0, 0.0), pose
        return False

    def reset(self) -> None:
        """Discard all scans and wheel travel so far; the next scan becomes the reference for later ones."""
        self._reference, self._moved, self._changes = None, Pose2(0.0, 0.0, 0.0), 0

    def _is_changed(self, before: ScanBeams, beams: ScanBeams, estimated: Pose2 | None) -> bool:
        """Return whether neither the wheels' motion nor the estimated one, if given, explains a scan."""
        far = math.hypot(self._moved.x, self._moved.y) > MAX_REFERENCE_M
        if far or abs(self._moved.theta) > MAX_REFERENCE_RAD or len(before.angles) != len(beams.angles):
            return False
        self.share = _changed_share(before, beams, self._moved)
        if estimated is not None and self.share > MAX_CHANGED_SHARE:
            self.share = min(self.share, _changed_share(before, beams, estimated))
        return self.share > MAX_CHANGED_SHARE


def _changed_share(before: ScanBeams, beams: ScanBeams, moved: Pose2) -> float:
    """Return the share of an earlier scan's echoes that a motion before_T_now does not lead to; 0 if few."""
    back = moved.inverse()
    changed, compared = _changed_beams(
        (before.origin, before.angles, before.ranges),
        (back.x, back.y, back.theta),
        beams.origin,
        beams.angles,
        beams.ranges,
    )
    return changed / compared if compared >= MIN_COMPARED else 0.0


@compiled
def _changed_beams(
    before: tuple[FloatArray, FloatArray, FloatArray],
    moved: tuple[float, float, float],
    sensor: FloatArray,
    angles: FloatArray,
    ranges: FloatArray,
) -> tuple[int, int]:
    """Return how many echoes of the scan before the beams do not show any more, and how many were compared.

    Args:
        before: origin (2,) in [m], angles (m,) in [rad] and ranges (m,) in [m] of the scan before, in the
            base frame then.
        moved: pose of the base then, in the base frame now: x, y in [m], heading in [rad].
        sensor: (2,) origin of the beams in the base frame now, in [m].
        angles: (n,) of the beams in the base frame now, ascending in even steps, in [rad].
        ranges: (n,) in [m].
    """
    count, step = len(angles), beam_step(angles)
    changed, compared = 0, 0
    if step <= 0.0:
        return changed, compared
    for x, y in moved_echoes(before, moved, sensor):
        if math.isnan(x):
            continue
        angle, away = math.atan2(y, x), math.sqrt(x * x + y * y)
        at = (angle - angles[0]) % (2.0 * math.pi)
        middle = int(at / step + 0.5)
        if middle >= count:
            continue
        seen, known = False, False
        for j in range(middle - SIDE_BEAMS, middle + SIDE_BEAMS + 1):
            if not 0 <= j < count or math.isnan(ranges[j]):
                continue
            known = True
            if abs(ranges[j] - away) <= CHANGED_M + CHANGED_RATIO * away:
                seen = True
                break
        if known:
            compared += 1
            changed += 0 if seen else 1
    return changed, compared
