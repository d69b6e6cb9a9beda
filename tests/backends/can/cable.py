"""The cable between a program and the drives of its bench."""

from __future__ import annotations

from handcart.backends.can.bench.bench_bus import BenchBus


def plug_in(bus: BenchBus) -> None:
    """Connect the cable again: the interface sends the frames that it held back meanwhile."""
    held = list(bus.held)
    bus.held.clear()
    bus.holds = False
    for frame in held:
        bus.send(frame)
