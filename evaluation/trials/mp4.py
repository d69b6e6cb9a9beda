"""Writer of MP4 files that stay readable if the program is killed."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from handcart.robotics.numerics.arrays import ByteArray

FRAMES_PER_S = 25
_FLAGS = "frag_keyframe+empty_moov+default_base_moof"
_CODEC = {"preset": "ultrafast", "tune": "zerolatency", "crf": "23", "g": str(FRAMES_PER_S)}


class Mp4:
    """H.264 video in fragments of one second, so that a killed run loses at most its last second.

    It is a context manager that finishes the file on exit.
    """

    def __init__(self, path: Path, size: tuple[int, int]) -> None:
        """Start a file, replacing an older one.

        Args:
            path: of the file.
            size: width and height of the pictures, even numbers in [px].

        Raises:
            OSError: the file cannot be written.
            ModuleNotFoundError: PyAV is not installed.
        """
        import av

        self._file = path.open("wb", buffering=0)
        options = {"movflags": _FLAGS, "flush_packets": "1"}
        self._container = av.open(self._file, "w", format="mp4", options=options)
        self._stream = self._container.add_stream("libx264", rate=FRAMES_PER_S, options=_CODEC)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        self._frame = av.VideoFrame
        self.frames = 0
        """Number of frames written so far."""

    def write(self, picture: ByteArray) -> None:
        """Append a frame, (height, width, 3) in RGB; raise OSError if the disk is full."""
        import cv2  # its colour conversion takes a tenth of FFmpeg's, which is half of the encoding time

        planes = cv2.cvtColor(np.ascontiguousarray(picture), cv2.COLOR_RGB2YUV_I420)
        frame = self._frame.from_ndarray(planes.astype(np.uint8, copy=False), format="yuv420p")
        for packet in self._stream.encode(frame):
            self._container.mux(packet)
        self.frames += 1

    def close(self) -> None:
        """Finish the file; a second call does nothing."""
        if self._file.closed:
            return
        try:
            for packet in self._stream.encode(None):
                self._container.mux(packet)
            self._container.close()
        finally:
            self._file.close()
