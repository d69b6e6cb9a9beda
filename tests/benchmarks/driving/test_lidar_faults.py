"""Sums of the benchmarks of faulty lidars and of other people's robots."""

from __future__ import annotations

from benchmarks.driving.lidar_faults import sum_line, task_lines, went_wrong
from handcart.evaluation.campaigns.data.trial import Trial


def trial(status: int, outcome: str, contacts: int = 0, untrue: tuple[str, ...] = ()) -> Trial:
    metrics = {"contacts_unmeant": contacts, "untrue": list(untrue)}
    return Trial(1, status, {"outcome": outcome, "reason": "blocked", "metrics": metrics})


def test_the_sum_names_share_false_outcomes_and_contacts() -> None:
    trials = [
        trial(0, "Success"),
        trial(0, "Success", 2),
        trial(0, "Success", 0, ("a", "b")),
        trial(3, "Fail"),
    ]
    assert sum_line(trials) == (
        "Success in 3 of 4 runs (75.0 %); with false outcomes: 1; with unintended contacts: 1"
    )
    assert list(map(went_wrong, trials)) == [False, True, True, True]
    row, end = task_lines("drive_map", trials)
    assert row.split() == ["drive_map", "3", "/", "4", "1", "1"]
    assert end.strip() == "1 x Fail: blocked"


def test_the_sum_of_no_run_is_no_success() -> None:
    assert sum_line([]).startswith("Success in 0 of 0 runs (0.0 %)")
