"""A run as a video."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from handcart.backends.capabilities.camera import Camera
from handcart.backends.robot.robot import Robot
from handcart.files.errors import InputError
from handcart.networks.coordination.events import Ended, Event, Restoring, Started
from handcart.networks.run_observer import RunObserver

FRAMES = 10  # in a second of the robot's time
HEIGHT, BAR = 480, 32  # of the pictures, of the line of text below them [px]
_PAPER, _INK = (245, 245, 245), (30, 30, 30)
_CODEC = "mp4v"


class NoVideo(InputError):
    """The run can't be recorded."""


class Video(RunObserver):
    """Records what the backend shows and what the hand's camera sees, side by side, with what is being done.

    A context manager: leaving it ends the file.
    """

    def __init__(self, path: Path, robot: Robot) -> None:
        """Begin the file.

        Raises:
            NoVideo: it can't be written, its name doesn't end in .mp4, or there is nothing to be seen.
        """
        self._next, self._words = 0.0, ""
        if path.suffix.lower() != ".mp4":
            raise NoVideo(f"--video {path}: allowed: a file whose name ends in .mp4")
        frame = self._frame(robot)
        if frame is None:
            raise NoVideo(f"--video: the backend {robot.backend.name!r} renders nothing, and has no camera")
        height, width = frame.shape[:2]
        codec = cv2.VideoWriter.fourcc(*_CODEC)
        self._path, self._new = path, path.with_name(f".{path.stem[:40]}.{os.getpid()}.new.mp4")
        self._writer = cv2.VideoWriter(str(self._new), codec, FRAMES, (width, height))
        if not self._writer.isOpened():
            raise NoVideo(f"--video {path}: can't be written; needed: a folder that exists, with room in it")

    def __enter__(self) -> Video:
        return self

    def __exit__(self, *_: object) -> None:
        self._writer.release()
        with suppress(FileNotFoundError):  # the encoder may have made none
            os.replace(self._new, self._path)

    def event(self, event: Event) -> None:
        """Keep what is being done, for the line below the pictures."""
        match event:
            case Started(_, number, action, _, _):
                self._words = f"{number}. {action.do}: {action.source} to {action.target}"
            case Restoring(_, action, reason):
                self._words = f"{action.do} restores: {reason}"
            case Ended(_, number, action, _, outcome):
                self._words = f"{number}. {action.do}: {type(outcome).__name__}"

    def period(self, robot: Robot) -> None:
        """Take a frame, if it is time for one."""
        if robot.time < self._next - 1e-9:
            return
        self._next += 1.0 / FRAMES
        frame = self._frame(robot)
        if frame is not None:
            self._writer.write(frame)

    def _frame(self, robot: Robot) -> NDArray[np.uint8] | None:
        """BGR, as OpenCV writes it; None where there is nothing to be seen."""
        pictures = []
        view = robot.backend.view()
        if view is not None:
            pictures.append(cv2.cvtColor(view, cv2.COLOR_RGB2BGR))
        camera = robot.backend.get(Camera)  # type: ignore[type-abstract]
        if camera is not None:
            pictures.append(cv2.cvtColor(camera.image(), cv2.COLOR_GRAY2BGR))
        if not pictures:
            return None
        scaled = [cv2.resize(each, _even(each.shape[1] * HEIGHT / each.shape[0])) for each in pictures]
        bar = np.full((BAR, sum(each.shape[1] for each in scaled), 3), _PAPER, np.uint8)
        words = f"{robot.time:6.1f} s  {self._words}".encode("ascii", "replace").decode()
        cv2.putText(bar, words, (8, 22), cv2.FONT_HERSHEY_SIMPLEX, 0.55, _INK, 1, cv2.LINE_AA)
        return np.vstack([np.hstack(scaled), bar]).astype(np.uint8)


def _even(width: float) -> tuple[int, int]:
    return 2 * round(width / 2), HEIGHT
