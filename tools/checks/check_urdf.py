"""What `handcart check` tells about a URDF alone, and the robot's file that it drafts from it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.files.errors import FileError, Finding, InputError

from .check_robot import contents_lines

if TYPE_CHECKING:
    from handcart.evaluation.robot_report.outline import Outline

CHAINS = 4  # that are told


def urdf_facts(file: Path, every: bool = False, draft: Path | None = None) -> dict[str, Any]:
    """Look at a URDF: what stands in it, and what a robot's file would need.

    Args:
        file: the URDF.
        every: whether every joint, link and mesh is told, not only those of the longest chain.
        draft: where to write a first robot's file; None: nowhere.

    Raises:
        FileError: something in it is wrong.
        InputError: the draft can't be written there.
    """
    from handcart.backends.urdf.robot_parts import UrdfError
    from handcart.evaluation.robot_report.draft import draft_text
    from handcart.evaluation.robot_report.remark import grouped
    from handcart.evaluation.robot_report.urdf_report import urdf_report
    from handcart.tools.terminal.writing import write_text

    try:
        report = urdf_report(file)
    except UrdfError as error:
        raise FileError([Finding(str(file), 1, 1, str(error))]) from None
    contents, outline = report.contents, report.outline
    if draft is not None:
        write_text(draft, draft_text(outline, contents.joints, _named(file, draft)))
    return {
        "format": "URDF",
        "warnings": [str(each) for each in contents.remarks],
        "grouped": grouped(contents.remarks),
        "lines": [
            *contents_lines(contents, outline.arm, every),
            *_outline_lines(outline),
            *_next(file, draft),
        ],
        "robot": {**contents.figures(), "outline": _figures(outline)},
        **({"draft": str(draft)} if draft is not None else {}),
    }


def _named(urdf: Path, draft: Path) -> str:
    """As the draft is to name the URDF; raises InputError where it can't."""
    path = Path(os.path.relpath(urdf.resolve(), draft.parent.resolve())).as_posix()
    if path.startswith(".."):
        raise InputError(
            f"{draft} can't name {urdf}; allowed: a file in the URDF's folder or in one above it"
        )
    if draft.suffix not in (".yaml", ".yml"):
        raise InputError(f"{draft} is no robot's file; allowed: *.yaml")
    if draft.exists():
        raise InputError(f"{draft} is there already; allowed: a new file")
    return path


def _outline_lines(outline: Outline) -> list[str]:
    wheels = outline.wheels
    lines = ["a robot's file would say of it, as far as its names tell:"]
    lines.append(f"  base: {outline.root}")
    if wheels is None:
        lines.append("  drive: no two sides of wheels were found")
    else:
        radius = "unknown" if wheels.radius is None else f"{wheels.radius:.3f} m"
        sides = f"left {', '.join(wheels.left)}; right {', '.join(wheels.right)}"
        lines.append(f"  drive: {sides}; radius {radius}, tread {wheels.tread:.3f} m")
    for number, chain in enumerate(outline.chains[:CHAINS]):
        lines.append(f"  {'arm' if number == 0 else 'or'}: {', '.join(chain)}")
    if not outline.chains:
        lines.append("  arm: nothing moves but wheels")
    else:
        lines.append(f"  hand: {outline.hand}")
    if outline.fingers is not None:
        lines.append(f"  gripper: {', '.join(outline.fingers)}")
    return lines + [f"  {role}: {link}" for role, link in outline.frames.items()]


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
        "frames": dict(outline.frames),
    }


def _next(file: Path, draft: Path | None) -> list[str]:
    from .file_kinds import robots_beside

    if draft is not None:
        return [f"written to {draft}; next: handcart check {draft}"]
    beside = robots_beside(file)
    if beside:
        return [f"{each} names it: handcart check {each}" for each in beside]
    return [f"a first one: handcart check {file} --draft {file.parent / 'robot.yaml'}"]
