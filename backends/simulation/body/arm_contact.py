"""Whether the arm, what it holds, or what rides on the base stands in something solid."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.simulation.scene import Scene
from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box, Shape, radius_about, top

from .rigid_body import RigidBody, overlap

HELD = "load"
FINGERS = ("left_finger", "right_finger")
_HANDS = (HELD, *FINGERS, "hand", "camera_body")
_GIVE = 0.0005  # bodies that only touch count as free [m]

Skip = Callable[[str, str], bool]
Body = tuple[str, RigidBody, Transform, float]
"""Name, geometry, pose in the world, radius of the sphere about it."""


class Touch(NamedTuple):
    """The deepest overlap with a solid."""

    depth: float
    """[m]"""
    body: str
    other: str


FREE = Touch(0.0, "", "")


class ArmContact:
    """Overlaps of the moved links, fingers and held thing with the world's solids and the things in it.

    Where the base is moved, those of what is mounted above its body (tray, column) and of what stands on it
    as well. The arm against itself and its own base is not checked (a planner's task), the hand and what
    it holds against all that the arm doesn't move (base, tray, column) are. Spheres about the bodies sort out
    what is far.
    """

    def __init__(self, scene: Scene, arm: ArmModel) -> None:
        self._scene, self._arm = scene, arm
        shapes = arm.link_shapes(scene.joints)
        still = _still(arm, shapes)
        self._links = [i for i, s in enumerate(shapes) if s.name not in still]
        self._own = [i for i, s in enumerate(shapes) if s.name in still]
        above = scene.robot.body_height + _GIVE
        self._mounted = [i for i in self._own if top(shapes[i]) > above and shapes[i].name != "base"]
        self._names = [shape.name for shape in shapes]
        self._geometry = [RigidBody.of(shape) for shape in shapes]
        self._radius = np.array([radius_about(shape) for shape in shapes])
        out = [float(np.hypot(*shapes[i].pose[:2, 3]) + self._radius[i]) for i in self._mounted]
        self._mounted_reach = max(out, default=0.0)
        self._fixed = [solid.box for solid in scene.solids]
        self._boxes: list[Box] = []
        self._changes = -1
        self._reach: tuple[object, float] = (None, 0.0)
        self._last_poses = (b"", np.zeros((0, 4, 4)))

    def deepest(self, base: Pose2, joints: NDArray[np.float64], skip: Skip | None = None) -> Touch:
        """The deepest overlap with the base and the joints there; `skip(body, other)` leaves pairs out."""
        scene = self._scene
        far = scene.full_plan.clearance(base.x, base.y, scene.time)[0] > self._extent(joints)
        return FREE if far else self._check(scene.leaning_at(base), joints, skip)

    def deepest_of_robot(self, base: Pose2, joints: NDArray[np.float64], skip: Skip | None = None) -> Touch:
        """The same, with what is mounted on the base and what stands on it; all of it moves with the base."""
        scene = self._scene
        reach = max(self._extent(joints), self._extent_on_base())
        if scene.full_plan.clearance(base.x, base.y, scene.time)[0] > reach:
            return FREE
        self._refresh()
        world_T_base, riding = scene.leaning_at(base), self._riding(scene.leaning_at(base))
        poses = world_T_base @ self._link_poses(joints)
        mounted = [(self._names[i], self._geometry[i], poses[i], self._radius[i]) for i in self._mounted]
        own = {name for name, *_ in riding}
        bodies = [*self._bodies(world_T_base, poses, joints), *mounted, *riding]

        def left_out(body: str, other: str) -> bool:
            return other in own or (skip is not None and skip(body, other))

        return self._against_world(bodies, left_out)

    def deepest_of_arm(self, joints: NDArray[np.float64], skip: Skip | None = None) -> Touch:
        """The same where the base is, the robot's own tray and what stands on it included."""
        world_T_base = self._scene.world_T_base
        worst = self.deepest(self._scene.base, joints, skip)
        if worst is FREE and (self._scene.open_ground or self._scene.riding()):
            worst = self._check(world_T_base, joints, skip)
        poses = world_T_base @ self._link_poses(joints)
        hand = [body for body in self._bodies(world_T_base, poses, joints) if body[0] in _HANDS]
        return max(worst, self._against_robot(hand, poses))

    def travel(self, start: NDArray[np.float64], end: NDArray[np.float64]) -> float:
        """How far the middle of any link goes between two postures at most, about, in [m]."""
        before, after = self._link_poses(start)[:, :3, 3], self._link_poses(end)[:, :3, 3]
        return float(np.linalg.norm(after - before, axis=1).max())

    def _riding(self, world_T_base: Transform) -> list[Body]:
        """What stands on the robot, the base being there."""
        back = world_T_base @ inverse(self._scene.world_T_base)
        return [
            (
                thing.name,
                RigidBody.box(np.array(thing.size) - _GIVE),
                back @ thing.pose @ thing.thing_T_middle,
                float(np.linalg.norm(thing.size)) / 2,
            )
            for thing in self._scene.riding()
        ]

    def _extent_on_base(self) -> float:
        """Radius about the base's centre that what is mounted and what rides on it stay in, in [m]."""
        here = inverse(self._scene.world_T_base)
        reach = self._mounted_reach
        for thing in self._scene.riding():
            middle = here @ thing.pose @ thing.thing_T_middle[:, 3]
            reach = max(reach, float(np.hypot(*middle[:2]) + np.linalg.norm(thing.size[:2]) / 2))
        return reach

    def _extent(self, joints: NDArray[np.float64]) -> float:
        """Radius about the base's centre that the arm and its load stay in, in [m], on the safe side."""
        key = (joints.tobytes(), self._scene.held)
        if self._reach[0] != key:
            poses = self._link_poses(joints)[self._links]
            out = np.hypot(poses[:, 0, 3], poses[:, 1, 3]) + self._radius[self._links]
            reach = float(out.max()) + 0.04
            if self._scene.held is not None:
                hand = self._arm.forward(joints)
                middle = hand @ self._scene.hand_T_held @ self._scene.held.thing_T_middle
                reach = max(reach, float(np.hypot(*middle[:2, 3]) + np.hypot(*self._scene.held.size[:2]) / 2))
            self._reach = (key, reach)
        return self._reach[1]

    def _check(self, world_T_base: Transform, joints: NDArray[np.float64], skip: Skip | None) -> Touch:
        self._refresh()
        poses = world_T_base @ self._link_poses(joints)
        return self._against_world(self._bodies(world_T_base, poses, joints), skip)

    def _bodies(
        self, world_T_base: Transform, poses: NDArray[np.float64], joints: NDArray[np.float64]
    ) -> list[Body]:
        """Moved links, fingers where they stand, and what is held."""
        bodies = [(self._names[i], self._geometry[i], poses[i], self._radius[i]) for i in self._links]
        for i, (name, geometry, pose, radius) in enumerate(bodies):
            if name in FINGERS:
                side = 1.0 if name == FINGERS[0] else -1.0
                shifted = pose.copy()
                shifted[:3, 3] += side * self._scene.width / 2 * pose[:3, 1]
                bodies[i] = (name, geometry, shifted, radius)
        held = self._held(world_T_base, joints)
        return bodies if held is None else [*bodies, held]

    def _link_poses(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """base_T_link (g, 4, 4): asked several times in a period for the same joints."""
        key = joints.tobytes()
        if self._last_poses[0] != key:
            self._last_poses = (key, self._arm.link_poses(joints))
        return self._last_poses[1]

    def _held(self, world_T_base: Transform, joints: NDArray[np.float64]) -> Body | None:
        thing = self._scene.held
        if thing is None:
            return None
        pose = world_T_base @ self._arm.forward(joints) @ self._scene.hand_T_held @ thing.thing_T_middle
        size = np.array(thing.size) - 2 * _GIVE
        return HELD, RigidBody.box(size), pose, float(np.linalg.norm(size)) / 2

    def _against_world(self, bodies: list[Body], skip: Skip | None) -> Touch:
        centres, radii = _spheres(bodies)
        close = self._close(centres, radii)
        local = np.einsum("nji,gnj->gni", self._turn[close], centres[:, None] - self._middle[close])
        outside = np.maximum(np.abs(local) - self._half[close], 0.0)
        worst = FREE
        for g, k in np.argwhere((outside**2).sum(axis=2) < radii[:, None] ** 2):
            n = close[k]
            name, geometry, pose, _ = bodies[g]
            if skip is not None and skip(name, self._boxes[n].name):
                continue
            depth = overlap(geometry, pose, self._solids[n], self._boxes[n].pose)
            if depth > worst.depth:
                worst = Touch(depth, name, self._boxes[n].name)
        return worst

    def _against_robot(self, bodies: list[Body], poses: NDArray[np.float64]) -> Touch:
        centres, radii = _spheres(bodies)
        away = centres[:, None] - poses[self._own, :3, 3]
        close = (away**2).sum(axis=2) < (radii[:, None] + self._radius[self._own]) ** 2
        worst = FREE
        for g, k in np.argwhere(close):
            i, (name, geometry, pose, _) = self._own[k], bodies[g]
            depth = overlap(geometry, pose, self._geometry[i], poses[i])
            worst = max(worst, Touch(depth, name, self._names[i]))
        return worst

    def _close(self, centres: NDArray[np.float64], radii: NDArray[np.float64]) -> NDArray[np.int64]:
        """Those boxes that are there and that the sphere about all bodies' spheres may reach."""
        middle = centres.mean(axis=0)
        reach = float((np.linalg.norm(centres - middle, axis=1) + radii).max())
        x, y, z = (self._middle - middle).T
        close = x**2 + y**2 + z**2 < (self._ball + reach) ** 2
        close &= (self._appears <= self._scene.time) & (self._scene.time < self._leaves)
        return np.flatnonzero(close)

    def _refresh(self) -> None:
        """Take things from where they are now."""
        key = self._scene.changes
        if key == self._changes:
            return
        self._changes = key
        standing = [
            thing.box() for thing in self._scene.things() if thing.rest not in (Rest.HAND, Rest.FLOOR)
        ]
        self._boxes = [*self._fixed, *standing]
        self._solids = [RigidBody.box(size) for size in np.array([box.size for box in self._boxes]) - _GIVE]
        poses = np.array([box.pose for box in self._boxes]).reshape(-1, 4, 4)
        self._middle, self._turn = poses[:, :3, 3], poses[:, :3, :3]
        self._half = np.array([box.size for box in self._boxes]).reshape(-1, 3) / 2
        self._ball = np.linalg.norm(self._half, axis=1)
        always = np.zeros(len(standing))
        self._appears = np.append([solid.appears for solid in self._scene.solids], always)
        self._leaves = np.append([solid.leaves for solid in self._scene.solids], always + np.inf)


def _spheres(bodies: list[Body]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Middles (n, 3) and radii (n,) of the spheres about them."""
    middles = [pose[:3, 3] for _, _, pose, _ in bodies]
    return np.array(middles).reshape(-1, 3), np.array([radius for *_, radius in bodies])


def _still(arm: ArmModel, shapes: Collection[Shape]) -> set[str]:
    """Names of the links that no joint of the arm moves."""
    here = {s.name: s.pose for s in arm.link_shapes(0.5 * (arm.lower + arm.upper))}
    there = {s.name: s.pose for s in arm.link_shapes(0.5 * (arm.lower + arm.upper) + 0.1)}
    return {name for name, pose in here.items() if np.allclose(pose, there[name])}
