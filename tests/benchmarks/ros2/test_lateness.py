"""What counts as a good loop over ROS 2."""

from __future__ import annotations

import pytest

from benchmarks.ros2.lateness import finding_of
from benchmarks.ros2.wire_rig import DROVE_TO_END


@pytest.mark.parametrize(
    ("words", "own_ms", "finding"),
    [
        (DROVE_TO_END, 4.9, ""),
        (DROVE_TO_END, None, ""),  # this system does not split the lateness
        (DROVE_TO_END, 5.1, "up to 5.1 ms too long by the loop itself; allowed: 5 ms"),
        ("the odometry (odom): its last reading is 320 ms old", 1.0, "the loop ended early"),
    ],
)
def test_a_loop_that_ended_early_or_is_late_itself_is_a_finding(
    words: str, own_ms: float | None, finding: str
) -> None:
    too_long = {} if own_ms is None else {"machine_p99_ms": 80.0, "own_p99_ms": own_ms}
    found = finding_of(words, {"too long": too_long})
    assert finding in found and bool(found) == bool(finding)
