"""A robot before a drawer or a cupboard, to try OPEN and CLOSE on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig

TASK = Path(__file__).parents[3] / "tasks" / "open_drawer"
PLACES = {"drawer": "x_m: 3.2, y_m: 1.0", "cupboard": "x_m: 3.1, y_m: 2.9"}
START = "x_m: 1.0, y_m: 1.0"


def rig_at(
    door: str,
    folder: Path,
    world: tuple[tuple[str, str], ...] = (),
    known: tuple[tuple[str, str], ...] = (),
    backend: str = "kinematic",
) -> Rig:
    """Return a rig with the robot at its place before a door, its files changed."""
    start = ((START, PLACES[door]),)
    files = RigFiles(
        changed(folder, "world.yaml", *start, *world),
        TASK / "map.yaml",
        TASK / "places.yaml",
        {"doors": changed(folder, "doors.yaml", *known)},
        f"at_{door}",
    )
    return build_rig(files, robot="librarian", seed=3, backend=backend)


def changed(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """Return a copy of one of the task's files with the first of each first text replaced by the second."""
    text = (TASK / name).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def opening(rig: Rig, door: str) -> float:
    """Return the true opening of a door, in [rad] or [m]."""
    return float(props(rig).openings[door])


def props(rig: Rig) -> Any:
    """Return the simulated doors."""
    return rig.backend.scene.props["doors"]  # type: ignore[attr-defined]
