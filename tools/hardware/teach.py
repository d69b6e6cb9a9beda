"""`handcart teach`: record a posture into a robot's file."""

from __future__ import annotations

import difflib
import math
import re
import sys
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import ArmSpec, RobotFile
    from handcart.evaluation.robot_report.postures import HandAim

ONE_OF = "needs one posture; allowed: either --joints, --hand or --from-posture"
MAX_NAMED_PAIRS = 3  # of touching links
DIRECTION_BY_WORD = {
    "ahead": (1.0, 0.0, 0.0),
    "back": (-1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}


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
    pointing: Annotated[
        str, typer.Option(help="with --hand: ahead, back, left, right, up, down, or X,Y,Z of a direction")
    ] = "ahead",
    roll: Annotated[
        float | None,
        typer.Option(
            help="with --hand: degrees about that; default: upright, any where it points up or down"
        ),
    ] = None,
    from_posture: Annotated[str | None, typer.Option(help="a posture in the file, to copy")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="only show what would change")] = False,
) -> None:
    """Write a named posture of the arm into a robot's file, and print the change.

    Comments and order of the file are kept.
    """
    from handcart.backends.description.robot_names import robot_path
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.tools.terminal.writing import write_text

    spec = load_robot(robot)
    file = robot_path(robot)
    if spec.arm is None:
        raise typer.BadParameter(f"the robot of {file} has no arm")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise typer.BadParameter(
            f"invalid name {name!r}; allowed: small letters, digits and _, such as pick_up_1"
        )
    aimed = hand is not None or pointing != "ahead" or roll is not None
    if aimed and (joints is not None or from_posture is not None):
        raise typer.BadParameter(ONE_OF)
    angles = _found(spec, _aim(hand, pointing, roll)) if aimed else _angles(spec.arm, joints, from_posture)
    _check_posture(angles, spec, spec.arm)
    before = file.read_text(encoding="utf-8")
    after = _with_posture(before, name, angles)
    lines = before.splitlines(keepends=True), after.splitlines(keepends=True)
    print("".join(difflib.unified_diff(*lines, str(file), f"{file} with {name}")), end="")
    if not dry_run:
        write_text(file, after)
    print(f"{name} {'would be' if dry_run else 'is'} recorded in {file}")


def _aim(hand: str | None, way: str, roll: float | None) -> HandAim:
    from handcart.evaluation.robot_report.postures import HandAim
    from handcart.files.suggest import suggest

    if hand is None:
        raise typer.BadParameter("the hand's position is missing; needed: --hand X,Y,Z")
    place = _triple(hand)
    if place is None:
        raise typer.BadParameter(f"invalid place {hand!r}; allowed: X,Y,Z in metres")
    direction = DIRECTION_BY_WORD.get(way) or _triple(way)
    if direction is None or not any(direction):
        hint = suggest(way, DIRECTION_BY_WORD) if direction is None else "; allowed: not all 0"
        raise typer.BadParameter(f"invalid direction {way!r}{hint}, or X,Y,Z in the base frame")
    if roll is not None and not math.isfinite(roll):
        raise typer.BadParameter(f"a roll of {roll} deg; allowed: a finite number")
    return HandAim(place, direction, roll)


def _triple(text: str) -> tuple[float, float, float] | None:
    """Return three finite numbers separated by commas; None if the text is anything else."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        return None
    return (x, y, z) if all(map(math.isfinite, (x, y, z))) else None


def _found(spec: RobotFile, aim: HandAim) -> list[float]:
    from handcart.evaluation.robot_report.postures import posture_at
    from handcart.evaluation.robot_report.self_contact import touching_words

    found = posture_at(spec, aim)
    if found.angles is not None:
        return found.angles
    at = f"the hand at {','.join(f'{item:g}' for item in aim.place)} m"
    if not found.reached:
        reach = "the reach that `handcart check` reports, or another --pointing"
        raise typer.BadParameter(f"no posture has {at}, pointing that way; allowed: {reach}")
    pairs = "; ".join(touching_words(*item) for item in found.touching[:MAX_NAMED_PAIRS])
    wrong = f"none of {found.reached} postures that have {at} is free of the robot itself: {pairs}"
    raise typer.BadParameter(f"{wrong}; allowed: another place, or `handcart check --allow`")


def _angles(arm: ArmSpec, joints: str | None, from_posture: str | None) -> list[float]:
    if (joints is None) == (from_posture is None):
        raise typer.BadParameter(ONE_OF)
    if from_posture is not None:
        return _copied(arm, from_posture)
    assert joints is not None
    count = len(arm.joints)
    try:
        return [float(part) for part in joints.split(",")]
    except ValueError:
        raise typer.BadParameter(f"invalid angles {joints!r}; allowed: {count} numbers with commas") from None


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
    _warn_of_contacts(angles, spec)


def _warn_of_contacts(angles: list[float], spec: RobotFile) -> None:
    """Print the links that touch each other in a posture, the fingers open, on stderr."""
    import numpy as np

    from handcart.evaluation.robot_report.posture_findings import opened_arm
    from handcart.robotics.manipulation.motions.collision_model import CollisionModel

    for one, other in CollisionModel(opened_arm(spec)).contacts(np.array(spec.joint_units.si(angles))):
        print(f"warning: {one} touches {other} in this posture", file=sys.stderr)


def _with_posture(text: str, name: str, angles: list[float]) -> str:
    from handcart.tools.terminal.yaml_editing import edited, flow_list, put

    posture = flow_list([round(angle, 3) + 0.0 for angle in angles])
    return edited(text, lambda data: put(data, f"arm.postures.{name}", posture))
