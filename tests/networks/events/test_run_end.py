"""The end of a run as programs read it."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from typing import Any

import pytest

from handcart.networks.events.run_end import RunEnd


@pytest.mark.parametrize(
    ("outcome", "status"), [("Success", 0), ("Fail", 3), ("GiveUp", 4), ("Error", 5), ("Cancelled", 130)]
)
def test_exit_status_is_the_one_that_programs_know(outcome: Any, status: int) -> None:
    assert RunEnd(outcome, "z", "", 1, 0, 0).exit_status == status


def test_end_of_a_run_does_not_change_any_more() -> None:
    end: Any = RunEnd("Fail", "z", "no way", 1, 0, 0)
    with pytest.raises(FrozenInstanceError):
        end.outcome = "Success"
    assert end.skipped == ()
