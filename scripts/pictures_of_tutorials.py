"""Pictures of the tutorials: `python scripts/pictures_of_tutorials.py [NAME ...]` (a minute each).

Writes docs/pictures/NAME.jpg, from the files that the tutorial's page shows: of those that are named, or all.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(REPOSITORY_ROOT), str(REPOSITORY_ROOT / "scripts")]

from pictures_of_physics import Moment, Photo  # noqa: E402

from handcart.evaluation.trials.running import run_task  # noqa: E402
from handcart.networks.runs.run_options import RunOptions  # noqa: E402
from handcart.tools.main import main as handcart  # noqa: E402
from tests.tutorials.tutorial_steps import steps, write_file  # noqa: E402


class Still(NamedTuple):
    """A page, the commands of it that make files, and a moment in a run of its task."""

    page: str
    makes: tuple[str, ...]
    moment: Moment


TUTORIAL_STILLS: Mapping[str, Still] = {
    "room": Still(
        "room.md",
        ("handcart make-map",),
        Moment("room/task.yaml", "MOVE_TO", 1, 18.0, (-0.9, -1.3, 8.0), (-0.7, 1.0, 0.2), 1300.0),
    ),
    "soap": Still(
        "object.md",
        ("handcart make-map",),
        Moment("soap/task.yaml", "PLACE", 1, 6.8, (-0.1, 1.3, 1.3), (0.4, 0.0, 0.68), 1200.0),
    ),
}


def take(name: str) -> Path:
    """Take one picture; return its file."""
    page, makes, moment = TUTORIAL_STILLS[name]
    path = REPOSITORY_ROOT / "docs" / "pictures" / f"{name}.jpg"
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for file, text in steps(page):
            if file:
                write_file(Path(folder), file, text)
            elif text.startswith(makes):
                with contextlib.suppress(SystemExit):
                    handcart(text.split()[1:])
        photo = Photo(moment, path)
        options = RunOptions(backend="mujoco", settings=moment.settings, observers=(photo,))
        run_task(Path(folder) / moment.task, Path(folder) / "runs", options)
        os.chdir(REPOSITORY_ROOT)
    if not photo.taken:
        sys.exit(f"{name}: {moment.action} wasn't begun {moment.times} times")
    return path


def main() -> None:
    """Take those that are asked for, or all."""
    for name in sys.argv[1:] or TUTORIAL_STILLS:
        path = take(name)
        print(f"written: {path}, {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
