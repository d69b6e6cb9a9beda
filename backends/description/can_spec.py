"""How a robot's drives are reached: the section `can` of its file.

What must hold between several of its values is checked by `handcart.backends.can.devices.can_findings`:
only who drives by CAN needs that, and `handcart check`.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from handcart.files.inside import FilePath
from handcart.files.models.model import FileModel

from .can_sensor_spec import SensorsSpec

VIRTUAL = "virtual"

Positive = Annotated[float, Field(gt=0.0)]
NodeId = Annotated[int, Field(ge=1, le=127)]
Word = Annotated[int, Field(ge=0, lt=2**32)]
Without = Literal[
    "consumer_heartbeat",
    "abort_option",
    "quick_stop_option",
    "quick_stop_ramp",
    "fault_reaction",
    "error_code",
    "torque",
    "torque_limit",
    "speed_limit",
    "position_limits",
    "following_error",
]
"""What a drive may be used without; `backends/can/devices/lacks.py` has the objects, and what follows."""


class AxisSpec(FileModel):
    """A CiA 402 drive and what it turns."""

    node: NodeId
    """Its node ID."""
    eds: FilePath | None = None
    """Its maker's EDS file, beside the robot's; left out: `backends/can/drives/drive.eds`."""
    counts_per_rev: Annotated[int, Field(gt=0, le=2**24)]
    """Of the position actual value (6064h), for a turn of the motor."""
    gear_ratio: Annotated[float, Field(gt=0.0, le=10_000.0)]
    """Turns of the motor for one of what it drives."""
    sign: Literal[1, -1] = 1
    """-1: the motor counts down where the robot's file counts up."""
    stop: Literal["hold", "brake_then_disable"]
    """`hold`: it slows down and keeps its torque (605Ah = 6); the other loses it at rest (605Ah = 2)."""
    gravity: bool
    """Whether it would move by weight alone if it had no torque."""
    brake: bool = False
    """Whether a brake holds it when it has no torque."""
    following_ms: Annotated[int, Field(gt=0, lt=2**16)] = 100
    """For how long a position may be off its demand by more than the window (6066h)."""
    vendor_id: Word | None = None
    """Of its identity (1018h:1); left out: not looked at."""
    product_code: Word | None = None
    """Of its identity (1018h:2); left out: not looked at."""
    without: tuple[Without, ...] = ()
    """Features that the drive lacks; docs/how_to/hardware.md describes the consequences."""

    @property
    def counts_per_turn(self) -> float:
        """Counts for a turn of what is driven, signed as the robot's file counts."""
        return self.sign * self.counts_per_rev * self.gear_ratio


class WheelDriveSpec(AxisSpec):
    """The drive of one wheel."""

    mode: Literal["profile", "csv"] = "profile"
    """`profile`: the drive plans its ramps (mode 3); `csv`: it takes a velocity each period (mode 9)."""
    stop: Literal["hold", "brake_then_disable"] = "brake_then_disable"
    gravity: bool = False
    following_mm: Positive = 50.0
    """By how much the rim may roll more or less than it should, within half a second."""

    def counts_per_m(self, radius: float) -> float:
        """Counts for a metre that a wheel of this radius, in [m], rolls forward."""
        return self.counts_per_turn / (2.0 * math.pi * radius)


class JointDriveSpec(AxisSpec):
    """The drive of a joint of the arm."""

    mode: Literal["profile", "csp"] = "profile"
    """`profile`: the drive plans its ramps (mode 1); `csp`: it takes a position each period (mode 8)."""
    zero_counts: Annotated[int, Field(gt=-(2**31), lt=2**31)] = 0
    """What it counts where the URDF's joint is at zero."""
    stop: Literal["hold", "brake_then_disable"] = "hold"
    gravity: bool = True
    following_deg: Positive = 3.0
    """Window of its following error (6065h)."""
    following_mm: Positive = 5.0
    """The same of a joint that slides."""
    rated_torque_nm: Positive | None = None
    """What 1000 of its torque (6077h) is at the joint."""
    rated_force_n: Positive | None = None
    """The same of a joint that slides."""
    lead_mm: Positive | None = None
    """By how much a joint that slides moves with a turn of what is driven."""

    @property
    def slides(self) -> bool:
        """Whether it drives a joint that slides."""
        return self.lead_mm is not None

    @property
    def counts_per_unit(self) -> float:
        """Counts for a radian of the joint, or a metre."""
        turn = 2.0 * math.pi if self.lead_mm is None else self.lead_mm / 1e3
        return self.counts_per_turn / turn

    @property
    def rated_effort(self) -> float:
        """What 1000 of its torque (6077h) is at the joint, in [Nm], or [N] where it slides."""
        return (self.rated_force_n if self.slides else self.rated_torque_nm) or 0.0

    @property
    def following(self) -> float:
        """Window of its following error, in [rad], or [m] where it slides."""
        return self.following_mm / 1e3 if self.slides else math.radians(self.following_deg)


class GripperDriveSpec(AxisSpec):
    """The drive of the fingers. It may be blocked: it has no following error, its torque is limited."""

    mode: Literal["profile"] = "profile"
    lead_mm: Positive
    """By which the opening grows with a turn of what is driven."""
    zero_counts: Annotated[int, Field(gt=-(2**31), lt=2**31)] = 0
    """What it counts where the fingers meet."""
    stop: Literal["hold", "brake_then_disable"] = "hold"
    gravity: bool = False
    top_torque_percent: Annotated[float, Field(gt=0.0, le=1000.0)] = 100.0
    """Of its rated torque, with which it grips (6072h)."""

    @property
    def counts_per_m(self) -> float:
        """Counts for a metre of opening."""
        return self.counts_per_turn / (self.lead_mm / 1e3)


class CanSpec(FileModel):
    """A CAN interface with a drive for each wheel, joint, and the gripper."""

    interface: str
    """As python-can calls it: socketcan, pcan, ...; `virtual` stands for simulated drives."""
    channel: str
    """Of the interface, such as can0."""
    bitrate_kbit_s: Literal[10, 20, 50, 125, 250, 500, 800, 1000]
    """One of CANopen's (CiA 301)."""
    our_node: NodeId = 127
    """Node ID of this program, for its heartbeat."""
    heartbeat_ms: Annotated[int, Field(ge=5, le=1000)] = 50
    """Between two heartbeats of ours, and of a drive (1017h)."""
    heartbeat_timeout_ms: Annotated[int, Field(ge=10, le=5000)] = 150
    """Without a heartbeat for so long, a drive stops (1016h), and so do we."""
    allowed_emergencies: tuple[Annotated[int, Field(gt=0, lt=2**16)], ...] = ()
    """Error codes of emergency messages (CiA 301) that don't stop the robot, as decimal numbers."""
    left: WheelDriveSpec
    right: WheelDriveSpec
    joints: tuple[JointDriveSpec, ...] = ()
    """In the order of the arm's `joints`."""
    gripper: GripperDriveSpec | None = None
    sensors: SensorsSpec = SensorsSpec()
    """Sensors that are not on the bus."""

    @property
    def wheels(self) -> tuple[WheelDriveSpec, WheelDriveSpec]:
        """Left, right."""
        return self.left, self.right

    def axes(self) -> tuple[tuple[str, AxisSpec], ...]:
        """All drives, with how people call what they move."""
        joints = ((f"joint {number}", joint) for number, joint in enumerate(self.joints, 1))
        gripper = () if self.gripper is None else (("gripper", self.gripper),)
        return ("left wheel", self.left), ("right wheel", self.right), *joints, *gripper
