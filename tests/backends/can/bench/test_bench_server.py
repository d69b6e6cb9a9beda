"""A bench that lives by itself: its time is that of SYNCs, and of the clock where none come."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bench.bench_server import BenchServer
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile


@pytest.fixture
def bench(cart: RobotFile) -> Iterator[Bench]:
    assert cart.can is not None
    made = Bench(cart, cart.can, None)
    yield made
    made.close()


def drive(backend: Any, server: BenchServer, clock: Any, periods: int, speed: float) -> None:
    base = backend.get(Base)
    for _ in range(periods):
        clock.now += backend.period
        base.drive(speed, 0.0)
        backend.step()
        server.catch_up()


def test_each_sync_is_a_period(cart: RobotFile, bench: Bench, clock: Any) -> None:
    backend: Any
    with CanBackend(cart, bench) as backend:
        seen: list[float] = []
        server = BenchServer(bench, cart.period_s, clock, lambda item: seen.append(item.time))
        drive(backend, server, clock, 20, 0.2)
        assert len(seen) == 20
        assert bench.time == pytest.approx(20 * cart.period_s)


def test_without_syncs_time_goes_by_the_clock(cart: RobotFile, bench: Bench, clock: Any) -> None:
    server = BenchServer(bench, cart.period_s, clock)
    for _ in range(100):
        clock.now += 0.01
        server.catch_up()
    assert bench.time == pytest.approx(1.0, abs=0.011)
    clock.now += 60.0  # a machine that slept doesn't make it all up
    server.catch_up()
    assert bench.time < 2.0


def test_k1_drives_stop_by_themselves_when_the_program_is_gone(
    cart: RobotFile, bench: Bench, clock: Any
) -> None:
    """K1: all drives are at rest heartbeat time and ramp after the last sign of life, and stay so."""
    assert cart.can is not None
    backend: Any
    with CanBackend(cart, bench) as backend:
        server = BenchServer(bench, cart.period_s, clock)
        drive(backend, server, clock, 40, 0.4)
        ramp = 0.4 / backend.axes.left.limits.braking
        drives = bench.drives.values()
        assert all(item.velocity != 0.0 for item in drives)
        gone, stood = clock.now, None
        while clock.now < gone + 2.0:
            clock.now += 0.005
            server.catch_up()
            if all(item.velocity == 0.0 for item in drives):
                stood = stood or clock.now
            else:
                assert stood is None
        assert stood is not None
        assert stood - gone <= cart.can.heartbeat_timeout_ms / 1e3 + ramp + 0.02
        assert all(item.life.state != "OPERATION ENABLED" for item in drives)
