"""Contacts of the arm, its load, or the base's load with solid bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box, Shape, radius_about, top
from handcart.robotics.numerics.arrays import FloatArray, IndexArray, IntArray

from .near_pairs import Boxes, near_boxes, near_spheres
from .rigid_body import RigidBody, meet

LOAD_NAME = "load"
FINGER_LINKS = ("left_finger", "right_finger")
_HANDS = (LOAD_NAME, *FINGER_LINKS, "hand", "camera_body")
LOW_TOP_M = 0.02  # of a body that floor plans leave out
UNTOUCHED_RESTS = (Rest.HAND, Rest.FLOOR, Rest.PERSON)
_GIVE = 0.0005  # bodies that only touch count as free [m]

Skip = Callable[[str, str], bool]
_POSTURES = 4  # whose links' poses are kept: those of a period, and of its begin


class _Bodies(NamedTuple):
    """Bodies of the robot that may touch something."""

    names: list[str]
    geometry: list[RigidBody]
    poses: FloatArray
    """Poses (b, 4, 4) of the bodies in the world."""
    radii: FloatArray
    """Radii (b,) of spheres about the bodies' origins that enclose them, in [m]."""

    def and_more(self, others: _Bodies) -> _Bodies:
        """Return these bodies followed by those of `others`."""
        return _Bodies(
            self.names + others.names,
            self.geometry + others.geometry,
            np.concatenate((self.poses, others.poses)),
            np.concatenate((self.radii, others.radii)),
        )


class _Links(NamedTuple):
    """Some links of the robot."""

    numbers: IndexArray
    names: list[str]
    geometry: list[RigidBody]
    radii: FloatArray

    def posed(self, poses: FloatArray) -> _Bodies:
        """Return the bodies of these links.

        Args:
            poses: (g, 4, 4) world_T_link of all g links of the arm model.
        """
        return _Bodies(self.names, self.geometry, poses[self.numbers], self.radii)


class Touch(NamedTuple):
    """Deepest overlap of a part of the robot with another body: the names of both, depth, direction and
    point.
    """

    depth: float
    """Depth of the overlap, in [m]."""
    body: str
    other: str
    normal: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Unit vector in the world along which the robot's body leaves the other one soonest; zero if unknown."""
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Contact point in the world, in [m]."""


NO_TOUCH = Touch(0.0, "", "")


class ArmContact:
    """Collision check of the arm's links, the fingers and the held thing with the world's solids and things.

    When the base moves, parts mounted above its body (tray, column) and things on it are checked as well. The
    hand and the held thing are also checked against the parts that the arm does not move (base, tray,
    column). The arm is not checked against itself and its own base, which a planner has to do. Distant bodies
    are excluded by bounding spheres.
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
        self._moved_links, self._mounted_links = self._some(self._links), self._some(self._mounted)
        self._fingers = [(g, i) for g, i in enumerate(self._links) if self._names[i] in FINGER_LINKS]
        self._own_numbers = np.array(self._own, dtype=np.intp)
        self._own_radii = self._radius[self._own]
        self._hands_among: dict[int, IndexArray] = {}
        self._hands = [g for g, i in enumerate(self._links) if self._names[i] in _HANDS]
        out = [float(np.hypot(*shapes[i].pose[:2, 3]) + self._radius[i]) for i in self._mounted]
        self._mounted_reach = max(out, default=0.0)
        self._on_hand = {LOAD_NAME, *FINGER_LINKS, *_fixed_on_tip(arm, self._names)}
        self._fixed = [solid.box for solid in scene.solids]
        self._has_low_solids = any(top(box) <= LOW_TOP_M for box in self._fixed)
        self._take_in([], ())
        self._stood: dict[str, tuple[Transform, Box]] = {}
        self._changes = -1
        self._reach: tuple[object, float] = (None, 0.0)
        self._last_poses: dict[bytes, FloatArray] = {}

    def deepest_of_robot(self, base: Pose2, joints: FloatArray, skip: Skip | None = None) -> Touch:
        """Return the deepest overlap between other bodies and all that moves with the base: arm, mounted
        parts and load.

        Args:
            base: 2D pose world_T_base.
            joints: (n,) posture of the arm, in [rad] or [m].
            skip: function that returns True for a pair of bodies to exclude; None excludes no pair.
        """
        scene = self._scene
        reach = max(self._extent(joints), self._extent_on_base())
        self._refresh()
        is_far = scene.full_plan.clearance(base.x, base.y, scene.time)[0] > reach
        if is_far and not self._is_thing_within(base, reach):
            return NO_TOUCH
        world_T_base = scene.leaning_at(base)
        riding = self._riding(world_T_base)
        poses = world_T_base @ self._link_poses(joints)
        mounted = self._mounted_links.posed(poses)
        bodies = self._moved(world_T_base, poses, joints).and_more(mounted).and_more(riding)
        own = set(riding.names)

        def left_out(body: str, other: str) -> bool:
            return other in own or (skip is not None and skip(body, other))

        return self._deepest(bodies, self._near(bodies), left_out)

    def deepest_of_arm(self, joints: FloatArray, skip: Skip | None = None) -> Touch:
        """Return the deepest overlap of the arm in a posture with other bodies; the base is at its current
        pose.

        The robot's own tray, and things on it, are obstacles as well.

        Args:
            joints: (n,) posture of the arm, in [rad] or [m].
            skip: function that returns True for pairs of bodies to exclude.
        """
        scene = self._scene
        self._refresh()
        poses = scene.world_T_base @ self._link_poses(joints)
        bodies = self._moved(scene.world_T_base, poses, joints)
        near, worst = self._near(bodies), NO_TOUCH
        if len(near) and (scene.open_ground or scene.riding() or not self._far(scene.base, joints)):
            worst = self._deepest(bodies, near, skip)
        return max(worst, self._against_robot(bodies, poses))

    def rides_on_hand(self, body: str) -> bool:
        """Return True if a body moves with the hand: a link that no joint moves against the hand, a finger,
        or the held object.
        """
        return body in self._on_hand

    def _far(self, base: Pose2, joints: FloatArray) -> bool:
        """Return whether all solid bodies of the room are beyond the arm's reach; bodies that no floor plan
        shows may be anywhere.

        Args:
            base: 2D pose world_T_base.
            joints: (n,) posture of the arm, in [rad] or [m].
        """
        if self._has_low_solids:
            return False
        plan = self._scene.full_plan
        return plan.clearance(base.x, base.y, self._scene.time)[0] > self._extent(joints)

    def _is_thing_within(self, base: Pose2, reach: float) -> bool:
        """Return whether a thing that is not on the robot may be within `reach`, in [m], of a 2D pose
        world_T_base.
        """
        first = len(self._fixed)
        out = self._arrays.middles[first:, :2] - np.array([base.x, base.y])
        near = np.hypot(*out.T) <= reach + np.linalg.norm(self._arrays.halves[first:], axis=1)
        riding = {thing.name for thing in self._scene.riding()}
        return any(self._boxes[first + int(i)].name not in riding for i in np.flatnonzero(near))

    def travel(self, start: FloatArray, end: FloatArray) -> float:
        """Return the distance between two postures, in [m]: that of the link whose frame moves farthest.

        This is about the largest distance that any point of the arm travels between the postures.

        Args:
            start: (n,) joints of one posture, in [rad] or [m].
            end: (n,) joints of the other posture, in [rad] or [m].
        """
        before, after = self._link_poses(start)[:, :3, 3], self._link_poses(end)[:, :3, 3]
        return math.sqrt(((after - before) ** 2).sum(axis=1).max(initial=0.0))

    def _riding(self, world_T_base: Transform) -> _Bodies:
        """Return the things on the robot as bodies, given the pose world_T_base (4, 4)."""
        back, things = world_T_base @ inverse(self._scene.world_T_base), self._scene.riding()
        return _Bodies(
            [thing.name for thing in things],
            [_rigid(thing, _GIVE) for thing in things],
            np.array([back @ thing.pose @ thing.thing_T_middle for thing in things]).reshape(-1, 4, 4),
            np.array([float(np.linalg.norm(thing.size)) / 2 for thing in things]),
        )

    def _extent_on_base(self) -> float:
        """Return the radius about the base's centre that contains mounted parts and load, in [m]."""
        reach = self._mounted_reach
        for thing in self._scene.riding():
            middle = thing.base_T_thing @ thing.thing_T_middle[:, 3]
            reach = max(reach, float(np.hypot(*middle[:2]) + np.linalg.norm(thing.size[:2]) / 2))
        return reach

    def _extent(self, joints: FloatArray) -> float:
        """Return an upper bound of the radius about the base's centre that contains arm and held object, in
        [m].

        Args:
            joints: (n,) posture of the arm, in [rad] or [m].
        """
        key = (joints.tobytes(), self._scene.held)
        if self._reach[0] != key:
            poses = self._link_poses(joints)[self._links]
            out = np.hypot(poses[:, 0, 3], poses[:, 1, 3]) + self._radius[self._links]
            reach = float(out.max(initial=0.0)) + 0.04
            if self._scene.held is not None:
                hand = self._arm.forward(joints)
                middle = hand @ self._scene.hand_T_held @ self._scene.held.thing_T_middle
                reach = max(reach, float(np.hypot(*middle[:2, 3]) + np.hypot(*self._scene.held.size[:2]) / 2))
            self._reach = (key, reach)
        return self._reach[1]

    def _some(self, links: list[int]) -> _Links:
        """Return some of the links, by their numbers."""
        names, geometry = [self._names[i] for i in links], [self._geometry[i] for i in links]
        return _Links(np.array(links, dtype=np.intp), names, geometry, self._radius[links])

    def _moved(self, world_T_base: Transform, poses: FloatArray, joints: FloatArray) -> _Bodies:
        """Return the links that the arm moves, the fingers at their opening, and the held object.

        Args:
            world_T_base: (4, 4) pose of the base.
            poses: (g, 4, 4) world_T_link of all links.
            joints: (n,) posture of the arm, in [rad] or [m].
        """
        links = self._moved_links.posed(poses)
        for g, i in self._fingers:
            side = 1.0 if self._names[i] == FINGER_LINKS[0] else -1.0
            links.poses[g, :3, 3] += side * self._scene.width / 2 * links.poses[g, :3, 1]
        held = self._held(world_T_base, joints)
        return links if held is None else links.and_more(held)

    def _link_poses(self, joints: FloatArray) -> FloatArray:
        """Return base_T_link (g, 4, 4) of all links at joints (n,) in [rad] or [m]; the result is cached."""
        key = joints.tobytes()
        if key not in self._last_poses:
            if len(self._last_poses) >= _POSTURES:
                del self._last_poses[next(iter(self._last_poses))]
            self._last_poses[key] = self._arm.link_poses(joints)
        return self._last_poses[key]

    def _held(self, world_T_base: Transform, joints: FloatArray) -> _Bodies | None:
        thing = self._scene.held
        if thing is None:
            return None
        pose = world_T_base @ self._arm.forward(joints) @ self._scene.hand_T_held @ thing.thing_T_middle
        radius = float(np.linalg.norm(np.array(thing.size) - 2 * _GIVE)) / 2
        return _Bodies([LOAD_NAME], [_rigid(thing, 2 * _GIVE)], pose[None], np.array([radius]))

    def _near(self, bodies: _Bodies) -> IntArray:
        """Return the pairs (m, 2) of the number of a body and the number of a present box near it."""
        there = (self._appears <= self._scene.time) & (self._scene.time < self._leaves)
        return near_boxes(bodies.poses, bodies.radii, self._arrays, there)

    def _deepest(self, bodies: _Bodies, near: IntArray, skip: Skip | None) -> Touch:
        """Return the deepest overlap among pairs of bodies and boxes.

        Args:
            bodies: bodies of the robot.
            near: (m, 2) number of a body and number of a box in each row.
            skip: excludes pairs of bodies for which it returns True.
        """
        worst = NO_TOUCH
        for g, n in near.tolist():
            name, box = bodies.names[g], self._boxes[n]
            if skip is not None and skip(name, box.name):
                continue
            met = meet(bodies.geometry[g], bodies.poses[g], self._solids[n], box.pose)
            if met.depth > worst.depth:
                worst = Touch(met.depth, name, box.name, met.normal, met.point)
        return worst

    def _against_robot(self, bodies: _Bodies, poses: FloatArray) -> Touch:
        """Return the deepest overlap of the hand and the held object with the parts of the robot that the arm
        does not move.

        Args:
            bodies: bodies that the arm moves.
            poses: (g, 4, 4) world_T_link of all links.
        """
        hands = self._hand_numbers(len(bodies.names))
        near = near_spheres(
            bodies.poses[hands], bodies.radii[hands], poses[self._own_numbers], self._own_radii
        )
        worst = NO_TOUCH
        for g, k in near.tolist():
            i, hand = self._own[k], int(hands[g])
            met = meet(bodies.geometry[hand], bodies.poses[hand], self._geometry[i], poses[i])
            worst = max(worst, Touch(met.depth, bodies.names[hand], self._names[i], met.normal, met.point))
        return worst

    def _hand_numbers(self, count: int) -> IndexArray:
        """Return the numbers (k,) of the hand's links and of the held object, among `count` moved bodies."""
        if count not in self._hands_among:
            held = range(len(self._links), count)
            self._hands_among[count] = np.array([*self._hands, *held], dtype=np.intp)
        return self._hands_among[count]

    def _refresh(self) -> None:
        """Update the boxes of things to their present poses."""
        key = self._scene.changes
        if key == self._changes:
            return
        self._changes = key
        things = [thing for thing in self._scene.things() if thing.rest not in UNTOUCHED_RESTS]
        standing = [self._box(thing) for thing in things]
        boxes = [*self._fixed, *standing]
        if len(boxes) != len(self._boxes):
            self._take_in(boxes, things)
            return
        for number, (thing, box) in enumerate(zip(things, standing, strict=True), start=len(self._fixed)):
            before = self._boxes[number]
            if box is not before:
                self._boxes[number] = box
                if box.size != before.size or box.name != before.name:
                    self._solids[number] = _rigid(thing, _GIVE)
                self._arrays.place(number, np.array(box.size), box.pose)

    def _take_in(self, boxes: list[Box], things: Sequence[Thing]) -> None:
        """Take in solids of the world, and behind them the things that are there now."""
        self._boxes = boxes
        sizes = np.array([box.size for box in boxes]).reshape(-1, 3)
        self._solids = [RigidBody.box(size) for size in sizes[: len(boxes) - len(things)] - _GIVE]
        self._solids += [_rigid(thing, _GIVE) for thing in things]
        self._arrays = Boxes(sizes, np.array([box.pose for box in boxes]).reshape(-1, 4, 4))
        always = np.zeros(len(things))
        self._appears = np.append([solid.appears for solid in self._scene.solids], always)
        self._leaves = np.append([solid.leaves for solid in self._scene.solids], always + np.inf)

    def _box(self, thing: Thing) -> Box:
        """Return the posed solid of a thing, built again after the thing was moved."""
        pose, box = self._stood.get(thing.name, (None, None))
        if box is None or pose is not thing.pose:
            box = thing.box()
            self._stood[thing.name] = thing.pose, box
        return box


def _rigid(thing: Thing, less: float) -> RigidBody:
    """Return the body of a thing, `less` shorter along each of its axes, in [m]."""
    return RigidBody.of(thing.solid(less)) if thing.is_round else RigidBody.box(np.array(thing.size) - less)


def _still(arm: ArmModel, shapes: Collection[Shape]) -> set[str]:
    """Return the names of the links that no joint of the arm moves."""
    here = {s.name: s.pose for s in arm.link_shapes(0.5 * (arm.lower + arm.upper))}
    there = {s.name: s.pose for s in arm.link_shapes(0.5 * (arm.lower + arm.upper) + 0.1)}
    return {name for name, pose in here.items() if np.allclose(pose, there[name])}


def _fixed_on_tip(arm: ArmModel, names: list[str]) -> set[str]:
    """Return the names of the links with bodies that are fixed to the arm's tip."""
    here, there = 0.5 * (arm.lower + arm.upper), 0.5 * (arm.lower + arm.upper) + 0.1
    tip_T_bodies = [inverse(arm.forward(q)) @ arm.link_poses(q) for q in (here, there)]
    return {name for name, a, b in zip(names, *tip_T_bodies, strict=True) if np.allclose(a, b, atol=1e-6)}
