"""OpenGL contexts for MuJoCo's renderer, without a display."""

from __future__ import annotations

import os
from ctypes.util import find_library
from importlib import import_module
from typing import Any

from handcart.files.errors import InputError

_WAYS = {"egl": "EGL", "osmesa": "OSMesa"}
"""MuJoCo's name of each OpenGL platform, with the name of its library."""


class NoPictures(InputError):
    """Error: no OpenGL library is available that renders without a display."""

    def __init__(self, why: str) -> None:
        super().__init__(
            f"MuJoCo's renderer has no OpenGL: {why}; "
            "install one with: apt install libegl1 libgl1-mesa-dri, or: apt install libosmesa6"
        )


def make_context(width: int, height: int) -> Any:
    """Create an OpenGL context for pictures up to a size in [px], and make it current on this thread.

    The context uses EGL, on a graphics card or in software, otherwise OSMesa; the variable MUJOCO_GL
    overrides this choice. Its method `free` releases it.

    Raises:
        NoPictures: no context can be created.
    """
    asked = os.environ.get("MUJOCO_GL", "").lower()
    ways = [asked] if asked in _WAYS else [way for way, library in _WAYS.items() if find_library(library)]
    if not ways:
        raise NoPictures("neither libEGL nor libOSMesa is there")
    try:
        context = import_module(f"mujoco.{ways[0]}").GLContext(width, height)
        context.make_current()
    except Exception as error:  # PyOpenGL's come in many classes, where drivers are missing AttributeError
        raise NoPictures(
            f"{_WAYS[ways[0]]} says {str(error).splitlines()[0] if str(error) else error!r}"
        ) from None
    return context
