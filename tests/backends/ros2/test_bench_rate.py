"""A bench of topics that says when the machine is too slow for it."""

from __future__ import annotations

import pytest

from handcart.backends.ros2.bench.bench_rate import BenchRate


@pytest.mark.parametrize(("rate_hz", "count"), [(20.0, 0), (17.0, 0), (3.5, 1)])
def test_a_slow_bench_says_once_that_the_machine_is_too_slow(rate_hz: float, count: int) -> None:
    rate = BenchRate(0.05)
    said = [words for step in range(600) if (words := rate.note(step / rate_hz))]
    assert len(said) == count
    assert all("the bench makes 3.5 periods a second; needed: 20" in words for words in said)
