"""Selection of the wheels that drive a robot, by their names."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from handcart.files.errors import InputError

_NAME = re.compile(r"(left|right)_(\w+_)?wheel")


class NoWheels(InputError):
    """Error for a simulated robot without driven wheels on one of its sides."""


class DrivenWheels(NamedTuple):
    """Names of the joints of a robot's driven wheels on each side; the link of a wheel has the joint's name.

    All wheels of a side turn together.
    """

    left: tuple[str, ...]
    """`left_wheel`, or several: `left_front_wheel`, `left_rear_wheel`."""
    right: tuple[str, ...]

    def check(self) -> None:
        """Raise `NoWheels` if a side has no wheel."""
        for side, names in self._asdict().items():
            if not names:
                raise NoWheels(
                    f"no joint of the robot drives its {side} side; needed: a joint '{side}_wheel'"
                )

    @property
    def all(self) -> tuple[str, ...]:
        """Names of all driven wheels, those of the left side first."""
        return (*self.left, *self.right)


def driven_wheels(names: Iterable[str]) -> DrivenWheels:
    """Return the names `left_wheel`, `right_front_wheel` and so on among names of joints or links, sorted."""
    found = sorted((match[1], name) for name in names if (match := _NAME.fullmatch(name)))
    left, right = (tuple(name for side, name in found if side == wanted) for wanted in ("left", "right"))
    return DrivenWheels(left, right)
