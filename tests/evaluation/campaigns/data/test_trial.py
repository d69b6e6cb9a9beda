"""Content of a trial taken from its summary."""

from __future__ import annotations

import pytest

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.networks.coordination.supervision import INTERRUPTED_REASON


@pytest.mark.parametrize(
    ("outcome", "reason", "signalled", "cancelled", "interrupted"),
    [
        ("Cancelled", INTERRUPTED_REASON, False, True, True),
        ("Cancelled", "a person stopped it", False, True, False),
        ("Cancelled", "zz", False, True, False),
        ("Success", "", True, False, True),
        ("Success", INTERRUPTED_REASON, False, False, False),
        ("GiveUp", "aa", False, False, False),
    ],
)
def test_trial_knows_who_stopped_it(
    outcome: str, reason: str, signalled: bool, cancelled: bool, interrupted: bool
) -> None:
    trial = Trial(3, 1, {"outcome": outcome, "reason": reason}, signalled=signalled)
    assert (trial.cancelled, trial.interrupted) == (cancelled, interrupted)


def test_trial_reads_its_folder_and_false_outcomes_from_the_summary() -> None:
    trial = Trial(3, 0, {"run_dir": "runs/x-7", "metrics": {"untrue": ["MOVE_TO"]}})
    assert (trial.success, trial.run_name, trial.untrue) == (True, "x-7", ["MOVE_TO"])
    other = Trial(3, 3, {"run_dir": None, "metrics": {}})
    assert (other.success, other.run_name, other.untrue) == (False, "", [])
