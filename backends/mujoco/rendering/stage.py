"""Displayed copy of MuJoCo's model: without mass, and posed as the first one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handcart.backends.mujoco.body.robot_looks import PartLook
from handcart.backends.mujoco.engine.looks import Looks
from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .stage_spec import LAMP_NAME, StageSpec
from .style import Style

LAMP_HEIGHT = 6.0  # [m] above what it shines on, along its beam


class PictureStage:
    """MuJoCo model of a scene for rendering only, with pictures and lamps.

    Its bodies have the same names as the bodies in the physics engine's model, and are put at the same poses.
    Rendering cannot change a run, because the engine's own model is not rendered.
    """

    def __init__(self, looks: Looks, robot: Sequence[PartLook], style: Style, engine_model: Any) -> None:
        """Build the stage as the world is now; it is out of date once `looks.count` changes.

        Args:
            looks: appearance of the world's bodies.
            robot: appearance of the robot's links.
            style: light and colours.
            engine_model: MuJoCo's model of the engine, whose bodies the stage follows.
        """
        self._looks, self.count = looks, looks.count
        spec = StageSpec(looks, robot, style)
        self.model = spec.spec.compile()
        self.data = mujoco().MjData(self.model)
        self._style, self._shown = style, dict[int, ByteArray]()
        names = [name for name in spec.moving if name != LAMP_NAME]
        self._theirs = np.array([engine_model.body(name).id for name in names], dtype=int)
        self._mine = np.array([int(self.model.body(name).mocapid[0]) for name in names], dtype=int)
        self._lamp = int(self.model.body(LAMP_NAME).mocapid[0])
        self._drawn = np.zeros(0)

    def follow(self, engine_data: Any, middle: FloatArray) -> bool:
        """Copy the poses of all bodies from the engine, and aim the lamp; return True if any body has moved.

        Args:
            engine_data: MuJoCo's data of the engine.
            middle: (3,) point in the world at which the lamp is aimed, in [m].
        """
        data = self.data
        data.mocap_pos[self._mine] = engine_data.xpos[self._theirs]
        data.mocap_quat[self._mine] = engine_data.xquat[self._theirs]
        data.mocap_pos[self._lamp] = middle - LAMP_HEIGHT * np.array(self._style.beam)
        now = np.concatenate([data.mocap_pos.ravel(), data.mocap_quat.ravel()])
        if now.shape == self._drawn.shape and np.abs(now - self._drawn).max() < VISIBLE_MOTION:
            return False
        self._drawn = now
        mujoco().mj_kinematics(self.model, data)
        mujoco().mj_camlight(self.model, data)
        return True

    def repaint(self) -> list[int]:
        """Update the textures of things whose pictures have changed; return MuJoCo's numbers of the changed
        textures.
        """
        if self._style.coloured:
            return []
        changed = []
        for number, picture in self._looks.shown.items():
            if picture is not self._shown.get(number) and (texture := self._texture(number, picture)) >= 0:
                changed.append(texture)
            self._shown[number] = picture
        return changed

    def _texture(self, number: int, picture: ByteArray) -> int:
        """Paint a thing's texture, if it has one of that size; return the texture's number, or -1."""
        model = self.model
        found = int(mujoco().mj_name2id(model, mujoco().mjtObj.mjOBJ_TEXTURE, f"{number}"))
        if found < 0 or (model.tex_height[found], model.tex_width[found]) != picture.shape:
            return -1
        first = int(model.tex_adr[found])
        model.tex_data[first : first + 3 * picture.size] = np.repeat(picture.ravel(), 3)
        return found


VISIBLE_MOTION = 2e-5  # [m], or of a quaternion: less can't be seen
