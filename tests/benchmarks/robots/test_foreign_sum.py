"""The last line of the benchmark that drives other people's robots."""

from __future__ import annotations

from benchmarks.robots.foreign import sum_line


def test_the_sum_counts_what_was_driven_and_names_the_rest() -> None:
    rows = [
        ["one", "kinematic", "24 of 25 places, 1 contacts, 2 false outcomes", ""],
        ["one", "mujoco", "25 of 25 places, 0 contacts, 0 false outcomes", ""],
        ["two", "check", "refused", "a mesh is missing"],
    ]
    assert sum_line(rows) == (
        "places reached: 49 of 50 (98.0 %); contacts: 1; false outcomes: 2; not driven: two refused"
    )


def test_without_any_package_nothing_was_reached() -> None:
    assert sum_line([["one", "", "skipped", ""]]).startswith("places reached: 0 of 0 (0.0 %)")
