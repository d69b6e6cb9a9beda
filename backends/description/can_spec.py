"""Connection to a robot's drives: the section `can` of its file.

Conditions between several of its values are checked by `handcart.backends.can.devices.can_findings`, only
for a robot that is driven by CAN, and in `handcart check`.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from handcart.files.inside import FilePath
from handcart.files.models.model import FileModel

from .can_sensor_spec import SensorsSpec

VIRTUAL_INTERFACE = "virtual"

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
"""Optional features of a drive; `backends/can/eds/lacks.py` lists their objects, and the consequences
without them.
"""


class AxisSpec(FileModel):
    """Description of a CiA 402 drive in a robot's file: node, encoder, gear, behaviour at a stop, and
    brake.
    """

    node: NodeId
    """Node ID of the drive."""
    eds: FilePath | None = None
    """The maker's EDS file, next to the robot's file (default: `backends/can/drives/drive.eds`)."""
    counts_per_rev: Annotated[int, Field(gt=0, le=2**24)]
    """Counts of the position actual value (6064h) for a turn of the motor."""
    gear_ratio: Annotated[float, Field(gt=0.0, le=10_000.0)]
    """Turns of the motor for one turn of the driven part."""
    sign: Literal[1, -1] = 1
    """-1: the motor counts down where the robot's file counts up."""
    stop: Literal["hold", "brake_then_disable"]
    """`hold`: the drive slows down and keeps its torque (605Ah = 6); the other: it loses the torque at rest
    (605Ah = 2).
    """
    gravity: bool
    """True if the axis would move by its weight without torque."""
    brake: bool = False
    """True if a brake holds the axis without torque."""
    following_ms: Annotated[int, Field(gt=0, lt=2**16)] = 100
    """Time for which a position may differ from its demand by more than the window (6066h)."""
    vendor_id: Word | None = None
    """Expected vendor ID (1018h:1) (default: not checked)."""
    product_code: Word | None = None
    """Expected product code (1018h:2) (default: not checked)."""
    without: tuple[Without, ...] = ()
    """Features that the drive lacks; docs/how_to/hardware.md describes the consequences."""

    @property
    def counts_per_turn(self) -> float:
        """Encoder counts for one turn of the wheel or joint that the gear drives; negative if `sign` in the
        robot's file is -1.
        """
        return self.sign * self.counts_per_rev * self.gear_ratio


class WheelDriveSpec(AxisSpec):
    """Description of the CiA 402 drive of a wheel, in a robot's file."""

    mode: Literal["profile", "csv"] = "profile"
    """`profile`: the drive plans its ramps (mode 3); `csv`: it takes a velocity each period (mode 9)."""
    stop: Literal["hold", "brake_then_disable"] = "brake_then_disable"
    gravity: bool = False
    following_mm: Positive = 50.0
    """Maximum difference between the rim's travel and its demand within half a second."""

    def counts_per_m(self, radius: float) -> float:
        """Return the encoder counts per metre of forward travel of a wheel with a `radius` in [m]."""
        return self.counts_per_turn / (2.0 * math.pi * radius)


class JointDriveSpec(AxisSpec):
    """Description of the CiA 402 drive of an arm's joint, in a robot's file."""

    mode: Literal["profile", "csp"] = "profile"
    """`profile`: the drive plans its ramps (mode 1); `csp`: it takes a position each period (mode 8)."""
    zero_counts: Annotated[int, Field(gt=-(2**31), lt=2**31)] = 0
    """Encoder counts at the zero of the URDF's joint."""
    stop: Literal["hold", "brake_then_disable"] = "hold"
    gravity: bool = True
    following_deg: Positive = 3.0
    """Window of the drive's following error (6065h), for a turning joint."""
    following_mm: Positive = 5.0
    """Maximum following error of a sliding joint."""
    rated_torque_nm: Positive | None = None
    """Torque at the joint for a torque value (6077h) of 1000."""
    rated_force_n: Positive | None = None
    """Force at a sliding joint for a torque value (6077h) of 1000."""
    lead_mm: Positive | None = None
    """Travel of a sliding joint for one turn of the driven shaft."""

    @property
    def slides(self) -> bool:
        """True if the drive moves a sliding joint."""
        return self.lead_mm is not None

    @property
    def counts_per_unit(self) -> float:
        """Encoder counts for a radian of the joint, or a metre of a sliding joint; negative if `sign` in the
        robot's file is -1.
        """
        turn = 2.0 * math.pi if self.lead_mm is None else self.lead_mm / 1e3
        return self.counts_per_turn / turn

    @property
    def rated_effort(self) -> float:
        """Effort at the joint at the motor's rated torque (a value of 1000 in 6077h), in [Nm], or in [N] for
        a sliding joint.
        """
        return (self.rated_force_n if self.slides else self.rated_torque_nm) or 0.0

    @property
    def following(self) -> float:
        """Largest allowed following error of the drive (6065h), in [rad], or [m] for a sliding joint."""
        return self.following_mm / 1e3 if self.slides else math.radians(self.following_deg)


class GripperDriveSpec(AxisSpec):
    """Description of the CiA 402 drive of a gripper's fingers, in a robot's file.

    The drive may be stopped by a gripped object: its torque is limited, and its following error is not
    supervised.
    """

    mode: Literal["profile"] = "profile"
    lead_mm: Positive
    """Increase of the opening for one turn of the driven shaft."""
    zero_counts: Annotated[int, Field(gt=-(2**31), lt=2**31)] = 0
    """Encoder counts at which the fingers meet."""
    stop: Literal["hold", "brake_then_disable"] = "hold"
    gravity: bool = False
    top_torque_percent: Annotated[float, Field(gt=0.0, le=1000.0)] = 100.0
    """Gripping torque, in percent of the rated torque (6072h)."""

    @property
    def counts_per_m(self) -> float:
        """Counts for a metre of opening; negative if the motor counts down while the fingers open."""
        return self.counts_per_turn / (self.lead_mm / 1e3)


class CanSpec(FileModel):
    """Section `can` of a robot's file, with CAN interface and the drives of wheels, joints and gripper."""

    interface: str
    """Name of the python-can interface: socketcan, pcan, ...; `virtual` is for simulated drives."""
    channel: str
    """Channel of the interface, such as can0."""
    bitrate_kbit_s: Literal[10, 20, 50, 125, 250, 500, 800, 1000]
    """Bit rate, one of CANopen's (CiA 301)."""
    our_node: NodeId = 127
    """Node ID of this program, used by its heartbeat."""
    heartbeat_ms: Annotated[int, Field(ge=5, le=1000)] = 50
    """Time between two heartbeats of this program, and of a drive (1017h)."""
    heartbeat_timeout_ms: Annotated[int, Field(ge=10, le=5000)] = 150
    """Time without a heartbeat after which a drive stops (1016h), and this program stops the robot."""
    allowed_emergencies: tuple[Annotated[int, Field(gt=0, lt=2**16)], ...] = ()
    """Error codes of emergency messages (CiA 301) that don't stop the robot, as decimal numbers."""
    left: WheelDriveSpec
    right: WheelDriveSpec
    joints: tuple[JointDriveSpec, ...] = ()
    """Joint drives, in the order of the arm's `joints`."""
    gripper: GripperDriveSpec | None = None
    sensors: SensorsSpec = SensorsSpec()
    """Sensors that are not on the bus."""

    @property
    def wheels(self) -> tuple[WheelDriveSpec, WheelDriveSpec]:
        """Drives of the left and the right wheel."""
        return self.left, self.right

    def axes(self) -> tuple[tuple[str, AxisSpec], ...]:
        """All drives, each with the name of what it moves, such as `left wheel` or `joint 1`."""
        joints = ((f"joint {number}", joint) for number, joint in enumerate(self.joints, 1))
        gripper = () if self.gripper is None else (("gripper", self.gripper),)
        return ("left wheel", self.left), ("right wheel", self.right), *joints, *gripper
