"""`handcart teach`: record a posture into a robot's file."""

from __future__ import annotations

import difflib
import re
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import ArmSpec, RobotFile


def teach(
    name: Annotated[
        str,
        typer.Argument(
            help="of the posture; PICK_UP plays back pick_up_1, pick_up_2 ..., INSERT insert_1 ..."
        ),
    ],
    robot: Annotated[str, typer.Option(help="the robot's YAML file, or a shipped robot")],
    joints: Annotated[
        str | None, typer.Option(help="joint angles in degrees, of joints that slide mm: 10,20.5,-30,...")
    ] = None,
    hand: Annotated[
        str | None, typer.Option(help="X,Y,Z in metres: where the hand is to be, upright and pointing ahead")
    ] = None,
    from_posture: Annotated[str | None, typer.Option(help="a posture in the file, to copy")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="only show what would change")] = False,
) -> None:
    """Record a posture into a robot's file, comments and order kept; shows the change."""
    from handcart.backends.description.robot_loading import load_robot
    from handcart.backends.description.robot_names import robot_path
    from handcart.tools.terminal.writing import write_text

    spec = load_robot(robot)
    file = robot_path(robot)
    if spec.arm is None:
        raise typer.BadParameter(f"the robot of {file} has no arm")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise typer.BadParameter(
            f"{name!r} is no name; allowed: small letters, digits and _, such as pick_up_1"
        )
    angles = _found(spec, hand, joints, from_posture) if hand else _angles(spec.arm, joints, from_posture)
    _check_posture(angles, spec, spec.arm)
    before = file.read_text(encoding="utf-8")
    after = _with_posture(before, name, angles)
    lines = before.splitlines(keepends=True), after.splitlines(keepends=True)
    print("".join(difflib.unified_diff(*lines, str(file), f"{file} with {name}")), end="")
    if not dry_run:
        write_text(file, after)
    print(f"{name} {'would be' if dry_run else 'is'} recorded in {file}")


def _found(spec: RobotFile, hand: str, joints: str | None, from_posture: str | None) -> list[float]:
    from handcart.evaluation.robot_report.postures import posture_at

    if joints is not None or from_posture is not None:
        raise typer.BadParameter("what is the posture? allowed: either --joints, --hand or --from-posture")
    try:
        x, y, z = (float(each) for each in hand.split(","))
    except ValueError:
        raise typer.BadParameter(f"{hand!r} is no place; allowed: X,Y,Z in metres") from None
    angles = posture_at(spec, (x, y, z))
    if angles is None:
        wrong = f"no posture has the hand at {hand} m, free of the robot itself"
        raise typer.BadParameter(f"{wrong}; allowed: what `handcart check` tells of its reach")
    return angles


def _angles(arm: ArmSpec, joints: str | None, from_posture: str | None) -> list[float]:
    if (joints is None) == (from_posture is None):
        raise typer.BadParameter("what is the posture? allowed: either --joints, --hand or --from-posture")
    if from_posture is not None:
        return _copied(arm, from_posture)
    assert joints is not None
    count = len(arm.joints)
    try:
        return [float(each) for each in joints.split(",")]
    except ValueError:
        raise typer.BadParameter(f"{joints!r} are no angles; allowed: {count} numbers with commas") from None


def _copied(arm: ArmSpec, posture: str) -> list[float]:
    from handcart.files.suggest import suggest

    if posture not in arm.postures:
        raise typer.BadParameter(f"unknown posture {posture!r}{suggest(posture, arm.postures)}")
    return list(arm.postures[posture])


def _check_posture(angles: list[float], spec: RobotFile, arm: ArmSpec) -> None:
    from handcart.backends.description.robot_findings import posture_faults

    faults = posture_faults(spec.arm_model(), spec.joint_units, tuple(angles))
    if faults:
        raise typer.BadParameter("; ".join(faults))


def _with_posture(text: str, name: str, angles: list[float]) -> str:
    from handcart.tools.terminal.yaml_editing import edited, flow_list, put

    posture = flow_list([round(angle, 3) for angle in angles])
    return edited(text, lambda data: put(data, f"arm.postures.{name}", posture))
