"""Report of `handcart check` on a robot's CAN bus."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from handcart.backends.can.bus.bus_load import BusLoad
    from handcart.backends.description.robot_file import RobotFile


def bus_of(robot: RobotFile) -> BusLoad | None:
    """Return the load that cyclic frames put on a robot's CAN bus; None if the robot has no CAN bus."""
    if robot.can is None:
        return None
    from handcart.backends.can.devices.cyclic_frames import bus_load

    return bus_load(robot.can, robot.period_s)


def bus_tables(load: BusLoad) -> Iterator[Any]:
    """Yield the load of a CAN bus as text for people: a table with a row for each cyclic frame, then the
    total load.
    """
    from handcart.backends.can.bus.bus_load import MAX_CYCLIC_LOAD
    from handcart.tools.terminal.tables import table_of

    rows = [
        (
            f"{frame.cob_id:03X}h",
            frame.what,
            f"{frame.length}",
            f"{frame.bits}",
            f"{1e3 * frame.period_s:g} ms",
            f"{load.share_of(frame):.2%}",
        )
        for frame in load.frames
    ]
    yield table_of("frame", "what", "bytes", "bits at worst", "every", "of the bus", rows=rows)
    yield (
        f"CAN bus: {load.share:.1%} of {load.bitrate / 1e3:g} kbit/s by cyclic frames, with all bits that "
        f"stuffing can add; allowed: {MAX_CYCLIC_LOAD:.0%}"
    )
    yield f"all of them once take {1e3 * load.burst_s:.2f} ms"


def bus_figures(load: BusLoad) -> dict[str, Any]:
    """Return the load of a CAN bus as a dictionary for programs, with its total and each cyclic frame."""
    return {
        "bitrate": load.bitrate,
        "share": round(load.share, 5),
        "burst_s": round(load.burst_s, 6),
        "frames": [
            {**frame._asdict(), "bits": frame.bits, "share": round(load.share_of(frame), 6)}
            for frame in load.frames
        ],
    }
