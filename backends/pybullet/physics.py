"""One physics engine: its clock, its bodies, its saved states."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from handcart.backends.plain_values import from_plain, to_plain
from handcart.backends.saved_state import NotAState
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Box

from .bullet_state import check_state
from .engine import bullet, quiet

STEP = 0.0025  # of the solver, at most [s]
CHUNK = 0.005  # [s]: how often the drives' electronics look at their encoders
GRAVITY = 9.81
ROBOT_GROUP = 64  # collision group of the robot: no beam of its range sensor meets it
_ITERATIONS = 100
_STICKS = 0.8  # of what a contact that sticks has slid is taken back in a step
_FLOOR = 0.37  # grey
_WARM_UP = 3  # pictures
_SUN = (-0.5, 0.4, 1.0)  # where light comes from in a picture for people
_UNLIT = 0.5  # of its own brightness is what the EGL renderer shows of a face that no light falls on


Point = tuple[float, float, float]


@dataclass(frozen=True)
class Pinned:
    """Two bodies held together at points, given (n, 3) in [m] in the frames of their middles of mass."""

    body: int
    link: int
    """Of `body`."""
    other: int
    points: tuple[Point, ...]
    other_points: tuple[Point, ...]
    force_n: float
    """With which each point is held, at most."""


class Physics:
    """A Bullet client of its own; `stepped` is called by nobody else. Ids of bodies are Bullet's.

    The solver's step divides the drives' period, which divides the control period.
    """

    def __init__(self, period: float, window: bool = False) -> None:
        """Start the engine.

        Args:
            period: the control period, in [s].
            window: whether to show the world; needs a display.
        """
        self.p = bullet()
        with quiet():
            self.client = self.p.connect(self.p.GUI if window else self.p.DIRECT)
        self.chunks = max(1, round(period / CHUNK))
        """How often the drives act in a control period."""
        self.chunk = period / self.chunks
        self.substeps = max(1, int(np.ceil(self.chunk / STEP - 1e-9)))
        """Steps of the solver in a chunk. Bullet takes impulses of motors and contacts for those of a chunk
        while they are those of a step: what it is told of forces is to be divided by this, what it tells
        multiplied."""
        self._connected = True
        self._pins: list[int] = []
        self._textures: dict[tuple[tuple[int, ...], bytes], int] = {}
        self.pinned: Pinned | None = None
        """What is held together now."""
        self.renderer = self._start_renderer(window)
        """Bullet's number of the renderer: its EGL plug-in where there is one, else TinyRenderer."""
        self._cold = _WARM_UP if self.renderer == self.p.ER_BULLET_HARDWARE_OPENGL else 0
        self.p.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=self.client)
        self.p.setPhysicsEngineParameter(
            fixedTimeStep=self.chunk,
            numSubSteps=self.substeps,
            numSolverIterations=_ITERATIONS,
            frictionERP=_STICKS,
            enableConeFriction=0,  # with it, what is held creeps out of the hand
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )

    def _start_renderer(self, window: bool) -> int:
        plugin = None if window else find_spec("eglRenderer")
        if plugin is not None and plugin.origin is not None:
            # Before any shape is made: the renderer shows what was made after it.
            with quiet():
                loaded = self.p.loadPlugin(plugin.origin, "_eglRendererPlugin", physicsClientId=self.client)
            if loaded >= 0:
                return int(self.p.ER_BULLET_HARDWARE_OPENGL)
        return int(self.p.ER_BULLET_HARDWARE_OPENGL if window else self.p.ER_TINY_RENDERER)

    def step(self) -> None:
        """Let `chunk` seconds pass."""
        self.p.stepSimulation(physicsClientId=self.client)

    def close(self) -> None:
        """Let go of the engine; a second call does nothing."""
        if self._connected:
            self._connected = False
            with quiet():
                self.p.disconnect(physicsClientId=self.client)

    # Bodies

    def add_floor(self, friction: float) -> int:
        """A plane through the origin; what is shown of it ends 40 m away."""
        shape = self.p.createCollisionShape(self.p.GEOM_PLANE, physicsClientId=self.client)
        visual = self.p.createVisualShape(
            self.p.GEOM_BOX,
            halfExtents=(40.0, 40.0, 0.005),
            visualFramePosition=(0.0, 0.0, -0.005),
            rgbaColor=(_FLOOR, _FLOOR, _FLOOR, 1.0),
            specularColor=(0.0, 0.0, 0.0),
            physicsClientId=self.client,
        )
        body = self.p.createMultiBody(0.0, shape, visual, physicsClientId=self.client)
        self.p.changeDynamics(body, -1, lateralFriction=friction, physicsClientId=self.client)
        return int(body)

    def add_box(self, box: Box, friction: float, grey: int) -> int:
        """A box that nothing moves."""
        half = [size / 2 for size in box.size]
        shape = self.p.createCollisionShape(self.p.GEOM_BOX, halfExtents=half, physicsClientId=self.client)
        shade = grey / 255
        visual = self.p.createVisualShape(
            self.p.GEOM_BOX,
            halfExtents=half,
            rgbaColor=(shade, shade, shade, 1.0),
            specularColor=(0.0, 0.0, 0.0),
            physicsClientId=self.client,
        )
        body = self.p.createMultiBody(0.0, shape, visual, *placed(box.pose), physicsClientId=self.client)
        self.p.changeDynamics(body, -1, lateralFriction=friction, physicsClientId=self.client)
        return int(body)

    def texture(self, picture: NDArray[np.uint8]) -> int:
        """Number of a grey picture, which the renderer is given once."""
        key = (picture.shape, picture.tobytes())
        if key not in self._textures:
            self._textures[key] = self._load_texture(picture)
        return self._textures[key]

    def _load_texture(self, picture: NDArray[np.uint8]) -> int:
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "texture.png")
            cv2.imwrite(path, cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
            return int(self.p.loadTexture(path, physicsClientId=self.client))

    def remove(self, body: int) -> None:
        """Take a body out of the world."""
        self.p.removeBody(body, physicsClientId=self.client)

    def pose(self, body: int) -> Transform:
        """World pose (4, 4) of a body's middle of mass."""
        position, turn = self.p.getBasePositionAndOrientation(body, physicsClientId=self.client)
        return matrix(position, turn)

    def set_pose(self, body: int, pose: Transform) -> None:
        """Put a body elsewhere, at rest."""
        self.p.resetBasePositionAndOrientation(body, *placed(pose), physicsClientId=self.client)
        self.p.resetBaseVelocity(body, (0.0,) * 3, (0.0,) * 3, physicsClientId=self.client)

    def touches(self, body: int, anything: bool) -> None:
        """Let a body touch what comes to it, or nothing at all."""
        group, mask = (1, -1) if anything else (0, 0)
        self.p.setCollisionFilterGroupMask(body, -1, group, mask, physicsClientId=self.client)

    def contacts(self, body: int) -> Sequence[tuple[Any, ...]]:
        """Bullet's contact points of a body with all others."""
        points: Sequence[tuple[Any, ...]] = self.p.getContactPoints(bodyA=body, physicsClientId=self.client)
        return points

    def free_share(self, start: NDArray[np.float64], end: NDArray[np.float64]) -> float:
        """How far it is free of all but the robot from a point (3,) towards another: 1 for all the way."""
        mask = ~ROBOT_GROUP
        hit = self.p.rayTest(
            start.tolist(), end.tolist(), collisionFilterMask=mask, physicsClientId=self.client
        )
        return float(hit[0][2])

    # Pictures

    def picture(
        self, view: Transform, projection: Transform, size: tuple[int, int], lit: bool = False
    ) -> NDArray[np.uint8]:
        """What is seen, (height, width, 3) in RGB.

        Args:
            view: (4, 4) from the world to OpenGL's camera frame.
            projection: (4, 4), OpenGL's.
            size: width and height in [px].
            lit: for people, with light from above and shadows; else all is as bright as it is painted.
        """
        width, height = size
        # The EGL renderer always has one light and shadows: from behind what is seen it falls on nothing.
        light = _SUN if lit else tuple((-view[2, :3]).tolist())
        with quiet():
            for _ in range(self._cold):  # the first pictures of the EGL renderer are lit otherwise
                self._render(view, projection, size, light)
            self._cold = 0
            image = self._render(view, projection, size, light)
        picture = np.asarray(image, dtype=np.uint8).reshape(height, width, 4)[..., :3]
        if lit or self.renderer != self.p.ER_BULLET_HARDWARE_OPENGL:
            return picture
        return cv2.convertScaleAbs(picture, alpha=1 / _UNLIT).astype(np.uint8, copy=False)

    def _render(self, view: Transform, projection: Transform, size: tuple[int, int], light: Point) -> Any:
        return self.p.getCameraImage(
            *size,
            view.T.ravel().tolist(),
            projection.T.ravel().tolist(),
            lightDirection=light,
            shadow=0,
            lightAmbientCoeff=1.0,
            lightDiffuseCoeff=0.0,
            lightSpecularCoeff=0.0,
            renderer=self.renderer,
            flags=self.p.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self.client,
        )[2]

    # What is held together

    def pin(self, wanted: Pinned | None) -> None:
        """Hold this together, and nothing else; None lets go."""
        for number in self._pins:
            self.p.removeConstraint(number, physicsClientId=self.client)
        self._pins, self.pinned = [], wanted
        if wanted is None:
            return
        for point, other in zip(wanted.points, wanted.other_points, strict=True):
            number = self.p.createConstraint(
                wanted.body,
                wanted.link,
                wanted.other,
                -1,
                self.p.JOINT_POINT2POINT,
                (0, 0, 0),
                point,
                other,
                physicsClientId=self.client,
            )
            force = wanted.force_n / self.substeps
            self.p.changeConstraint(number, maxForce=force, physicsClientId=self.client)
            self._pins.append(int(number))

    # States

    def state(self) -> dict[str, Any]:
        """Where all bodies are, as Bullet writes it into a file, and what is held together: Bullet keeps no
        constraints.
        """
        return {"bullet": self._saved(), "pinned": to_plain(self.pinned, Pinned | None)}

    def _saved(self) -> bytes:
        """The file that the engine writes now."""
        with tempfile.TemporaryDirectory() as folder, quiet():
            path = Path(folder) / "state.bullet"
            self.p.saveBullet(str(path), physicsClientId=self.client)
            return path.read_bytes()

    def set_state(self, state: object) -> None:
        """Bring back what `state` gave, of this engine or of one whose bodies were made in the same order.

        Where a body stands on one of several shapes, what follows may differ in the last digits: Bullet keeps
        such contacts, but not as they were.
        """
        if not isinstance(state, dict) or state.keys() != {"bullet", "pinned"}:
            raise NotAState("no state of this engine; needed: bullet, pinned")
        content = from_plain(state["bullet"], bytes, "engine")
        pinned = from_plain(state["pinned"], Pinned | None, "pinned")
        self._check_pinned(pinned)
        self.pin(None)
        check_state(content, self._saved())
        with tempfile.TemporaryDirectory() as folder, quiet():
            path = Path(folder) / "state.bullet"
            path.write_bytes(content)
            try:
                self.p.restoreState(fileName=str(path), physicsClientId=self.client)
                self.pin(pinned)
            except self.p.error as error:
                raise NotAState(f"no saved state: the engine refuses it: {error}") from None

    def _check_pinned(self, pinned: Pinned | None) -> None:
        """Whether there are such bodies, and a link; raises `NotAState`."""
        if pinned is None:
            return
        there = {self.p.getBodyUniqueId(n, physicsClientId=self.client) for n in range(self._bodies())}
        if not {pinned.body, pinned.other} <= there or len(pinned.points) != len(pinned.other_points):
            raise NotAState("no saved state: what is held together isn't there")
        if not -1 <= pinned.link < self.p.getNumJoints(pinned.body, physicsClientId=self.client):
            raise NotAState("no saved state: what is held together has no such link")

    def _bodies(self) -> int:
        return int(self.p.getNumBodies(physicsClientId=self.client))


def placed(pose: Transform) -> tuple[list[float], list[float]]:
    """A pose (4, 4) as Bullet wants it: position, and quaternion x, y, z, w."""
    return pose[:3, 3].tolist(), Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()


def matrix(position: Sequence[float], quaternion: Sequence[float]) -> Transform:
    """The pose (4, 4) of a position and a quaternion x, y, z, w."""
    x, y, z, w = quaternion
    result: NDArray[np.float64] = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), position[0]],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), position[1]],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), position[2]],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    return result
