"""Commands that a person may use after a run has ended, ready to be pasted."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from handcart.files.shown_path import shown_path
from handcart.networks.run_files.run_names import REPORT_FILE

EXPLAIN, VIEW = "handcart explain {}", "handcart view {}"
RESUME_COMMAND = "handcart resume {}"
STEPS_BY_OUTCOME = {
    "Success": (VIEW,),
    "Fail": (EXPLAIN, VIEW),
    "GiveUp": (EXPLAIN, RESUME_COMMAND),
    "Cancelled": (RESUME_COMMAND,),
}


def ended_words(summary: Mapping[str, Any]) -> str:
    """Return a line of text with a run's outcome, situation, reason and folder, taken from its summary."""
    reason = f": {summary['reason']}" if summary["reason"] else ""
    ended = f"{summary['outcome']} in situation {summary['situation']}{reason}"
    if summary["outcome"] == "Cancelled":
        kept = f"the state of the run is kept in {shown_path(summary['run_dir'])}"
        return f"{ended}; the robot has stopped, {kept}; to resume:"
    return f"{ended}; see {shown_path(summary['run_dir'])}"


def next_steps(summary: Mapping[str, Any]) -> list[str]:
    """Return commands that may be useful after a run, then the path of its report page, if it exists.

    `summary` is the run's summary, with its folder and outcome.
    """
    folder = Path(str(summary["run_dir"]))
    run = shlex.quote(str(folder))
    steps = [step.format(run) for step in STEPS_BY_OUTCOME.get(str(summary["outcome"]), (EXPLAIN,))]
    return [*steps, str(folder / REPORT_FILE)] if (folder / REPORT_FILE).is_file() else steps
