"""Commands that a person may use after a run has ended, ready to be pasted."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

PAGE = "report.html"
EXPLAIN, VIEW = "handcart explain {}", "handcart view {}"
RESUME = "handcart resume {}"
STEPS = {"Success": (VIEW,), "Fail": (EXPLAIN, VIEW), "GiveUp": (EXPLAIN, RESUME), "Cancelled": (RESUME,)}


def next_steps(summary: Mapping[str, Any]) -> list[str]:
    """Commands, and the run's page, by the summary of a run that has ended."""
    folder = Path(str(summary["run_dir"]))
    run = shlex.quote(str(folder))
    steps = [step.format(run) for step in STEPS.get(str(summary["outcome"]), (EXPLAIN,))]
    return [*steps, str(folder / PAGE)] if (folder / PAGE).is_file() else steps
