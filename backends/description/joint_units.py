"""Units in which people read and enter an arm's joints: [deg], or [mm] for sliding joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple


class JointUnits(NamedTuple):
    """Conversion of an arm's joint values between [rad] or [m] and the units in files and messages.

    The units in files and messages are [deg] for turning joints and [mm] for sliding joints.
    """

    names: tuple[str, ...]
    slides: tuple[bool, ...]
    """True for each prismatic joint."""
    endless: tuple[bool, ...]
    """True for each continuous joint: a full turn makes no difference to it."""

    def si(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the joints' positions in [rad] and [m], given in [deg] and [mm].

        Positions of continuous joints are wrapped to ±pi.
        """
        both = zip(values, self.slides, self.endless, strict=True)
        return tuple(
            value / 1e3 if slides else math.radians(_wrapped(value) if endless else value)
            for value, slides, endless in both
        )

    def user_units(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the joints' positions in [deg] and [mm], given in [rad] and [m]."""
        return tuple(self.user_value(joint, value) for joint, value in enumerate(values))

    def user_value(self, joint: int, value: float) -> float:
        """Return the position of one joint in [deg], or in [mm] for a sliding joint.

        Args:
            joint: index of the joint, from 0.
            value: position in [rad] or [m].
        """
        return 1e3 * value if self.slides[joint] else math.degrees(value)

    def unit(self, joint: int) -> str:
        """Return "mm" if the joint with the index `joint` (from 0) slides, otherwise "deg"."""
        return "mm" if self.slides[joint] else "deg"

    def words(self, joint: int, value: float, digits: int = 1) -> str:
        """Return a joint's value as text in [deg] or [mm], such as `12.5 deg`.

        Args:
            joint: index of the joint, from 0.
            value: value in [rad] or [m].
            digits: number of decimals.
        """
        return f"{self.user_value(joint, value):.{digits}f} {self.unit(joint)}"

    @property
    def all(self) -> str:
        """Return the units of all joints for a message: `deg` if all joints turn, otherwise one unit for each
        joint, such as `deg, deg, mm`.
        """
        return "deg" if not any(self.slides) else ", ".join(map(self.unit, range(len(self.names))))


def _wrapped(degrees: float) -> float:
    return degrees if abs(degrees) <= 180.0 else math.remainder(degrees, 360.0)
