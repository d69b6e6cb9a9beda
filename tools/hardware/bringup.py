"""`handcart bringup`: a real robot, step by step."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from handcart.evaluation.bringup.ladder import Ladder
    from handcart.evaluation.bringup.operator import Operator
    from handcart.evaluation.bringup.record import RungRecord


def bringup(
    robot: Annotated[str, typer.Argument(help="the robot's YAML file, or a shipped robot")],
    bench: Annotated[
        str | None, typer.Option(help="rehearse on simulated drives, before this simulated backend")
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="continue until a step isn't passed")] = False,
    status: Annotated[bool, typer.Option("--status", help="show the progress, and do nothing")] = False,
    again: Annotated[
        str | None, typer.Option(help="set the records of this step and all after it aside, and do it again")
    ] = None,
    task: Annotated[Path | None, typer.Option(help="the robot's task; it is the last step")] = None,
    answers: Annotated[
        Path | None, typer.Option(help="a YAML file with answers by key, instead of a person's")
    ] = None,
    camera: Annotated[
        bool, typer.Option("--camera", help="calibrate the camera on the bench, too; takes minutes")
    ] = False,
    folder: Annotated[Path, typer.Option(help="the records' folder is made in there")] = Path("bringup"),
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Do the next step of the procedure from first power to the task; each is recorded, none is skipped."""
    from handcart.backends.can.can_backend import CanBackend
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.registry import bench_class
    from handcart.evaluation.bringup.ladder import ALL_RUNGS, Ladder
    from handcart.evaluation.bringup.site import Site
    from handcart.evaluation.trials.rig import LIBRARY_FOLDER
    from handcart.tools.terminal.writing import check_folder

    spec = load_robot(robot)
    check_folder(folder)
    if bench is not None:
        bench_class(bench, CanBackend.name)  # a wrong name is told before the first rung
    for_what = task or LIBRARY_FOLDER.parent / ("return_book" if spec.arm else "drive_map") / "task.yaml"
    name = re.sub(r"[^\w.-]", "_", robot.removesuffix(".yaml").strip("./"))
    own, rehearsed = folder / name, folder / f"{name}-bench"
    site = Site(
        robot,
        spec,
        _operator(bench, answers),
        rehearsed if bench else own,
        for_what,
        bench or "",
        LIBRARY_FOLDER / "world.yaml" if bench else None,
        camera,
    )
    ladder = Ladder(site, None if bench else rehearsed)
    if again is not None:
        ladder.again(again)
    climbed = _climb(ladder, everything) if not status else []
    done = ladder.records()
    failed = [each for each in climbed if not each.passed]
    if as_json:
        _print_json(ladder, done, climbed)
    else:
        for each in ALL_RUNGS[len(done) :]:
            print(f"  {each.name}: {each.summary}" + ("  <- next" if each is ladder.next else ""))
        print(f"{len(done)} of {len(ALL_RUNGS)} steps passed; records in {site.folder}")
    sys.exit(4 if failed else 0)


def _climb(ladder: Ladder, everything: bool) -> list[RungRecord]:
    climbed: list[RungRecord] = []
    while ladder.next is not None and (everything or not climbed):
        record = ladder.climb(ladder.site.operator.tell)
        climbed.append(record)
        result = record.facts.get("left_out") or "passed"
        ladder.site.operator.tell(f"   {result}" if record.passed else f"   not passed: {record.reason}")
        if not record.passed:
            break
    return climbed


def _operator(bench: str | None, answers: Path | None) -> Operator:
    from handcart.evaluation.bringup.operator import BenchOperator, ScriptedOperator
    from handcart.files.yaml.yaml_document import read_document
    from handcart.tools.terminal.terminal_operator import TerminalOperator

    def say(words: str) -> None:
        print(words, file=sys.stderr, flush=True)

    if answers is not None:
        if bench is None:
            raise typer.BadParameter(
                "answers from a file are for the bench; a robot needs a person beside it"
            )
        data: Any = read_document(answers).data
        return ScriptedOperator(data if isinstance(data, dict) else {}, say)
    return TerminalOperator() if bench is None else BenchOperator(say)


def _print_json(ladder: Ladder, done: list[RungRecord], climbed: list[RungRecord]) -> None:
    import orjson

    summary = {
        "folder": str(ladder.site.folder),
        "climbed": [each.rung for each in done],
        "next": ladder.next.name if ladder.next else None,
        "tried": [each.model_dump(mode="json") for each in climbed],
    }
    print(orjson.dumps(summary).decode())
