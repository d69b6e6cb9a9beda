"""`handcart robot --from-ros`: a first robot's file from a robot that is on the air."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.backends.ros2.air_check.air_description import AirDescription


def robot(
    file: Annotated[Path, typer.Argument(help="robot's file to write; its URDF is written beside it")],
    from_ros: Annotated[
        bool, typer.Option("--from-ros", help="by robot_description, the topics and the SRDF on the air")
    ] = False,
    namespace: Annotated[str, typer.Option(help="namespace of the robot's topics")] = "",
    domain: Annotated[int | None, typer.Option(help="ROS domain (default: by ROS_DOMAIN_ID)")] = None,
    seconds: Annotated[float, typer.Option(min=0.5, help="time to listen")] = 5.0,
    bench: Annotated[
        str | None, typer.Option(help="listen to a bench of this robot in this process instead")
    ] = None,
) -> None:
    """Write a first draft of a robot's file from the topics that the robot publishes.

    Values that still have to be measured or chosen are marked.
    """
    from handcart.files.errors import InputError
    from handcart.tools.terminal.writing import check_folder

    if not from_ros:
        raise typer.BadParameter(
            "needed: --from-ros; `handcart new robot` and `check URDF --draft` begin otherwise"
        )
    if bench is not None and (namespace or domain is not None):
        words = "--namespace" if namespace else "--domain"
        raise typer.BadParameter(f"{words} with --bench; allowed: one of them, a bench is in this process")
    if file.suffix not in (".yaml", ".yml"):
        raise InputError(f"{file} is not a robot's file; allowed: *.yaml")
    urdf, srdf = file.with_suffix(".urdf"), file.with_suffix(".srdf")
    for item in (file, urdf, srdf):
        if item.exists():
            raise InputError(f"{item} is there already; allowed: a folder without it")
    check_folder(file.parent)
    _write(file, urdf, srdf, _description(namespace, domain, seconds, bench))
    print(f"written to {file}, its URDF beside it; next: handcart check {file} --ros2")


def _description(namespace: str, domain: int | None, seconds: float, bench: str | None) -> AirDescription:
    from handcart.backends.description.ros_spec import RosSpec
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.registry import bench_class
    from handcart.backends.ros2.air_check.air_description import describe_air
    from handcart.backends.ros2.air_check.connected import connected
    from handcart.backends.ros2.wire.ros_errors import NoTopics
    from handcart.evaluation.trials.rig import LIBRARY_FOLDER

    if bench is None:
        with connected(None, RosSpec(namespace=namespace, domain=domain)) as (link, wait):
            return describe_air(link, wait, seconds, namespace)
    spec = load_robot(bench)
    if spec.ros2 is None:
        raise NoTopics(spec.folder)
    inner = bench_class("kinematic", "ros2").build(spec, LIBRARY_FOLDER / "world.yaml", 0)
    with connected(spec, spec.ros2, inner) as (link, wait):
        return describe_air(link, wait, seconds)


def _write(file: Path, urdf: Path, srdf: Path, air: AirDescription) -> None:
    """Write URDF, SRDF and the robot's file."""
    from handcart.backends.urdf.robot_parts import UrdfError
    from handcart.evaluation.robot_report.drafting.ros_draft import with_air
    from handcart.evaluation.robot_report.urdf_report import urdf_report
    from handcart.files.errors import FileError, Finding
    from handcart.tools.checks.drafting import write_draft
    from handcart.tools.terminal.writing import write_text

    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(urdf, air.urdf)
    try:
        report = urdf_report(urdf)
    except UrdfError as error:
        raise FileError([Finding(str(urdf), 1, 1, str(error))]) from None
    write_draft(file, urdf, report)
    if air.srdf:
        write_text(srdf, air.srdf)
    text = file.read_text(encoding="utf-8")
    write_text(file, with_air(text, air, report.outline, srdf.name if air.srdf else ""))
