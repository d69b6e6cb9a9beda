"""A robot before a table with objects, to try single primitives on."""

from __future__ import annotations

from pathlib import Path

from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Success
from tests.primitives.changed_scene import scene_of as scene_of

TASK = Path(__file__).parents[3] / "tasks" / "fetch_and_carry"


def rig_with(
    objects: Path = TASK / "objects.yaml",
    world: Path = TASK / "world.yaml",
    robot: str = "librarian",
    seed: int = 0,
    backend: str = "kinematic",
) -> Rig:
    """Return a rig with the robot at home."""
    files = RigFiles(world, TASK / "map.yaml", TASK / "places.yaml", {"objects": objects}, "home")
    return build_rig(files, robot=robot, seed=seed, backend=backend)


def changed(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """Return a copy of one of the task's files with each first text replaced by the second."""
    text = (TASK / name).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def at_table_a(
    world: Path = TASK / "world.yaml", objects: Path = TASK / "objects.yaml", seed: int = 0
) -> Rig:
    """Return a rig with the robot at its place before table A."""
    rig = rig_with(objects, world, seed=seed)
    assert isinstance(rig.do(MoveTo(place="table_a")), Success)
    return rig
