"""What can go wrong on the bus.

    HandcartError
    ├── InputError
    │   ├── NoDrives            the robot's file has no section `can`
    │   ├── TooManyCounts       a wheel's counts don't fit into 32 bits
    │   └── NoInterface         the CAN interface can't be opened
    └── CanFault                the robot is stopped, as far as the bus allows, and stays so
        ├── BusFault            the interface doesn't send or receive
        ├── SilentDrive (TimeoutError)  a drive doesn't answer
        ├── DriveNotReady       a drive isn't in OPERATION ENABLED, or in another mode
        └── WrongDrive          a drive isn't what the robot's file needs

After a `CanFault` a person has to look; the backend has to be built anew.
"""

from __future__ import annotations

from files.errors import HandcartError, InputError


class NoDrives(InputError):
    """The robot's file doesn't say where its drives are."""

    def __init__(self) -> None:
        super().__init__("the robot's file has no section 'can'; needed: interface, channel, left, right")


class TooManyCounts(InputError):
    """A wheel's counts don't fit into a drive's 32 bits."""

    def __init__(self, drive: str, counts: float) -> None:
        told = f"{drive} would be told up to {counts:.3g} counts/s or counts/s²"
        super().__init__(f"{told}; allowed: below 2147483648, by counts_per_rev, gear_ratio, wheel_radius_m")


class NoInterface(InputError):
    """The CAN interface can't be opened."""

    def __init__(self, interface: str, channel: str, bitrate: int, why: str) -> None:
        up = f"; is it up? `ip link set {channel} up type can bitrate {bitrate}`"
        hint = up if interface == "socketcan" else ""
        super().__init__(f"no CAN on {interface} {channel}: {why}{hint}")


class CanFault(HandcartError):
    """The robot can't be driven any more; a person has to look."""


class BusFault(CanFault):
    """The interface doesn't send or receive."""

    def __init__(self, doing: str, why: str) -> None:
        super().__init__(f"the CAN bus failed while {doing}: {why}")


class SilentDrive(CanFault, TimeoutError):
    """A drive doesn't answer; it has to stop by its own supervision of the bus."""

    def __init__(self, drive: str, objects: str, age: float | None) -> None:
        since = "at all" if age is None else f"for {age:.3g} s"
        super().__init__(f"{drive} is silent: no {objects} {since}")


class DriveNotReady(CanFault):
    """A drive isn't enabled; told with what it says about its fault."""

    def __init__(self, drive: str, state: str, fault: str) -> None:
        told = f": {fault}" if fault else ""
        super().__init__(f"{drive} is in the state {state}{told}; needed: OPERATION ENABLED")


class WrongDrive(CanFault):
    """A drive can't do what is needed, or doesn't take a setting."""

    def __init__(self, drive: str, what: str, got: str, allowed: str) -> None:
        super().__init__(f"{drive}: {what} is {got}; allowed: {allowed}")
