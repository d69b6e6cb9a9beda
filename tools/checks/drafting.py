"""Writing a first robot's file for a URDF, and the URDF of a xacro file beside it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from handcart.files.errors import FileError, InputError

if TYPE_CHECKING:
    from handcart.evaluation.robot_report.urdf_report import UrdfReport


def write_draft(draft: Path, urdf: Path, report: UrdfReport) -> None:
    """Write a first draft of a robot's file for a URDF.

    Optional sections that are wrong for this URDF become comments with the reason.

    Args:
        draft: the file to write.
        urdf: the URDF that the robot's file names.
        report: report on the URDF.

    Raises:
        InputError: the file cannot be written, or cannot name the URDF.
    """
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.evaluation.robot_report.drafting.draft import OPTIONAL_SECTIONS, draft_text
    from handcart.evaluation.robot_report.mount_remarks import hidden_links, whole_degrees
    from handcart.tools.terminal.writing import write_text

    name, left_out = _named(urdf, draft), dict[str, str]()
    for _ in range(len(OPTIONAL_SECTIONS) + 1):
        text = draft_text(report.outline, report.text, name, left_out)
        write_text(draft, text)
        try:
            robot = load_robot(str(draft))
        except FileError as error:
            wrong = _optional_faults(text, error)
            if not wrong.keys() - left_out.keys():
                return  # `check` of the draft reports the rest
            left_out |= wrong
        else:
            hidden = {link: whole_degrees(sector) for link, sector in hidden_links(robot)}
            if hidden:
                write_text(draft, draft_text(report.outline, report.text, name, left_out, hidden))
            return


def write_expanded(file: Path, draft: Path) -> Path:
    """Write the URDF that xacro makes of a file; return its path, in the folder of the draft.

    Args:
        file: the xacro file.
        draft: path of the robot's file that will be drafted; it must not exist yet.

    Raises:
        FileError: xacro rejects the file, or is not installed.
        InputError: the URDF or the draft exists already, or cannot be written there.
    """
    from handcart.tools.terminal.writing import write_text

    from .xacro_expansion import expanded

    _check_new(draft)
    target = draft.parent / f"{file.name.removesuffix('.xacro').removesuffix('.urdf')}.urdf"
    if target.exists():
        raise InputError(f"{target} is there already; allowed: a folder without it for the draft")
    write_text(target, expanded(file))
    return target


def _optional_faults(text: str, error: FileError) -> dict[str, str]:
    """Return the faults of sections that a draft can do without, by their names."""
    from handcart.evaluation.robot_report.drafting.draft import OPTIONAL_SECTIONS

    lines, found = text.splitlines(), dict[str, str]()
    for finding in error.findings:
        line = lines[finding.line - 1].strip() if 0 < finding.line <= len(lines) else ""
        section = next(
            (
                optional_section
                for optional_section in OPTIONAL_SECTIONS
                if line.startswith(f"{optional_section}:")
            ),
            None,
        )
        if section is not None:
            found[section] = " ".join(finding.message.split())
    return found


def _check_new(draft: Path) -> None:
    if draft.suffix not in (".yaml", ".yml"):
        raise InputError(f"{draft} is not a robot's file; allowed: *.yaml")
    if draft.exists():
        raise InputError(f"{draft} is there already; allowed: a new file")


def _named(urdf: Path, draft: Path) -> str:
    """Return the URDF's name in the draft: its relative path, or its package and path.

    Raises:
        InputError: neither is possible.
    """
    from handcart.backends.urdf.packages import package_of

    path = Path(os.path.relpath(urdf.resolve(), draft.parent.resolve())).as_posix()
    if path.startswith(".."):
        package = package_of(urdf)
        if package is None:
            allowed = "a file in the URDF's folder or in one above it, or a URDF in a package"
            raise InputError(f"{draft} can't name {urdf}; allowed: {allowed}")
        path = package
    _check_new(draft)
    return path
