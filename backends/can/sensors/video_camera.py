"""A camera by OpenCV's VideoCapture."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import cv2
import numpy as np
from typing_extensions import override

from handcart.backends.description.can_sensor_spec import CameraSource
from handcart.backends.live.live_sensor import Clock, LiveSensor
from handcart.backends.live.sensor_errors import NoSensor
from handcart.backends.robot.mounted_camera import MountedCamera
from handcart.backends.robot.placed_camera import PlacedCamera
from handcart.robotics.numerics.arrays import ByteArray

_RETRY = 0.05  # [s] after a picture that didn't come


class VideoCamera(LiveSensor, PlacedCamera):
    """Camera whose pictures come from a video device, a URL, or a file with a video or a picture.

    A thread grabs the pictures of a device or URL. A file delivers one picture in each control period, and
    its last picture again after its end.
    """

    def __init__(self, source: CameraSource, mounted: MountedCamera, clock: Clock = time.monotonic) -> None:
        """Open the device, URL or file.

        Args:
            source: where pictures come from.
            mounted: the camera as it was calibrated.
            clock: gives the time in [s].

        Raises:
            NoSensor: it cannot be opened, or its pictures are of another size than the robot's file says.
        """
        super().__init__("the camera", source.stale_ms / 1e3, clock)
        self._known = mounted
        self._video = cv2.VideoCapture(source.source)
        if not self._video.isOpened():
            self._video.release()
            wrong = f"the camera: {source.source!r} can't be opened"
            raise NoSensor(f"{wrong}; allowed: a device's number, a URL, a file with a video or a picture")
        self._is_file = isinstance(source.source, str) and Path(source.source).is_file()
        if not self._is_file:
            self._video.set(cv2.CAP_PROP_FRAME_WIDTH, mounted.model.width)
            self._video.set(cv2.CAP_PROP_FRAME_HEIGHT, mounted.model.height)
        self._lock, self._over = threading.Lock(), threading.Event()
        self._grabbed: tuple[ByteArray, float] | None = None
        self._image: ByteArray | None = None
        self._thread: threading.Thread | None = None
        try:
            self._grab()
            if self._grabbed is None:
                raise NoSensor(f"the camera: {source.source!r} gives no picture")
        except NoSensor:
            self._video.release()
            raise
        if not self._is_file:
            self._thread = threading.Thread(target=self._go_on, daemon=True)
            self._thread.start()

    def image(self) -> ByteArray:
        """Return the newest picture (h, w), grey, from 0 to 255, with the lens's distortion.

        Raises:
            StaleSensor: the newest picture is older than the robot's file allows.
        """
        self.check_fresh()
        assert self._image is not None
        return self._image

    def _take_in(self) -> None:
        if self._is_file and self._image is not None:
            self._grab()
        with self._lock:
            grabbed = self._grabbed
        if grabbed is not None:
            self._image, self._came = grabbed if not self._is_file else (grabbed[0], self._now)

    def _grab(self) -> bool:
        """Take the next picture; return whether one came."""
        came, picture = self._video.read()
        if not came:
            return False
        grey = np.ascontiguousarray(
            picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8
        )
        model = self._known.model
        if grey.shape != (model.height, model.width):
            got = f"{grey.shape[1]} x {grey.shape[0]}"
            raise NoSensor(
                f"the camera gives {got} pixels; the robot's file says {model.width} x {model.height}"
            )
        grey.flags.writeable = False
        with self._lock:
            self._grabbed = grey, self._clock()
        return True

    def _go_on(self) -> None:
        """Grab pictures in a thread; after a fault here the last picture becomes stale."""
        try:
            while not self._over.is_set():
                if not self._grab():
                    self.rejected += 1
                    self._over.wait(_RETRY)
        except (NoSensor, cv2.error) as error:
            self.trouble = str(error)

    @override
    def close(self) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join(2.0)
        if self._thread is None or not self._thread.is_alive():
            self._video.release()
