"""The frames that go over a robot's bus again and again."""

from __future__ import annotations

from collections.abc import Iterator

from handcart.backends.can.bus.bus_load import BusLoad, CyclicFrame
from handcart.backends.can.bus.pdo_layout import CIA402_MODES, layout
from handcart.backends.can.eds.lacks import left_out
from handcart.backends.description.can_spec import AxisSpec, CanSpec, WheelDriveSpec

_SYNC, _HEARTBEAT = 0x080, 0x700


def bus_load(spec: CanSpec, period: float) -> BusLoad:
    """Return the load of the CAN bus by a robot's cyclic frames, with a control period of `period` [s]."""
    return BusLoad.of(cyclic_frames(spec, period), 1000 * spec.bitrate_kbit_s)


def cyclic_frames(spec: CanSpec, period: float) -> Iterator[CyclicFrame]:
    """Yield each cyclic frame on the bus; a frame that is sent only on a change counts as sent in every
    period.

    Args:
        spec: the section `can` of a robot's file.
        period: control period, in [s].
    """
    yield CyclicFrame("SYNC", _SYNC, 0, period)
    # Ours is sent by a step of the control loop.
    ours = max(period, spec.heartbeat_ms / 1e3)
    yield CyclicFrame("heartbeat of this program", _HEARTBEAT + spec.our_node, 1, ours)
    for name, axis in spec.axes():
        yield from _pdos(name, axis, period)
        yield CyclicFrame(f"{name}: heartbeat", _HEARTBEAT + axis.node, 1, spec.heartbeat_ms / 1e3)


def _pdos(name: str, axis: AxisSpec, period: float) -> Iterator[CyclicFrame]:
    frames = layout(mode_of(axis), left_out(axis))
    for first, what, pdos in ((0x200, "command", frames.commands), (0x180, "answer", frames.answers)):
        for pdo in pdos:
            cob_id = first + 0x100 * (pdo.number - 1) + axis.node
            yield CyclicFrame(f"{name}: {what} {pdo.number}", cob_id, pdo.length, period)


def mode_of(axis: AxisSpec) -> int:
    """Return the mode of operation (6060h) in which the robot's file drives an axis."""
    kind = "velocity" if isinstance(axis, WheelDriveSpec) else "position"
    return CIA402_MODES[kind, getattr(axis, "mode", "profile")]
