"""Bullet: its clock, its bodies, its saved states."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.physics.engine.engine import (
    GRAVITY_M_S2,
    ContactPoint,
    Engine,
    Pinned,
    Touching,
)
from handcart.backends.physics.engine.thing_form import ThingForm
from handcart.backends.plain_values import from_plain, to_plain
from handcart.backends.saved_state import NotAState
from handcart.backends.simulation.world.material import WOOD_MATERIAL, Material
from handcart.backends.simulation.world.sheet import Sheet
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .box_mesh import box_mesh
from .bullet import NoWorldJoints, bullet, quiet
from .bullet_pose import matrix, placed
from .bullet_renderer import BulletRenderer
from .bullet_shapes import floor_look, plain_box, thing_shape, tile_shape
from .state_signature import check_signature, sign

ROBOT_GROUP = 64  # collision group of the robot: no beam of its range sensor meets it
_ITERATIONS = 100
_STICKS = 0.8  # share of a sticking contact's slide that one step takes back

_OFF = 2e-4  # [m] that a sheet lies above what it is painted on
_FLAT = ((0.5, 0.5),) * 4
_LEVEL = 1  # of its pictures: the renderer takes the nearest points of a finer one


class BulletEngine(Engine):
    """Physics engine Bullet, with a client (a separate world) of its own; body numbers are Bullet's.

    A chunk, the time between two commands to drives, has `substeps` steps of the solver. Bullet converts the
    impulses of a single step to forces as if they had acted for a chunk. Therefore forces given to Bullet are
    divided by `substeps`, and forces that it returns are multiplied by it.
    """

    CHUNK = 0.005
    CONTACTS_CARRY = 0.5  # they creep

    def __init__(self, period: float, window: bool = False) -> None:
        """Start the engine.

        Args:
            period: the control period, in [s].
            window: whether to show the world; needs a display.
        """
        super().__init__(period)
        self.p = bullet()
        with quiet():
            self.client = self.p.connect(self.p.GUI if window else self.p.DIRECT)
        self._connected = True
        self._pins: list[int] = []
        self._pinned: Pinned | None = None
        self._pulled: tuple[int, list[float]] | None = None
        self.renderer = BulletRenderer(self.p, self.client, window)
        """Renderer of pictures; it shows the shapes made after it."""
        self.p.setGravity(0.0, 0.0, -GRAVITY_M_S2, physicsClientId=self.client)
        self.p.setPhysicsEngineParameter(
            fixedTimeStep=self.chunk,
            numSubSteps=self.substeps,
            numSolverIterations=_ITERATIONS,
            frictionERP=_STICKS,
            enableConeFriction=0,  # with it, a held object creeps out of the hand
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )

    @property
    @override
    def pinned(self) -> Pinned | None:
        return self._pinned

    @override
    def step(self, steps: int | None = None) -> None:
        if self._pulled is not None:  # Bullet forgets a force after each chunk
            body, (x, y, z) = self._pulled
            middle = self.p.getBasePositionAndOrientation(body, physicsClientId=self.client)[0]
            self.p.applyExternalForce(
                body, -1, (x, y, z), middle, self.p.WORLD_FRAME, physicsClientId=self.client
            )
        self.p.stepSimulation(physicsClientId=self.client)

    @override
    def close(self) -> None:
        if self._connected:
            self._connected = False
            with quiet():
                self.p.disconnect(physicsClientId=self.client)

    # Bodies

    def add_floor(self, friction: float) -> int:
        """Add a level floor at height 0; return its number as a body of the engine.

        The floor is unlimited; pictures show only the part within 40 m of the origin.

        Args:
            friction: Coulomb's coefficient of friction, without unit.
        """
        shape = self.p.createCollisionShape(self.p.GEOM_PLANE, physicsClientId=self.client)
        body = self.p.createMultiBody(0.0, shape, floor_look(self.client), physicsClientId=self.client)
        return self._rub(body, friction)

    @override
    def add_box(
        self, box: Box, friction: float, grey: int, moves: bool = False, material: Material = WOOD_MATERIAL
    ) -> int:
        shapes = plain_box(self.client, box.size, grey)
        body = self.p.createMultiBody(0.0, *shapes, *placed(box.pose), physicsClientId=self.client)
        return self._rub(body, friction)

    @override
    def add_tile(self, corner: FloatArray, cell: float, heights: FloatArray, friction: float) -> int:
        shapes = tile_shape(self.client, cell, heights)
        x, y = corner + cell * (len(heights) - 1) / 2
        middle = (float(heights.min()) + float(heights.max())) / 2  # Bullet centres a height field
        body = self.p.createMultiBody(0.0, *shapes, (x, y, middle), physicsClientId=self.client)
        return self._rub(body, friction)

    def _rub(self, body: int, friction: float) -> int:
        self.p.changeDynamics(body, -1, lateralFriction=friction, physicsClientId=self.client)
        return int(body)

    @override
    def add_sheet(self, sheet: Sheet) -> None:
        picture, metres = sheet.levels[min(_LEVEL, len(sheet.levels) - 1)]
        height, width = (size * metres for size in picture.shape)
        faces = [_FLAT] * 4 + [((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), _FLAT]
        visual = box_mesh(self.client, (width, height, _OFF), faces)
        pose = sheet.pose @ transform((0.0, 0.0, _OFF / 2))
        body = self.p.createMultiBody(0.0, -1, visual, *placed(pose), physicsClientId=self.client)
        self.show(int(body), picture)

    @override
    def add_thing(self, form: ThingForm) -> int:
        p, client = self.p, self.client
        if form.hung is not None:
            raise NoWorldJoints(form.hung.label)
        shape = thing_shape(client, form.pieces)
        visual = box_mesh(client, form.size, form.uvs, form.is_round)
        body = int(p.createMultiBody(form.mass, shape, visual, *placed(form.middle), physicsClientId=client))
        self.show(body, form.picture)
        if form.sticks is not None:
            p.changeDynamics(
                body,
                -1,
                frictionAnchor=1,
                contactStiffness=form.sticks.stiffness,
                contactDamping=form.sticks.damping,
                physicsClientId=client,
            )
        asleep = p.ACTIVATION_STATE_SLEEP if form.asleep else 0
        p.changeDynamics(
            body,
            -1,
            lateralFriction=form.friction,
            activationState=p.ACTIVATION_STATE_ENABLE_SLEEPING | asleep,
            physicsClientId=client,
        )
        return body

    @override
    def show(self, body: int, picture: ByteArray) -> None:
        self.renderer.show(body, picture)

    @override
    def weigh(self, body: int, mass: float) -> None:
        self.p.changeDynamics(body, -1, mass=mass, physicsClientId=self.client)

    @override
    def pose(self, body: int) -> Transform:
        position, turn = self.p.getBasePositionAndOrientation(body, physicsClientId=self.client)
        return matrix(position, turn)

    @override
    def set_pose(self, body: int, pose: Transform) -> None:
        self.p.resetBasePositionAndOrientation(body, *placed(pose), physicsClientId=self.client)
        self.p.resetBaseVelocity(body, (0.0,) * 3, (0.0,) * 3, physicsClientId=self.client)

    @override
    def pull(self, body: int | None, force: FloatArray) -> None:
        self._pulled = None if body is None else (body, force.tolist())

    @override
    def touches(self, body: int, anything: bool) -> None:
        group, mask = (1, -1) if anything else (0, 0)
        self.p.setCollisionFilterGroupMask(body, -1, group, mask, physicsClientId=self.client)

    @override
    def touching(self, body: int) -> set[Touching]:
        return {Touching(point[3], point[2], point[4]) for point in self._pressing(body)}

    @override
    def contacts(self, body: int) -> list[ContactPoint]:
        return [self._contact(point) for point in self._pressing(body)]

    def _pressing(self, body: int) -> list[Sequence[Any]]:
        points = self.p.getContactPoints(bodyA=body, physicsClientId=self.client)
        return [point for point in points if point[9] > 0.0]

    def _contact(self, point: Sequence[Any]) -> ContactPoint:
        """Return a contact point from Bullet's tuple, whose first body is the one whose contacts are read."""
        other, link, other_link, normal = point[2], point[3], point[4], point[7]
        (pressed, one, first, two, second), times = point[9:14], self.substeps
        x, y, z = (
            times * (pressed * n + one * a + two * b) for n, a, b in zip(normal, first, second, strict=True)
        )
        return ContactPoint(link, other, other_link, normal, (x, y, z))

    def free_shares(self, start: FloatArray, ends: FloatArray) -> FloatArray:
        """Return the free share of each line from a start to an end, ignoring the robot.

        Args:
            start: (3,) common start of the lines in the world, in [m].
            ends: (n, 3) ends of the lines in the world, in [m].

        Returns:
            (n,) distance from the start to the first body divided by the line's length, 0 to 1; infinity if
            all of a line is free.
        """
        starts = np.broadcast_to(start, ends.shape)
        hits = self.p.rayTestBatch(
            starts.tolist(),
            ends.tolist(),
            numThreads=1,
            collisionFilterMask=~ROBOT_GROUP,
            physicsClientId=self.client,
        )
        return np.array([hit[2] if hit[0] >= 0 else np.inf for hit in hits])

    # Bodies that are held together

    @override
    def pin(self, wanted: Pinned | None) -> None:
        for number in self._pins:
            self.p.removeConstraint(number, physicsClientId=self.client)
        self._pins, self._pinned = [], wanted
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
        """Return the state for a checkpoint: the content of Bullet's state file, a signature of it, and the
        rigid connection of hand and held thing, which Bullet does not save.
        """
        content = self._saved()
        pinned = to_plain(self._pinned, Pinned | None)
        return {"bullet": content, "signature": sign(content, self._signed_form()), "pinned": pinned}

    def _signed_form(self) -> str:
        """Return the version of Bullet, and the number of joints of each body."""
        p, client = self.p, self.client
        numbers = range(p.getNumBodies(physicsClientId=client))
        bodies = [p.getBodyUniqueId(number, physicsClientId=client) for number in numbers]
        joints = [p.getNumJoints(body, physicsClientId=client) for body in bodies]
        return f"{p.getAPIVersion(physicsClientId=client)} {joints}"

    def _saved(self) -> bytes:
        """Return the file that the engine writes now."""
        with tempfile.TemporaryDirectory() as folder, quiet():
            path = Path(folder) / "state.bullet"
            self.p.saveBullet(str(path), physicsClientId=self.client)
            return path.read_bytes()

    def set_state(self, state: object) -> None:
        """Restore a state that `state` returned for an engine whose bodies were created in the same order.

        Bullet does not restore contacts with a body of several shapes exactly. If a body rests on a body of
        several shapes, a restored run may differ from the original run in the last digits.
        """
        if not isinstance(state, dict) or state.keys() != {"bullet", "signature", "pinned"}:
            raise NotAState("no state of this engine; needed: bullet, signature, pinned")
        content = from_plain(state["bullet"], bytes, "engine")
        signature = from_plain(state["signature"], bytes, "signature")
        pinned = from_plain(state["pinned"], Pinned | None, "pinned")
        check_signature(content, signature, self._signed_form())
        self._check_pinned(pinned)
        self.pin(None)
        with tempfile.TemporaryDirectory() as folder, quiet():
            path = Path(folder) / "state.bullet"
            path.write_bytes(content)
            try:
                self.p.restoreState(fileName=str(path), physicsClientId=self.client)
                self.pin(pinned)
            except self.p.error as error:
                raise NotAState(f"no saved state: the engine refuses it: {error}") from None

    def _check_pinned(self, pinned: Pinned | None) -> None:
        """Check that the pinned bodies and the link exist.

        Raises:
            NotAState: a body or the link does not exist, or the numbers of points differ.
        """
        if pinned is None:
            return
        there = {self.p.getBodyUniqueId(n, physicsClientId=self.client) for n in range(self._bodies())}
        if not {pinned.body, pinned.other} <= there or len(pinned.points) != len(pinned.other_points):
            raise NotAState("no saved state: the held body is missing")
        if not -1 <= pinned.link < self.p.getNumJoints(pinned.body, physicsClientId=self.client):
            raise NotAState("no saved state: the held body has no such link")

    def _bodies(self) -> int:
        return int(self.p.getNumBodies(physicsClientId=self.client))
