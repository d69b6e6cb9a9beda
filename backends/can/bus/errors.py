"""Errors of the CAN bus.

    HandcartError
    ├── InputError
    │   ├── NoDrives            the robot's file has no section `can`, or not all of it
    │   ├── TooManyCounts       a possible set-point of an axis does not fit into 32 bits
    │   ├── NoInterface         the CAN interface cannot be opened
    │   └── ChannelTaken        another robot or bench is on the channel
    └── RobotFault
        └── CanFault            the robot is stopped, as far as the bus allows, and stays so
            ├── BusFault            the interface does not send or receive
            │   ├── QueueFull           the interface has no room for frames to be sent
            │   └── ControllerFault     the CAN controller has gone off the bus, or is about to
            ├── SilentDrive (TimeoutError)  a drive does not answer
            ├── LostAnswers         too many answers of a drive get lost
            ├── DriveNotReady       a drive is not in OPERATION ENABLED, or in another mode
            ├── WrongDrive          a drive is not what the robot's file needs
            ├── EncoderWraps        a drive's counts start over inside the travel of its axis
            ├── ReadBackDiffers     settings are not what was written
            ├── Emergency           a node reports a fault (EMCY)
            ├── NodeRestarted       a node has booted, or left OPERATIONAL
            ├── TwoNodes            two nodes have one node ID
            ├── Stranger            another node commands the drives
            ├── Overloaded          the bus is too busy, or full of nonsense
            ├── OffDemand           an axis does not follow its commands
            ├── LateLoop            this program does not keep its periods
            └── BrokenOff           something else ended a period before it was over

After a `CanFault` a person has to look; the backend has to be built anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from handcart.backends.backend import RobotFault
from handcart.files.errors import InputError


class NoDrives(InputError):
    """Error: the robot's file has no section `can`, or a part of it is missing."""

    def __init__(self) -> None:
        super().__init__("the robot's file has no section 'can'; needed: interface, channel, left, right")


class TooManyCounts(InputError):
    """Error: a possible set-point of an axis, in counts, does not fit into a drive's 32 bits."""

    def __init__(self, drive: str, counts: float) -> None:
        message = f"{drive} would be told up to {counts:.3g} counts, counts/s or counts/s²"
        super().__init__(f"{message}; allowed: below 2147483648, by counts_per_rev and gear_ratio")


class NoInterface(InputError):
    """Error: the CAN interface cannot be opened."""

    def __init__(self, interface: str, channel: str, bitrate: int, why: str) -> None:
        up = f"; is it up? `ip link set {channel} up type can bitrate {bitrate}`"
        hint = up if interface == "socketcan" else ""
        super().__init__(f"no CAN on {interface} {channel}: {why}{hint}")


class ChannelTaken(InputError):
    """Error: another robot or bench uses the channel, so that the robots would receive each other's
    commands.
    """

    def __init__(self, interface: str, channel: str, by: str, hint: str) -> None:
        super().__init__(f"{interface} {channel} is in use by {by}; {hint}")


class CanFault(RobotFault):
    """Error on the CAN bus, such as a silent drive or an overloaded bus; the robot cannot be driven any more,
    and a person has to look at it.
    """


class BusFault(CanFault):
    """Error: the CAN interface does not send or receive."""

    def __init__(self, doing: str, why: str) -> None:
        super().__init__(f"the CAN bus failed while {doing}: {why}")


class QueueFull(BusFault):
    """Error: the CAN interface's queue is full, because the bus does not accept frames."""

    def __init__(self, frames: int) -> None:
        super().__init__("sending", f"its queue is full, {frames} frames in a row were lost")


class ControllerFault(BusFault):
    """Error: the CAN controller is in the state bus-off, or close to it, because of transmission errors."""

    def __init__(self, state: str) -> None:
        super().__init__("driving", f"the controller is {state}; look at the cable and its terminations")


class SilentDrive(CanFault, TimeoutError):
    """Error: a drive does not answer. It stops by itself when this program's heartbeat is missing."""

    def __init__(self, drive: str, objects: str, age: float | None) -> None:
        since = "at all" if age is None else f"for {age:.3g} s"
        super().__init__(f"{drive} is silent: no {objects} {since}")


class LostAnswers(CanFault):
    """Error: a drive did not answer too many of the latest SYNCs; the message states how many are allowed."""

    def __init__(self, drive: str, lost: int, of: int, allowed: str) -> None:
        super().__init__(f"{drive} is unreliable: {lost} of {of} answers didn't come; allowed: {allowed}")


class DriveNotReady(CanFault):
    """Error: a drive is not enabled; the message contains its state and fault."""

    def __init__(self, drive: str, state: str, fault: str) -> None:
        reason = f": {fault}" if fault else ""
        super().__init__(f"{drive} is in the state {state}{reason}; needed: OPERATION ENABLED")


class WrongDrive(CanFault):
    """Error: a drive lacks a needed function, or rejects a setting."""

    def __init__(self, drive: str, what: str, got: str, allowed: str) -> None:
        super().__init__(f"{drive}: {what} is {got}; allowed: {allowed}")


class EncoderWraps(CanFault):
    """Error: a drive's counts start over inside the travel of its axis, so that a reading is ambiguous."""

    def __init__(self, drive: str, how: str) -> None:
        super().__init__(f"{drive}: {how}")


@dataclass(frozen=True)
class Difference:
    """Setting of a drive whose value, when it is read back, differs from the value that was written."""

    drive: str
    index: int
    subindex: int
    name: str
    """Name in the drive's EDS file."""
    wanted: int
    got: int | str
    """Value that was read back, or the reason why none was."""

    def __str__(self) -> str:
        at = f"{self.index:04X}h" + (f":{self.subindex}" if self.subindex else "")
        return f"{self.drive}: {self.name.lower()} ({at}) is {self.got}; wanted: {self.wanted}"


class ReadBackDiffers(CanFault):
    """Error: settings that were read back from drives differ from the written ones; nothing moves."""

    def __init__(self, differences: Sequence[Difference]) -> None:
        self.differences = tuple(differences)
        super().__init__("\n".join(str(difference) for difference in self.differences))


class Emergency(CanFault):
    """Error: a node sends an emergency message (EMCY)."""

    def __init__(self, node: str, fault: str) -> None:
        super().__init__(f"{node} sends an emergency message: {fault}")


class NodeRestarted(CanFault):
    """Error: a node booted, or left OPERATIONAL, during a run; its encoder's counts may have another zero
    now.
    """

    def __init__(self, node: str, what: str) -> None:
        super().__init__(f"{node} {what} under way; needed: OPERATIONAL")


class TwoNodes(CanFault):
    """Error: two nodes have the same node ID."""

    def __init__(self, node: str, sign: str) -> None:
        super().__init__(f"two nodes seem to be {node}: {sign}; allowed: each node ID once")


class Stranger(CanFault):
    """Error: another node sends commands to the drives."""

    def __init__(self, what: str) -> None:
        super().__init__(
            f"another node on the bus sends {what}; allowed: one master, and a channel for each robot"
        )


class Overloaded(CanFault):
    """Error: the bus carries too many frames, or too many malformed ones."""

    def __init__(self, what: str) -> None:
        super().__init__(f"the CAN bus is overloaded: {what}")


class OffDemand(CanFault):
    """Error: the measured motion of an axis does not follow the axis' commands."""

    def __init__(self, drive: str, what: str) -> None:
        super().__init__(f"{drive} doesn't follow: {what}")


class BrokenOff(CanFault):
    """Error: an interrupt or an exception in the program ended a control period early."""

    def __init__(self, doing: str, why: BaseException) -> None:
        super().__init__(f"{doing} was broken off: {type(why).__name__}: {why}")


class LateLoop(CanFault):
    """Error: the control program takes longer than a control period for the steps of one period."""

    def __init__(self, trouble: str) -> None:
        super().__init__(f"the control loop is too slow: {trouble}")
