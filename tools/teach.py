"""`handcart teach`: record a posture into a robot's file."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Annotated

import typer


def teach(
    name: Annotated[
        str, typer.Argument(help="of the posture; pick_up_1, pick_up_2 ... are played by PICK_UP")
    ],
    robot: Annotated[Path, typer.Option(help="the robot's YAML file")],
    joints: Annotated[str, typer.Option(help="joint angles in degrees: 10,20.5,-30,...")],
    write: Annotated[bool, typer.Option(help="write it; otherwise only show the change")] = False,
) -> None:
    """Record a posture into a robot's file, comments and order kept; shows the change."""
    from backends.robot_file import load_robot

    spec = load_robot(str(robot))
    if spec.arm is None:
        raise typer.BadParameter("the robot has no arm")
    angles = _angles(joints, len(spec.arm.joints))
    _check_limits(angles, spec.urdf_text(), spec.arm.joints)
    before = robot.read_text(encoding="utf-8")
    after = _with_posture(before, name, angles)
    print(
        "".join(difflib.unified_diff(before.splitlines(True), after.splitlines(True), str(robot), "new")),
        end="",
    )
    if write:
        robot.write_text(after, encoding="utf-8")
        print(f"written into {robot}")
    else:
        print("nothing written; add --write to keep it")


def _angles(text: str, count: int) -> list[float]:
    try:
        angles = [float(each) for each in text.split(",")]
    except ValueError:
        raise typer.BadParameter(f"{text!r} are no angles; allowed: {count} numbers with commas") from None
    if len(angles) != count:
        raise typer.BadParameter(f"{len(angles)} angles; allowed: {count}, one for each joint")
    return angles


def _check_limits(angles: list[float], urdf: str, joints: tuple[str, ...]) -> None:
    import numpy as np

    from robotics.kinematics.arm_model import ArmModel

    arm = ArmModel(urdf, joints)
    for joint, angle, low, high in zip(
        joints, angles, np.degrees(arm.lower), np.degrees(arm.upper), strict=True
    ):
        if not low <= angle <= high:
            raise typer.BadParameter(
                f"{joint} can't stand at {angle:g} deg; allowed: {low:.1f} to {high:.1f}"
            )


def _with_posture(text: str, name: str, angles: list[float]) -> str:
    from io import StringIO

    from ruamel.yaml import YAML
    from ruamel.yaml.comments import CommentedSeq

    yaml = YAML()
    yaml.width = 110
    yaml.preserve_quotes = True
    yaml.indent(mapping=2, sequence=4, offset=2)
    data = yaml.load(text)
    posture = CommentedSeq([round(angle, 3) for angle in angles])
    posture.fa.set_flow_style()
    data["arm"]["postures"][name] = posture
    out = StringIO()
    yaml.dump(data, out)
    return out.getvalue()
