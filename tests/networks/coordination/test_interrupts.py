"""Ctrl-C and signals to end: before, in and after a run, and inside of libraries."""

from __future__ import annotations

import signal
from contextlib import suppress

import pytest

from handcart.networks.coordination.interrupts import Interrupts

KINDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.mark.parametrize("kind", KINDS)
def test_interrupt_before_a_run_ends_it_and_handlers_are_restored(kind: signal.Signals) -> None:
    """K3"""
    before = signal.getsignal(kind)
    with pytest.raises(KeyboardInterrupt), Interrupts():
        signal.raise_signal(kind)
    assert signal.getsignal(kind) is before


@pytest.mark.parametrize("kind", KINDS)
def test_in_a_run_it_is_a_stop_however_often_it_comes(kind: signal.Signals) -> None:
    """K3: a terminal that is closed is one too."""
    stops: list[signal.Signals] = []
    with Interrupts() as interrupts:
        assert not interrupts.came
        interrupts.stop_by(lambda: stops.append(kind))
        for _ in range(3):
            signal.raise_signal(kind)
    assert interrupts.came
    assert stops == 3 * [kind]


def test_one_that_a_library_takes_for_an_error_of_its_own_is_one() -> None:
    """K3: C code reported "expected sequence" for a generator in which the signal came."""
    with pytest.raises(KeyboardInterrupt), Interrupts():
        try:
            signal.raise_signal(signal.SIGTERM)
        except KeyboardInterrupt:
            raise TypeError("expected sequence") from None


def test_one_that_a_library_swallowed_stops_the_run_that_begins() -> None:
    """K3"""
    stops: list[str] = []
    with Interrupts() as heard:
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        heard.stop_by(lambda: stops.append("stop"))
    assert stops == ["stop"]


def test_an_error_without_one_stays_an_error() -> None:
    with pytest.raises(TypeError), Interrupts():
        raise TypeError("expected sequence")
