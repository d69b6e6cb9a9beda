"""Atomic writing of a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
from numpy.typing import NDArray

from handcart.files.whole_file import write_whole


def write_png(path: Path, picture: NDArray[Any]) -> None:
    """Write a picture atomically, as PNG.

    Args:
        path: file to write.
        picture: (h, w) grey, or (h, w, 3) BGR, from 0 to 255.

    Raises:
        OSError: the file cannot be written.
    """
    _, png = cv2.imencode(".png", picture)
    write_whole(path, png.tobytes())
