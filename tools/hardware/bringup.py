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
    ros2: Annotated[
        bool, typer.Option("--ros2", help="bring up a robot that speaks ROS 2, by its topics")
    ] = False,
    wrong: Annotated[
        list[str] | None,
        typer.Option("--wrong", help="with --ros2: NAME=FACTOR: the bench's robot differs, as joint_3=-1"),
    ] = None,
    folder: Annotated[Path, typer.Option(help="the records' folder is made in there")] = Path("bringup"),
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Do the next step of bringing up a new robot, a procedure from the first power-on to the first task.

    Each step is recorded, and none can be skipped.
    """
    from handcart.tools.terminal.writing import check_folder

    if wrong and not (ros2 and bench):
        raise typer.BadParameter("--wrong goes with --ros2 and --bench only")
    check_folder(folder)
    ladder = _ladder(robot, bench, task, _operator(bench, answers), folder, (camera, ros2, wrong or []))
    site = ladder.site
    if again is not None:
        ladder.again(again)
    climbed = _climb(ladder, everything) if not status else []
    done = ladder.records()
    failed = [item for item in climbed if not item.passed]
    if as_json:
        _print_json(ladder, done, climbed)
    else:
        for rung in ladder.rungs[len(done) :]:
            print(f"  {rung.name}: {rung.summary}" + ("  <- next" if rung is ladder.next else ""))
        print(f"{len(done)} of {len(ladder.rungs)} steps passed; records in {site.folder}")
    sys.exit(4 if failed else 0)


def _ladder(
    robot: str,
    bench: str | None,
    task: Path | None,
    operator: Operator,
    folder: Path,
    how: tuple[bool, bool, list[str]],
) -> Ladder:
    """Return the steps of a robot.

    `how` holds whether the bench's camera is calibrated, whether ROS 2 drives the robot, and the differences
    of the bench's robot from its file as NAME=FACTOR.
    """
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.registry import bench_class
    from handcart.backends.ros2.bench.robot_differences import RobotDifferences
    from handcart.evaluation.bringup.ladder import ALL_RUNGS, Ladder
    from handcart.evaluation.bringup.ros.procedure import ROS_RUNGS
    from handcart.evaluation.bringup.ros.ros_site import RosSite
    from handcart.evaluation.bringup.site import Site
    from handcart.evaluation.trials.rig import LIBRARY_FOLDER

    camera, ros2, wrong = how
    spec = load_robot(robot)
    for_what = task or LIBRARY_FOLDER.parent / ("return_book" if spec.arm else "drive_map") / "task.yaml"
    name = re.sub(r"[^\w.-]", "_", robot.removesuffix(".yaml").strip("./")) + ("-ros2" if ros2 else "")
    rehearsed = folder / f"{name}-bench"
    kind = RosSite if ros2 else Site
    site = kind(
        robot,
        spec,
        operator,
        rehearsed if bench else folder / name,
        for_what,
        bench or "",
        LIBRARY_FOLDER / "world.yaml" if bench else None,
        camera,
    )
    if bench is not None:
        bench_class(bench, site.backend_name)  # a wrong name is refused before the first rung
    if isinstance(site, RosSite):
        site.differences = RobotDifferences.read(wrong, spec, site.spec)
    return Ladder(site, None if bench else rehearsed, ROS_RUNGS if ros2 else ALL_RUNGS)


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
        "climbed": [record.rung for record in done],
        "next": ladder.next.name if ladder.next else None,
        "tried": [record.model_dump(mode="json") for record in climbed],
    }
    print(orjson.dumps(summary).decode())
