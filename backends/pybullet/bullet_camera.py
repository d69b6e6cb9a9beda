"""The camera of the simulated robot."""

from __future__ import annotations

from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.physics.body.robot_body import RobotBody
from handcart.backends.physics.world.world_bodies import WorldBodies
from handcart.backends.simulation.rendering.lens import Lens
from handcart.backends.simulation.sensors.simulated_camera import SimulatedCamera
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.arm_model import ArmModel

from .bullet_engine import BulletEngine

NEAREST, FURTHEST = 0.02, 20.0  # of what is shown [m]
SAMPLES = 2  # along each side of a pixel, which takes in light from all of its area: edges have no steps
_TO_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])


class BulletCamera(SimulatedCamera):
    """Bullet's renderer as an ideal pinhole camera, then the lens, light and noise of the robot's file.

    Rendered on demand, once a period: by its EGL plug-in, if it has one, else by TinyRenderer. Light comes
    from everywhere and there are no shadows.
    """

    def __init__(
        self,
        robot: RobotFile,
        spec: CameraSpec,
        arm: ArmModel,
        body: RobotBody,
        world: WorldBodies,
        engine: BulletEngine,
        seed: int,
    ) -> None:
        super().__init__(robot, spec, arm, seed)
        self._lens = Lens(self._true.model, robot.errors, seed)
        self._body, self._world, self._engine = body, world, engine

    def _take(self) -> NDArray[np.uint8]:
        return self._lens.take(self.ideal(), self._now)

    def ideal(self) -> NDArray[np.uint8]:
        """What a pinhole camera sees, larger than the picture so that the lens has all of it, grey."""
        pose = self._body.link_pose("hand") @ self._true.hand_T_camera
        for each in self._world.things.values():
            each.look(pose[:3, 3])
        width, height = self._lens.size
        K = self._lens.K * [[SAMPLES], [SAMPLES], [1.0]]
        K[:2, 2] += (SAMPLES - 1) / 2
        fine = np.empty((SAMPLES * height, SAMPLES * width), dtype=np.uint8)
        # In tiles: the EGL renderer has a window of 1024 x 768, and stretches that to what is larger.
        for row, column in product(range(0, SAMPLES * height, height), range(0, SAMPLES * width, width)):
            moved = K.copy()
            moved[:2, 2] -= (column, row)
            tile = render(self._engine, pose, moved, (width, height))
            fine[row : row + height, column : column + width] = tile[..., 1]
        return np.asarray(cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def render(
    engine: BulletEngine,
    world_T_camera: Transform,
    K: NDArray[np.float64],
    size: tuple[int, int],
    lit: bool = False,
) -> NDArray[np.uint8]:
    """A pinhole camera's picture (height, width, 3) in RGB.

    Args:
        engine: what is there.
        world_T_camera: (4, 4) of the optical frame (z forward, x right, y down).
        K: (3, 3) in [px]; an integer pixel is a pixel's centre.
        size: width and height in [px].
        lit: see `BulletEngine.picture`.
    """
    view = inverse(world_T_camera @ _TO_OPENGL)
    return engine.picture(view, _projection(K, size), size, lit)


def looking(eye: NDArray[np.float64], at: NDArray[np.float64]) -> Transform:
    """world_T_camera (4, 4) of a level camera at a point that looks at another one, (3,) in [m]."""
    forward = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = eye
    return pose


def _projection(K: NDArray[np.float64], size: tuple[int, int]) -> NDArray[np.float64]:
    """OpenGL's projection (4, 4) of a pinhole camera; OpenGL counts pixels from their edges."""
    width, height = size
    fx, fy, cx, cy = K[0, 0], K[1, 1], K[0, 2] + 0.5, K[1, 2] + 0.5
    far, near = FURTHEST, NEAREST
    return np.array(
        [
            [2 * fx / width, 0.0, 1.0 - 2 * cx / width, 0.0],
            [0.0, 2 * fy / height, 2 * cy / height - 1.0, 0.0],
            [0.0, 0.0, -(far + near) / (far - near), -2 * far * near / (far - near)],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )
