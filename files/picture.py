"""Reading a picture: its size is known before anything of it is unpacked."""

from __future__ import annotations

import warnings
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from handcart.files.errors import FileError, Finding
from handcart.files.regular_file import read_regular_file
from handcart.robotics.numerics.arrays import BoolArray, ByteArray

if TYPE_CHECKING:
    from PIL.Image import Image

PICTURE_FORMATS = {"PNG": "PNG", "PPM": "PGM", "BMP": "BMP", "JPEG": "JPEG", "TIFF": "TIFF", "WEBP": "WebP"}
"""Accepted formats, by Pillow's name: those that map servers of ROS and mapping programs write."""
MAX_BYTES = 1 << 26
MAX_PIXELS = 25_000_000
"""Maximum number of pixels, those of a map of 250 m by 250 m in cells of 5 cm. A file of 109 kB may hold
30,000 by 30,000 pixels."""


class Grey(NamedTuple):
    """Grey levels (h, w) of a picture, 0 for black, with a mask of its opaque pixels."""

    level: ByteArray
    """Grey levels (h, w), row 0 on top; 0 is black."""
    opaque: BoolArray | None
    """Mask (h, w) of opaque pixels; None for a picture without transparency."""


def read_grey(path: Path, max_pixels: int = MAX_PIXELS) -> Grey:
    """Return the grey levels of a picture, with 8 bits; of levels with 16 bits, the upper eight are used.

    Args:
        path: the picture.
        max_pixels: largest allowed number of pixels.

    Raises:
        FileError: the picture is missing or not a regular file, has too many bytes or pixels, is not one of
            the `PICTURE_FORMATS`, or is broken.
    """
    from PIL import Image, UnidentifiedImageError

    content = read_regular_file(path, MAX_BYTES)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            image = Image.open(BytesIO(content), formats=list(PICTURE_FORMATS))
            if image.width * image.height > max_pixels:
                raise _refused(path, _large(f"{image.width} x {image.height}", max_pixels))
            return _grey(image)
    except FileError:
        raise
    except (Image.DecompressionBombWarning, Image.DecompressionBombError):
        raise _refused(path, _large("far too many", max_pixels)) from None
    except UnidentifiedImageError:
        raise _refused(path, f"is not a picture; allowed: {', '.join(PICTURE_FORMATS.values())}") from None
    except Exception:  # the readers of the formats let out whatever a broken file makes them raise
        raise _refused(path, "is broken or cut short; allowed: a whole picture") from None


def _grey(image: Image) -> Grey:
    clear = image.has_transparency_data
    opaque = np.asarray(image.convert("RGBA"))[..., 3] == 255 if clear else None
    if image.mode.startswith("I"):  # 16 bits: Pillow's own conversion cuts them off at 255
        level = (np.asarray(image).astype(np.uint32) >> 8).astype(np.uint8)
    else:
        level = np.asarray(image.convert("L"))
    return Grey(level, opaque)


def _large(size: str, most: int) -> str:
    return f"has {size} pixels; allowed: {most} in all"


def _refused(path: Path, wrong: str) -> FileError:
    return FileError([Finding(str(path), 1, 1, f"the picture {wrong}")])
