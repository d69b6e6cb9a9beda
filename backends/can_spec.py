"""How a robot's drives are reached: the section `can` of its file."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from files.model import FileModel
from files.suggest import suggest

VIRTUAL = "virtual"


class WheelDriveSpec(FileModel):
    """The CiA 402 drive of one wheel."""

    node: Annotated[int, Field(ge=1, le=127)]
    """Its node ID."""
    counts_per_rev: Annotated[int, Field(gt=0, le=2**24)]
    """Of the position actual value (6064h), for a turn of the motor."""
    gear_ratio: Annotated[float, Field(gt=0.0, le=10_000.0)]
    """Turns of the motor for one of the wheel."""
    sign: Literal[1, -1] = 1
    """-1: the motor counts down when the robot drives forward."""

    def counts_per_m(self, radius: float) -> float:
        """Counts for a metre that a wheel of this radius, in [m], rolls forward."""
        return self.sign * self.counts_per_rev * self.gear_ratio / (2.0 * math.pi * radius)


class CanSpec(FileModel):
    """A CAN interface with a drive for each wheel."""

    interface: str
    """As python-can calls it: socketcan, pcan, ...; `virtual` stands for two simulated drives."""
    channel: str
    """Of the interface, such as can0."""
    bitrate_kbit_s: Literal[10, 20, 50, 125, 250, 500, 800, 1000]
    """One of CANopen's (CiA 301)."""
    left: WheelDriveSpec
    right: WheelDriveSpec

    @property
    def wheels(self) -> tuple[WheelDriveSpec, WheelDriveSpec]:
        """Left, right."""
        return self.left, self.right

    @field_validator("interface")
    @classmethod
    def _known(cls, name: str) -> str:
        if name == VIRTUAL:
            return name
        from can.interfaces import VALID_INTERFACES

        if name not in VALID_INTERFACES:
            raise ValueError(f"unknown interface {name!r}{suggest(name, VALID_INTERFACES)}")
        return name

    @model_validator(mode="after")
    def _two_nodes(self) -> Self:
        if self.left.node == self.right.node:
            raise ValueError(f"both wheels have the node {self.left.node}; allowed: two different ones")
        return self
