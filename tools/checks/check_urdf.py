"""Report of `handcart check` on a URDF alone, and the draft of a robot's file from it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.files.errors import FileError, Finding

from .check_robot import contents_lines

if TYPE_CHECKING:
    from collections.abc import Sequence

    from handcart.evaluation.robot_report.outline import Outline

MAX_CHAINS = 4
MAX_NAMED_JOINTS = 3


def urdf_facts(file: Path, every: bool = False, draft: Path | None = None) -> dict[str, Any]:
    """Check a URDF: report its contents, and the values that a robot's file would need.

    Args:
        file: the URDF.
        every: True to list every joint, link and mesh, not only those of the longest chain of joints.
        draft: path to which a first draft of a robot's file is written; None: no draft.

    Raises:
        FileError: the URDF is invalid.
        InputError: the draft cannot be written to this path.

    A xacro file is written as a URDF next to the draft, if there is a draft.
    """
    from handcart.backends.urdf.robot_parts import UrdfError
    from handcart.evaluation.robot_report.remark import grouped
    from handcart.evaluation.robot_report.urdf_report import urdf_report

    from .drafting import write_draft, write_expanded
    from .xacro_expansion import is_xacro

    given = file
    if draft is not None and is_xacro(file):
        file = write_expanded(file, draft)
    try:
        report = urdf_report(file)
    except UrdfError as error:
        raise FileError([Finding(str(file), 1, 1, str(error))]) from None
    contents, outline = report.contents, report.outline
    if draft is not None:
        write_draft(draft, file, report)
    return {
        "format": "URDF",
        "warnings": [str(remark) for remark in contents.remarks],
        "grouped": grouped(contents.remarks),
        "lines": [
            *([f"expanded into {file}"] if file != given else ()),
            *contents_lines(contents, outline.arm, every),
            *_outline_lines(outline),
            *_next(file, draft),
        ],
        "robot": {**contents.figures(), "outline": _figures(outline)},
        **({"draft": str(draft)} if draft is not None else {}),
    }


def _outline_lines(outline: Outline) -> list[str]:
    wheels = outline.wheels
    lines = ["proposal for a robot's file, by the names in the URDF:"]
    lines.append(f"  base: {outline.root}")
    if wheels is None:
        lines.append("  drive: no two sides of wheels were found")
    else:
        radius = "unknown" if wheels.radius is None else f"{wheels.radius:.3f} m"
        sides = f"left {', '.join(wheels.left)}; right {', '.join(wheels.right)}"
        lines.append(f"  drive: {sides}; radius {radius}, tread {wheels.tread:.3f} m")
    for number, chain in enumerate(outline.chains[:MAX_CHAINS]):
        lines.append(f"  {'arm' if number == 0 else 'or'}: {', '.join(chain)}")
    if not outline.chains:
        lines.append("  arm: nothing moves but wheels")
    else:
        lines.append(f"  hand: {outline.hand}")
    if outline.fingers is not None:
        lines.append(f"  gripper: {', '.join(outline.fingers)}")
    if outline.turning_fingers:
        lines.append(f"  no gripper: {_some(outline.turning_fingers)} turn; fingers have to slide")
    for role, found in outline.sensors.items():
        onto = "the hand" if role == "camera" else "the base"
        moves = f" (can't be used: {_some(found.between)} between it and {onto})" if found.between else ""
        lines.append(f"  {role}: {found.link}{moves}")
    return lines


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:MAX_NAMED_JOINTS]) + (" ..." if len(names) > MAX_NAMED_JOINTS else "")


def _figures(outline: Outline) -> dict[str, Any]:
    wheels = outline.wheels
    return {
        "base": outline.root,
        "drive": None
        if wheels is None
        else {
            "left": wheels.left,
            "right": wheels.right,
            "tread_m": wheels.tread,
            "wheel_radius_m": wheels.radius,
        },
        "chains": outline.chains,
        "hand": outline.hand if outline.arm else None,
        "fingers": outline.fingers,
        "turning_fingers": outline.turning_fingers,
        "frames": dict(outline.frames),
    }


def _next(file: Path, draft: Path | None) -> list[str]:
    from .file_kinds import robots_beside

    if draft is not None:
        return [f"written to {draft}; next: handcart check {draft}"]
    beside = robots_beside(file)
    if beside:
        return [f"{path} names it: handcart check {path}" for path in beside]
    return [f"a first one: handcart check {file} --draft {file.parent / 'robot.yaml'}"]
