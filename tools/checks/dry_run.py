"""`handcart run --dry-run` and `--script`: the actions that a run would do, without a robot."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

EXIT_STATUS = {"Success": 0, "Fail": 3, "GiveUp": 4}


def dry_run(
    task: Path,
    backend: str | None,
    settings: Sequence[str],
    seed: int,
    situation: str | None,
    script: Path | None,
    as_json: bool,
) -> int:
    """Check a task with all its files, print the actions of a run without a robot, and return the exit
    status.

    Args:
        task: the task's file.
        backend: another backend than the task names; None: the task's.
        settings: parameters of the task, `KEY=VALUE` each.
        seed: seed of a run.
        situation: situation in which the run begins; None: the task's start.
        script: file with the outcomes that the actions shall have; None: each action succeeds.
        as_json: True to print one JSON object instead of lines.

    Raises:
        FileError: the task's files have faults; the error contains all of them.
    """
    import orjson

    from handcart.backends.loading.robot_loading import load_robot
    from handcart.evaluation.robot_report.posture_findings import posture_findings
    from handcart.files.errors import FileError
    from handcart.files.models.settings import split_settings
    from handcart.networks.coordination.script import follow, load_script
    from handcart.networks.task.preparing import check

    outcomes = None if script is None else load_script(script)
    chosen = split_settings(settings)
    checked = check(task, backend, chosen, seed, situation)
    network, robot = checked.task.network, checked.task.robot
    places = list(checked.place_lines())
    if checked.errors:
        print("\n".join([] if as_json else places), end="" if as_json else "\n")
        raise FileError(checked.errors)
    doubts = [*checked.warnings, *map(str, posture_findings(robot, load_robot(robot)))]
    imagined = follow(network, outcomes.outcomes if outcomes else ())
    if as_json:
        rooms = [item.for_programs() for item in checked.places]
        print(orjson.dumps({**imagined.summary(), "places": rooms, "warnings": doubts}).decode())
    else:
        for line in imagined.lines:
            print(line)
        print(
            f"{imagined.outcome} in situation {imagined.situation}{imagined.reason and ': '}{imagined.reason}"
        )
        print(f"imagined: nothing has moved; a real run takes at most {network.bound()} actions")
        print("\n".join(places), end="\n" if places else "")
        for doubt in doubts:
            print(f"warning: {doubt}")
    return EXIT_STATUS[imagined.outcome]
