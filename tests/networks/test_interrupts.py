"""Ctrl-C, before, in and after a run."""

from __future__ import annotations

import signal

import pytest

from handcart.networks.interrupts import Interrupts


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_before_a_run_it_is_a_keyboard_interrupt_then_a_stop(kind):
    """K3: however often it comes; a terminal that is closed is one too."""
    stops = []
    before = signal.getsignal(kind)
    with Interrupts() as interrupts:
        assert not interrupts.came
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(kind)
        interrupts.stop_by(lambda: stops.append(kind))
        for _ in range(3):
            signal.raise_signal(kind)
    assert interrupts.came
    assert stops == 3 * [kind]
    assert signal.getsignal(kind) is before
