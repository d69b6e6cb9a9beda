"""Pictures of the four systems, by MuJoCo's renderer: `python scripts/pictures_of_physics.py [SYSTEM ...]`.

Writes docs/SYSTEM.jpg, each in the middle of its task: of those that are named, or all. Takes some minutes.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from handcart.backends.mujoco.mujoco_backend import MujocoBackend
from handcart.backends.mujoco.rendering.studio import Studio
from handcart.backends.mujoco.rendering.style import STILL_PICTURE
from handcart.backends.physics.onlooker import looking
from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.running import run_task
from handcart.networks.events.events import Event, Started
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.runs.run_options import RunOptions

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
SIZE_PX = (1280, 720)  # [px]
JPEG_QUALITY = 86
Point = tuple[float, float, float]


class Moment(NamedTuple):
    """When a picture is taken, and from where."""

    task: str
    action: str
    times: int
    """Number of the action among those with that name: the first, the second ..."""
    seconds: float
    """After it began, in [s]."""
    eye: Point
    """Position of the eye in the base's frame, in [m]; heights are above the floor."""
    at: Point
    focal: float
    """[px]"""
    settings: Mapping[str, str] = {}
    """Settings of the task."""


PICTURED_MOMENTS = {
    "librarian": Moment("return_book", "INSERT", 1, 3.0, (-1.0, 2.1, 1.9), (0.35, -0.05, 0.68), 1100.0),
    "toyama": Moment("stack_blocks", "STACK", 8, 3.0, (-1.6, 1.75, 1.7), (0.02, 0.2, 0.62), 1100.0),
    "atrv": Moment("track_seam", "TRACK", 1, 12.0, (-2.7, -1.5, 1.8), (0.45, 0.3, 0.55), 1200.0),
    "el_verde": Moment(
        "deploy_straight", "DEPLOY", 1, 9.0, (2.6, -2.2, 1.4), (0.25, 0.15, 0.5), 1250.0, {"wait_s": "1"}
    ),
}


class Taken(Exception):
    """The picture is there: the run, which is not needed any more, ends with an error."""


class Photo(RunObserver):
    """Takes a picture in a run, and ends it."""

    def __init__(self, moment: Moment, path: Path) -> None:
        self._moment, self._path = moment, path
        self._begun, self._times, self._started = False, 0, 0.0
        self.taken = False

    def event(self, event: Event) -> None:
        """Wait for the action."""
        if isinstance(event, Started) and event.action.do == self._moment.action:
            self._times += 1
            self._begun, self._started = self._times == self._moment.times, event.time

    def period(self, robot: Robot) -> None:
        """Take it once it is time."""
        if self._begun and robot.time >= self._started + self._moment.seconds:
            backend = robot.backend
            assert isinstance(backend, MujocoBackend)
            take(backend, self._moment, self._path)
            self.taken = True
            raise Taken


def take(backend: MujocoBackend, moment: Moment, path: Path) -> None:
    """Take the picture of a robot in its present pose."""
    base = backend.scene.base.lift(float(backend._body.standing_pose()[2, 3]))
    eye, at = ((base @ (*point, 1.0))[:3] for point in (moment.eye, moment.at))
    K = np.array(
        [[moment.focal, 0, (SIZE_PX[0] - 1) / 2], [0, moment.focal, (SIZE_PX[1] - 1) / 2], [0, 0, 1]]
    )
    studio = Studio(backend._engine, backend._body.looks(), STILL_PICTURE, SIZE_PX)
    picture = studio.take(looking(eye, at), K, at)
    studio.close()
    cv2.imwrite(str(path), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])


def main() -> None:
    """Take those that are asked for, or all."""
    for name in sys.argv[1:] or PICTURED_MOMENTS:
        moment, path = PICTURED_MOMENTS[name], REPOSITORY_ROOT / "docs" / "pictures" / f"{name}.jpg"
        photo = Photo(moment, path)
        options = RunOptions(backend="mujoco", settings=moment.settings, observers=(photo,))
        with tempfile.TemporaryDirectory() as runs:
            run_task(REPOSITORY_ROOT / "tasks" / moment.task / "task.yaml", Path(runs), options)
        if not photo.taken:
            sys.exit(f"{name}: {moment.action} wasn't begun {moment.times} times")
        print(f"written: {path}, {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
