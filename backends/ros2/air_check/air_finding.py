"""A difference between a robot's file and what is on the air."""

from __future__ import annotations

from typing import NamedTuple


class AirFinding(NamedTuple):
    """A difference between the robot's file and the ROS messages that the robot's nodes publish."""

    key: tuple[str, ...]
    """Place in the robot's file."""
    words: str
    """Text of the finding, with the measured value, then the allowed values."""
    is_fault: bool = True
    """True if the difference prevents driving the robot; False for a remark."""
