"""`handcart replay`: today's code on a past run, its decisions or its readings."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from handcart.networks.past_runs.past_run import PastRun

DIFFERENT_STATUS = 3


def replay(
    run: Annotated[
        Path | None, typer.Argument(help="a run's folder, or an archive of it (default: runs/latest)")
    ] = None,
    sensors: Annotated[
        bool, typer.Option("--sensors", help="give the recorded readings: the commands must be the same")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Compute the decisions of a past run again with the present code; the exit status is 3 at the first
    difference.

    Without an option, actions have the outcomes in the run's journal. With `--sensors`, the complete program
    runs on the recorded readings of a run that was made with `handcart run --record-sensors`.
    """
    import orjson

    from handcart.files.printable import printable
    from handcart.networks.past_runs.past_run import read_run
    from handcart.networks.run_files.run_archive import opened_run
    from handcart.networks.run_files.run_names import latest_run

    with ExitStack() as stack:
        folder = stack.enter_context(opened_run(run or latest_run(Path("runs"))))
        past = read_run(folder)
        words, facts = _sensors(past) if sensors else _decisions(past)
    if as_json:
        print(orjson.dumps(facts, option=orjson.OPT_INDENT_2).decode())
    else:
        print(printable(words))
    sys.exit(0 if facts["equal"] else DIFFERENT_STATUS)


def _decisions(past: PastRun) -> tuple[str, dict[str, Any]]:
    from handcart.networks.past_runs.decision_replay import replay_decisions
    from handcart.networks.run_files.run_folder import NoRun

    found = replay_decisions(past)
    if found is None:
        raise NoRun(past.folder, "its journal does not keep the action network")
    counts = f"{found.plans} plans and {found.actions} actions are the same"
    facts = {"plans": found.plans, "actions": found.actions}
    if found.difference is None:
        return counts, {"equal": True, **facts, "difference": None}
    words = f"{counts}, then {found.difference.words()}"
    return words, {"equal": False, **facts, "difference": asdict(found.difference)}


def _sensors(past: PastRun) -> tuple[str, dict[str, Any]]:
    from handcart.evaluation.sensor_replay.sensor_replay import replay_sensors

    found = replay_sensors(past)
    counts = (
        f"{found.periods} periods, {found.readings} readings: {found.commands} commands are the same "
        f"to the last bit, {found.actions} actions end the same"
    )
    facts = {"equal": not found.difference, **asdict(found), "difference": found.difference or None}
    return f"{counts}{f'; then {found.difference}' if found.difference else ''}", facts
