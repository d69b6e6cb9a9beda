"""A robot in MuJoCo."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from typing_extensions import override

from handcart.backends.description.robot_file import ALL_DRIVE_KINDS, RobotFile
from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.backends.physics.display import needs_display
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.robotics.numerics.arrays import ByteArray

from .body.mujoco_body import MujocoBody
from .rendering.studio import Studio
from .rendering.style import FILM_STYLE

if TYPE_CHECKING:
    from .rendering.window import Window

VIEW_SIZE = (1280, 720)  # [px]
_FOCAL = 1000.0  # [px]


class MujocoBackend(PhysicsBackend):
    """Simulated backend whose robot and world move by the physics of MuJoCo.

    A resumed run continues exactly like one that was not stopped, to the last bit.

    Differences from hardware: links are rigid; contacts yield by hundredths of a millimetre; a floor is flat;
    friction is Coulomb's, with a single coefficient for each pair of touching bodies; camera pictures have no
    shadows.
    """

    name = "mujoco"
    SIMULATIONS = ("mujoco", "physics", "scene")
    drive_kinds = ALL_DRIVE_KINDS
    _engine: MujocoEngine
    _body: MujocoBody
    _window: Window | None = None

    def _start_engine(self, window: bool) -> MujocoEngine:
        return MujocoEngine(self.period)

    def _load_robot(self, robot: RobotFile) -> MujocoBody:
        return MujocoBody(self._engine, robot, self.scene.base)

    @classmethod
    def build_in_window(cls, robot: RobotFile, world: Path | WorldFile | None, seed: int) -> MujocoBackend:
        """Build a backend that shows robot and world in a window of MuJoCo's viewer, in real time.

        Args:
            robot: robot file.
            world: file of the world.
            seed: seed of simulated errors.

        Raises:
            NoWindow: OpenGL is not available on the display.
        """
        from .rendering.window import Window, check_display

        needs_display()
        mujoco()
        check_display()
        backend = cls(robot, cls.needed(world), seed)
        backend._window = Window(backend._engine, backend._body, backend._body.standing_pose())
        return backend

    @override
    def step(self) -> None:
        super().step()
        if self._window is not None:
            self._window.show(self._body.standing_pose(), self.period)

    @override
    def view(self) -> ByteArray:
        width, height = VIEW_SIZE
        K = np.array([[_FOCAL, 0.0, (width - 1) / 2], [0.0, _FOCAL, (height - 1) / 2], [0.0, 0.0, 1.0]])
        return self._studio.take(self._seen_from(), K, self._onlooker.at)

    @cached_property
    def _studio(self) -> Studio:
        return Studio(self._engine, self._body.looks(), FILM_STYLE, VIEW_SIZE)

    @override
    def close(self) -> None:
        if self._window is not None:
            self._window.close()
        if "_studio" in self.__dict__:
            self._studio.close()
        super().close()
