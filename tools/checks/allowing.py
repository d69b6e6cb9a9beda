"""Writing into a robot's file which pairs of its links may touch."""

from __future__ import annotations

import difflib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence


def allow_contacts(file: Path) -> None:
    """Add all pairs of links that touch in every posture of the arm to a robot's file, as allowed contacts.

    The changes are printed to stderr.

    Args:
        file: path of the robot's file.

    Raises:
        FileError: the robot's files are invalid.
        NotWritable: the file cannot be written.
    """
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.evaluation.robot_report.self_contact import self_contact
    from handcart.tools.terminal.writing import write_text

    robot = load_robot(str(file))
    pairs = [] if robot.arm is None else self_contact(robot.arm_model()).always
    if not pairs:
        print("no pair of links touches in every posture of the arm: no pair was added", file=sys.stderr)
        return
    before = file.read_text(encoding="utf-8")
    after = _with_pairs(before, pairs)
    lines = before.splitlines(keepends=True), after.splitlines(keepends=True)
    print("".join(difflib.unified_diff(*lines, str(file), f"{file}, allowed")), end="", file=sys.stderr)
    write_text(file, after)


def _with_pairs(text: str, pairs: Sequence[tuple[str, str]]) -> str:
    from handcart.tools.terminal.yaml_editing import edited, flow_list, put

    def change(data: Any) -> None:
        if not data.get("allowed_contacts"):
            put(data, "allowed_contacts", [])
        data["allowed_contacts"] += [flow_list(list(pair)) for pair in pairs]

    return edited(text, change)
