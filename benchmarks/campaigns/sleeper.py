"""A trial that takes 50 ms and imports almost nothing: the rest is the cost of the campaign itself."""

from __future__ import annotations

import time

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.trial_log import line_of

SLEEPS_S = 0.05


def sleep(seed: int) -> Trial:
    """Sleep for the trial's time, so that two trials need no second core."""
    time.sleep(SLEEPS_S)
    return Trial(seed, 0, {"outcome": "Success", "reason": "", "seed": seed, "metrics": {}})


def sleep_there(seed: int) -> bytes:
    """Run the same trial on a cluster."""
    return line_of(sleep(seed))
