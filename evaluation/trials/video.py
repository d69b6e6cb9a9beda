"""Video of a run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from handcart.backends.capabilities.camera import Camera
from handcart.backends.robot.robot import Robot
from handcart.files.errors import InputError
from handcart.files.extras import lack
from handcart.networks.events.events import Ended, Event, Restoring, Started
from handcart.networks.events.run_observer import RunObserver
from handcart.robotics.numerics.arrays import ByteArray

from .mp4 import FRAMES_PER_S, Mp4

HEIGHT_PX, BAR_HEIGHT_PX = 720, 40  # of the pictures, and of the line of text at their bottom
INSET_HEIGHT_SHARE = 0.3  # height of the camera picture, relative to the frame
INSET_DURATION_S = 1.0  # for which the last camera picture is shown
_MARGIN, _FRAME = 16, 2  # around the inset [px]
_PAPER, _INK = (245, 245, 245), (30, 30, 30)


class NoVideo(InputError):
    """Error for a run that cannot be recorded as a video."""


class Video(RunObserver):
    """Observer that records a run as a video of the backend's view, the action and the camera's picture.

    The camera's picture is shown while primitives use it. If the backend has no view, only the camera's
    pictures are recorded. It is a context manager that finishes the file on exit.
    """

    def __init__(self, path: Path, robot: Robot) -> None:
        """Start the file.

        Raises:
            NoVideo: the file cannot be written, its name does not end in .mp4, or there is nothing to
                record.
        """
        self._next, self._words = 0.0, ""
        self._seen: ByteArray | None = None
        self._seen_at = -np.inf
        self._lacks = ""
        if path.suffix.lower() != ".mp4":
            raise NoVideo(f"--video {path}: allowed: a file whose name ends in .mp4")
        if (words := lack("--video", "video")) is not None:
            raise NoVideo(words)
        self._view = self._what_is_seen(robot)
        height, width = self._frame(robot).shape[:2]
        self._path, self._size = path, (width, height)
        try:
            self._mp4 = Mp4(path, self._size)
        except OSError as error:
            needed = "needed: a folder that exists, with room in it"
            raise NoVideo(f"--video {path}: can't be written: {error.strerror}; {needed}") from None

    def _what_is_seen(self, robot: Robot) -> bool:
        """Return whether the backend has a view; raise NoVideo if it has neither a view nor a camera."""
        wrong = f"the backend {robot.backend.name!r} renders nothing"
        try:
            if robot.backend.view() is not None:
                return True
        except InputError as error:
            wrong = self._lacks = str(error)
        if robot.backend.get(Camera) is None:  # type: ignore[type-abstract]
            raise NoVideo(f"--video: {wrong}, and has no camera")
        return False

    def remarks(self) -> Iterator[str]:
        """Yield messages, at the start of the run, about the video's file and about missing views."""
        if self._lacks:
            yield f"--video shows what the hand's camera sees alone: {self._lacks}"
        width, height = self._size
        yield (
            f"{self._path} is being recorded: {width} x {height}, "
            f"{FRAMES_PER_S} frames a second of robot's time"
        )

    def __enter__(self) -> Video:
        return self

    def __exit__(self, *_: object) -> None:
        self._mp4.close()

    def event(self, event: Event) -> None:
        """Update the text about the current action that the next frames show at their bottom."""
        match event:
            case Started(_, number, action, _, _):
                self._words = f"{number}. {action.do}: {action.source} to {action.target}"
            case Restoring(_, action, reason):
                self._words = f"{action.do} restores: {reason}"
            case Ended(_, number, action, _, outcome):
                self._words = f"{number}. {action.do}: {type(outcome).__name__}"

    def period(self, robot: Robot) -> None:
        """Write the frames of the video that are due; if several are due in one period, repeat the frame."""
        if robot.seen is not self._seen:
            self._seen, self._seen_at = robot.seen, robot.time
        if robot.time < self._next - 1e-9:
            return
        frame = self._frame(robot)
        while robot.time >= self._next - 1e-9:
            self._next += 1.0 / FRAMES_PER_S
            self._mp4.write(frame)

    def _frame(self, robot: Robot) -> ByteArray:
        """Return the current frame (`HEIGHT_PX`, w, 3) in RGB."""
        picture = robot.backend.view() if self._view else None
        if picture is None:
            camera = robot.backend.get(Camera)  # type: ignore[type-abstract]
            assert camera is not None
            frame = _as_high(_in_colour(camera.image()), HEIGHT_PX)
        else:
            frame = _as_high(picture, HEIGHT_PX)
            if self._seen is not None and robot.time < self._seen_at + INSET_DURATION_S:
                _put_in(frame, _in_colour(self._seen))
        foot = frame[-BAR_HEIGHT_PX:]
        foot[:] = cv2.addWeighted(foot, 0.25, np.full_like(foot, _PAPER), 0.75, 0.0)
        words = f"{robot.time:6.1f} s  {self._words}".encode("ascii", "replace").decode()
        at = (12, frame.shape[0] - 13)
        cv2.putText(frame, words, at, cv2.FONT_HERSHEY_SIMPLEX, 0.65, _INK, 1, cv2.LINE_AA)
        return frame


def _in_colour(grey: ByteArray) -> ByteArray:
    return np.repeat(grey[..., None], 3, axis=2)


def _as_high(picture: ByteArray, height: int) -> ByteArray:
    """Return a copy of a picture (h, w, 3) scaled to this height, with an even width."""
    width = 2 * round(picture.shape[1] * height / picture.shape[0] / 2)
    if picture.shape[:2] == (height, width):
        return picture.copy()
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)


def _put_in(frame: ByteArray, picture: ByteArray) -> None:
    """Draw a picture (h, w, 3) with a border into the upper right corner of a frame (h, w, 3), in place."""
    small = _as_high(picture, round(INSET_HEIGHT_SHARE * frame.shape[0]))
    small = cv2.copyMakeBorder(small, *(_FRAME,) * 4, cv2.BORDER_CONSTANT, value=_PAPER).astype(np.uint8)
    height, width = small.shape[:2]
    frame[_MARGIN : _MARGIN + height, -_MARGIN - width : -_MARGIN] = small
