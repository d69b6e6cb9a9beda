"""Report of `handcart check` on a robot."""

from __future__ import annotations

import io
import math
from collections import Counter
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.files.errors import FileError, InputError
from handcart.files.printable import counted
from handcart.files.yaml.yaml_document import read_document
from handcart.tools.terminal.tables import table_of
from handcart.tools.terminal.writing import NotWritable

if TYPE_CHECKING:
    from rich.table import Table

    from handcart.evaluation.robot_report.reach import HandReach
    from handcart.evaluation.robot_report.report import Contents, RobotReport
    from handcart.robotics.kinematics.urdf_contents import JointFacts

TABLE_WIDTH_CHARS = 110
MAX_HEAVY_LINKS = 3
MAX_TOUCHING_PAIRS = 5
PICTURE_SUFFIXES = (".svg", ".png", ".pdf")


class NoSuchPicture(InputError):
    """Error, because the drawing's file has a suffix for which no picture can be drawn."""


def robot_facts(
    file: Path,
    picture: Path | None,
    quick: bool = False,
    every: bool = False,
    backend: str | None = None,
) -> dict[str, Any]:
    """Check a robot's file and return facts on the robot; draw the robot if `picture` is given.

    Args:
        file: the robot's file.
        picture: file for the drawing; None: no drawing.
        quick: True to skip the test of the arm's reach.
        every: True to list every joint, link and mesh, not only the arm's joints.
        backend: name of a simulated backend that is built with the robot as a test; None: no test.

    Raises:
        FileError: the robot's files are wrong.
        InputError: the backend refuses the robot.
        NoSuchPicture: the picture's suffix is unknown.
        NotWritable: the picture cannot be written to this path.
    """
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.evaluation.robot_report.picture import draw_robot
    from handcart.evaluation.robot_report.posture_findings import posture_findings
    from handcart.evaluation.robot_report.remark import grouped, grouped_findings
    from handcart.evaluation.robot_report.report import report_of

    from .check_backend import build_in_empty_world, engine_remarks
    from .check_bus import bus_figures, bus_of, bus_tables

    if picture is not None and picture.suffix not in PICTURE_SUFFIXES:
        raise NoSuchPicture(f"{picture}: unknown suffix of a picture; allowed: {', '.join(PICTURE_SUFFIXES)}")
    robot = load_robot(str(file))
    if backend is not None:
        build_in_empty_world(robot, backend)
    try:
        report = report_of(robot, not quick)
    except ValueError as error:
        raise FileError([read_document(file).finding(("urdf",), f"{error}; allowed: a sound URDF")]) from None
    if picture is not None:
        try:
            draw_robot(picture, robot, report.reach)
        except OSError as error:
            raise NotWritable(picture, error.strerror) from None
    bus = bus_of(robot)
    postures = list(posture_findings(str(file), robot))
    engines = [] if backend is not None or quick else engine_remarks(robot)
    return {
        "format": robot.format,
        "warnings": [*robot.warnings, *report.warnings, *map(str, postures), *engines],
        "grouped": [*grouped(report.remarks), *grouped_findings(postures), *engines],
        "lines": [*_lines(report, every), *(lines_of(*bus_tables(bus)) if bus else ())],
        "robot": {**report.figures(), **({"bus": bus_figures(bus)} if bus else {})},
        **({"picture": str(picture)} if picture is not None else {}),
    }


def contents_lines(contents: Contents, chosen: Collection[str], every: bool) -> list[str]:
    """Return the contents of a URDF as lines of text.

    Args:
        contents: joints, links and meshes of the URDF.
        chosen: names of the joints that are listed; the others are only counted.
        every: True to list each joint, link and mesh instead.
    """
    if every:
        return lines_of(*(part for table in _tables(contents) for part in (table, "")))
    rows = [_joint(joint) for joint in contents.joints if joint.name in chosen]
    others = Counter(joint.kind for joint in contents.joints if joint.name not in chosen)
    weighed = sorted(((link.mass_kg or 0.0, link.name) for link in contents.links), reverse=True)
    heaviest = ", ".join(f"{name} {mass:.3g} kg" for mass, name in weighed[:MAX_HEAVY_LINKS] if mass > 0.0)
    kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(others.items()))
    parts: list[Any] = [_joint_table(rows), ""] if rows else []
    parts += [f"other joints that move: {kinds}"] if others else []
    mass = sum(mass for mass, _ in weighed)
    parts.append(f"{counted(len(weighed), 'link')}, {mass:.3g} kg; the heaviest: {heaviest}")
    parts += [f"{len(contents.meshes)} meshes"] if contents.meshes else []
    return [*lines_of(*parts), "--all lists each joint, link and mesh", ""]


def _lines(report: RobotReport, every: bool) -> list[str]:
    """Return the report as lines for people."""
    parts: list[Any] = []
    if report.contact is not None:
        pairs = report.contact.pairs
        parts += [
            report.contact.words,
            *(f"  {pair}" for pair in (pairs if every else pairs[:MAX_TOUCHING_PAIRS])),
        ]
        parts += (
            [f"  and {len(pairs) - MAX_TOUCHING_PAIRS} pairs more"]
            if len(pairs) > MAX_TOUCHING_PAIRS and not every
            else []
        )
    if report.reach is not None:
        parts += [_reach_words(report.reach), *_domain_tables(report), ""]
    if report.camera is not None:
        camera = report.camera
        parts.append(
            f"camera: sees {camera.across_deg:.0f} by {camera.upright_deg:.0f} deg; "
            f"{camera.px_per_mm:.1f} px a mm at 0.3 m"
        )
    return [*contents_lines(report.contents, report.arm, every), *lines_of(*parts)]


def lines_of(*parts: Any) -> list[str]:
    """Return tables and lines as lines of text, as they are printed on a terminal.

    Args:
        parts: tables, and lines of text, in order.
    """
    from rich.console import Console
    from rich.text import Text

    console = Console(file=io.StringIO(), width=TABLE_WIDTH_CHARS, color_system=None)
    for part in parts:
        # A maker's name may look like markup.
        console.print(Text(part) if isinstance(part, str) else part)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    return [line.rstrip() for line in text.splitlines()]


def _tables(contents: Contents) -> list[Table]:
    tables = [
        _joint_table([_joint(joint) for joint in contents.joints]),
        table_of(
            "link",
            "mass",
            "remark",
            rows=[
                (
                    link.name,
                    "frame only" if link.mass_kg is None else f"{link.mass_kg:.3g} kg",
                    "; ".join(link.faults),
                )
                for link in contents.links
            ],
        ),
    ]
    if contents.meshes:
        rows = [(mesh.link, mesh.kind, mesh.file, mesh.fault or "") for mesh in contents.meshes]
        tables.append(table_of("mesh of", "kind", "file", "remark", rows=rows))
    return tables


def _joint_table(rows: Sequence[Sequence[str]]) -> Table:
    return table_of("joint", "kind", "from", "to", "speed", "effort", rows=rows)


def _joint(joint: JointFacts) -> tuple[str, ...]:
    turns = joint.kind != "prismatic"
    scale, unit, force = (math.degrees(1.0), "deg", "Nm") if turns else (1e3, "mm", "N")
    limits = ("-" if end is None else f"{scale * end:.0f} {unit}" for end in (joint.lower, joint.upper))
    return (
        joint.name,
        joint.kind,
        *limits,
        f"{scale * joint.velocity:.0f} {unit}/s",
        f"{joint.effort:.3g} {force}",
    )


def _reach_words(reach: HandReach) -> str:
    (near, far), (low, high) = reach.radii, reach.heights
    away = f"{near:.2f} to {far:.2f} m from the base's axis"
    return f"reach: the hand gets {away}, {low:.2f} to {high:.2f} m up"


def _domain_tables(report: RobotReport) -> list[Any]:
    tables = [table for facts in report.domains.values() for table in facts.tables]
    return [part for item in tables for part in (item.heading, table_of(*item.columns, rows=item.rows))]
