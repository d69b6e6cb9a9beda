"""Places as near to walls as `check` allows: a small sample of the benchmark's worlds."""

from __future__ import annotations

import pytest

from benchmarks.driving.near_walls import report, try_world


@pytest.mark.slow
@pytest.mark.parametrize("seed", [8, 11])
def test_what_check_calls_reachable_is_reached_without_contact(seed: int) -> None:
    result = try_world(seed, nearer=False)
    assert (result.contacts, result.wrongly) == ([], [])
    assert result.stood
    assert [item.reason for item in result.stood if not item.reached] == []
    assert f"{len(result.stood)} places driven to, 0 not reached, 0 contacts" in report(
        [result], nearer=False
    )


@pytest.mark.slow
def test_what_check_refuses_is_not_driven_to() -> None:
    result = try_world(2, nearer=True)
    assert result.contacts == []
    assert {item.reason.split(" at ")[0] for item in result.stood} == {"the base can't stand"}
