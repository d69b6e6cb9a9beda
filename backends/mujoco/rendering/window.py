"""MuJoCo's viewer, in a window."""

from __future__ import annotations

import threading
import time
from importlib import import_module
from typing import Any

import numpy as np

from handcart.backends.backend import NoWindow
from handcart.backends.mujoco.body.mujoco_body import MujocoBody
from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.robotics.geometry.transform import Transform

from .stage import PictureStage
from .style import STILL_PICTURE

_FROM = {"distance": 4.0, "azimuth": 135.0, "elevation": -25.0}  # where one looks from at first

_PATIENCE = 10.0  # [s] that the viewer gets to end


class Window:
    """Window that shows robot and world in MuJoCo's viewer, in real time.

    Dragging bodies with the mouse does not affect the simulation, and closing the window does not end the
    run.
    """

    def __init__(self, engine: MujocoEngine, body: MujocoBody, world_T_base: Transform) -> None:
        """Open the window; call `check_display` first.

        Args:
            engine: engine whose world is shown.
            body: the robot in it.
            world_T_base: (4, 4) pose of the base, which the view follows.
        """
        self._engine, self._robot = engine, body.looks()
        self._due = time.monotonic()
        self._open(world_T_base)

    def _open(self, world_T_base: Transform) -> None:
        self._stage = PictureStage(self._engine.looks, self._robot, STILL_PICTURE, self._engine.model)
        self._stage.follow(self._engine.links(), world_T_base[:3, 3])
        viewer, before = import_module("mujoco.viewer"), threading.enumerate()
        self._handle: Any = viewer.launch_passive(
            self._stage.model, self._stage.data, show_left_ui=False, show_right_ui=False
        )
        self._threads = [item for item in threading.enumerate() if item not in before]
        camera = self._handle.cam
        camera.lookat = world_T_base[:3, 3] + (0.0, 0.0, 0.5)
        camera.distance, camera.elevation = _FROM["distance"], _FROM["elevation"]
        heading = np.degrees(np.arctan2(world_T_base[1, 0], world_T_base[0, 0]))
        camera.azimuth = heading + _FROM["azimuth"] - 180.0

    def show(self, world_T_base: Transform, period: float) -> None:
        """Show the current poses, and wait until a period has passed on the wall clock.

        Args:
            world_T_base: (4, 4) pose of the base, which the view follows.
            period: control period, in [s].
        """
        if not self._handle.is_running():
            return
        if self._stage.count != self._engine.looks.count:
            self.close()
            self._open(world_T_base)
        self._stage.follow(self._engine.links(), world_T_base[:3, 3])
        self._handle.sync()
        now = time.monotonic()
        self._due = max(self._due + period, now)
        time.sleep(self._due - now)

    def close(self) -> None:
        """Close the window; a second call does nothing."""
        self._handle.close()
        for thread in self._threads:  # it draws in a thread of its own, which mustn't outlive it
            thread.join(_PATIENCE)


def check_display() -> None:
    """Check that MuJoCo's viewer finds OpenGL on the display; without it the viewer would wait forever.

    Raises:
        NoWindow: OpenGL is not available on the display.
    """
    glfw: Any = import_module("glfw")
    said, window = ["GLFW doesn't say why"], None
    glfw.set_error_callback(lambda _, words: said.append(words.decode(errors="replace")))
    if glfw.init():
        glfw.window_hint(glfw.VISIBLE, 0)
        window = glfw.create_window(16, 16, "", None, None)
        glfw.terminate()
    glfw.set_error_callback(None)
    if window is None:
        why = said[-1]
        raise NoWindow(
            f"MuJoCo's viewer finds no OpenGL on this display: {why}; "
            "install it with: apt install libgl1 libgl1-mesa-dri; allowed: --video FILE.mp4"
        )
