"""Contacts and clearance of an arm with itself, its robot, its surroundings and what it holds."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.coal_bodies import coal_body
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.kinematics.shapes import Shape
from handcart.robotics.numerics.arrays import FloatArray

ARM_MARGIN_M = 0.005  # between the arm and anything
HELD_NAME = "held"
_EASED_M = 1e-5  # within which a posture is as close as another one
_TREE_BODIES = 100  # beyond which a tree of boxes finds close bodies faster than a check of all pairs
_TOUCH = 1e-6  # coal calls overlapping bodies free at margin 0: its GJK stops at a distance of 1e-10 [m]


class CollisionModel:
    """Collision checks of an arm against obstacles, for one pose of the base.

    Bodies are convex: a mesh is replaced by its convex hull. They are checked by the library coal, the
    successor of FCL. Links are checked against each other, except neighbours along the chain and links that
    can't move against each other. Links that the arm moves are checked against the obstacles, but not the
    base. A held body is checked against links and obstacles, except the hand that holds it. A model doesn't
    change; create another one when the hand takes something.

    Args:
        arm: the arm; joints outside the arm, such as fingers, stay at the positions set in its model
            (`ArmModel.with_others`).
        obstacles: bodies posed in the frame world.
        held: a body posed in the frame of the arm's tip, or None.
        world_T_base: (4, 4) pose of the arm's base link in the frame of the obstacles; None: the same
            frame.
        margin: pairs closer than this count as in collision, in [m].
        allowed: pairs of names (links, obstacles' names, "held") that may touch in addition to those of the
            arm itself, such as a held object and the tray below it.
    """

    def __init__(
        self,
        arm: ArmModel,
        obstacles: Sequence[Shape] = (),
        held: Shape | None = None,
        world_T_base: Transform | None = None,
        margin: float = 0.0,
        allowed: Collection[tuple[str, str]] = (),
    ) -> None:
        self.arm = arm
        self.margin = margin
        self._around, self._also_allowed = tuple(obstacles), tuple(allowed)
        self._allowed = {frozenset(pair) for pair in (*arm.allowed, *allowed)}
        self._model, self._bodies, root_T_base = arm.for_collision()
        self._names = [self._model.frames[body.parentFrame].name for body in self._bodies.geometryObjects]
        self._links = range(len(self._names))
        self._held_body, self._world_T_base = held, world_T_base
        self._held = None if held is None else len(self._names)
        root_T_world = root_T_base if world_T_base is None else root_T_base * pin.SE3(world_T_base).inverse()
        if held is not None:
            joint, joint_T_tip = arm.tip_mount()
            self._add(held, HELD_NAME, joint, joint_T_tip)
        for obstacle in obstacles:
            self._add(obstacle, obstacle.name, 0, root_T_world)
        self._surroundings = tuple(obstacles)
        self._obstacles = range(len(self._names) - len(obstacles), len(self._names))
        self._pair()
        self._known_ends: dict[bytes, bool] = {}
        self._model_data = self._model.createData()
        self._data = pin.GeometryData(self._bodies)
        for request in self._data.collisionRequests:
            request.security_margin = max(margin, _TOUCH)
        middle = arm.ordered(0.5 * (arm.lower + arm.upper))
        pin.updateGeometryPlacements(self._model, self._model_data, self._bodies, self._data, middle)
        many = len(self._names) > _TREE_BODIES
        manager = (
            pin.BroadPhaseManager_DynamicAABBTreeCollisionManager
            if many
            else pin.BroadPhaseManager_NaiveCollisionManager
        )
        self._broad_phase = manager(self._model, self._bodies, self._data)

    @property
    def pairs(self) -> int:
        """Number of pairs of bodies that are checked for collisions."""
        return len(self._bodies.collisionPairs)

    def in_collision(self, q: FloatArray) -> bool:
        """Return True if two bodies are closer than the margin at joint angles `q` (n,), in [rad] or [m]."""
        angles = self.arm.ordered(q)
        found: bool = pin.computeCollisions(self._model, self._model_data, self._broad_phase, angles, True)
        return found

    def distance(self, q: FloatArray) -> float:
        """Return the least distance, in [m], between two bodies at joint angles `q` (n,), in [rad] or [m].

        Below zero it is the depth by which the bodies penetrate each other.
        """
        arguments = (self._model, self._model_data, self._bodies, self._data, self.arm.ordered(q))
        closest = pin.computeDistances(*arguments)
        return float(self._data.distanceResults[closest].min_distance)

    def contacts(self, q: FloatArray) -> list[tuple[str, str]]:
        """Return pairs of names, for messages, of all bodies that are closer to each other than the margin.

        Args:
            q: (n,) joint angles, in [rad] or [m].
        """
        arguments = (self._model, self._model_data, self._bodies, self._data, self.arm.ordered(q))
        pin.computeCollisions(*arguments, False)
        hits = zip(self._bodies.collisionPairs, self._data.collisionResults, strict=True)
        pairs = [(self._names[p.first], self._names[p.second]) for p, hit in hits if hit.isCollision()]
        return list(dict.fromkeys(pairs))

    def eased_at(self, q: FloatArray) -> CollisionModel:
        """Return a model like this one in which bodies that are closer than the margin at a posture may stay
        as close, but not come closer. Bodies that touch there still collide.

        Args:
            q: (n,) joint angles of the posture, in [rad] or [m].
        """
        eased = CollisionModel(
            self.arm, self._around, self._held_body, self._world_T_base, self.margin, self._also_allowed
        )
        arguments = (eased._model, eased._model_data, eased._bodies, eased._data, self.arm.ordered(q))
        pin.computeDistances(*arguments)
        requests = zip(eased._data.collisionRequests, eased._data.distanceResults, strict=True)
        for request, result in requests:
            if result.min_distance <= request.security_margin:
                request.security_margin = max(_TOUCH, result.min_distance - _EASED_M)
        return eased

    @property
    def holds(self) -> bool:
        """True if the hand holds a body."""
        return self._held is not None

    def touches(self, q: FloatArray, body: Shape) -> bool:
        """Return whether a link that the arm moves, or the held body, touches another body at `q` (n,).

        Args:
            q: (n,) joint angles, in [rad] or [m].
            body: other body, posed in the frame of the obstacles.
        """
        other = CollisionModel(self.arm, (body,), self._held_body, self._world_T_base)
        return any(body.name in pair for pair in other.contacts(q))

    def obstacle_touches(self, body: Shape) -> bool:
        """Return whether an obstacle touches another body, posed in the frame of the obstacles."""
        return next(self._obstacles_near(body, _TOUCH), None) is not None

    def obstacles_near(self, body: Shape, distance: float) -> frozenset[str]:
        """Return the names of the obstacles that another body is closer to than a distance.

        Args:
            body: other body, posed in the frame of the obstacles.
            distance: distance between both surfaces, in [m].
        """
        return frozenset(self._obstacles_near(body, distance))

    def _obstacles_near(self, body: Shape, distance: float) -> Iterator[str]:
        geometry, placed = coal_body(body), _placement(body.pose)
        for obstacle in self._surroundings:
            request, result = pin.coal.CollisionRequest(), pin.coal.CollisionResult()
            request.security_margin = distance
            pin.coal.collide(
                geometry, placed, coal_body(obstacle), _placement(obstacle.pose), request, result
            )
            if result.isCollision():
                yield obstacle.name

    def line_free(self, q_from: FloatArray, q_to: FloatArray, step: float = 0.01) -> bool:
        """Return True if nothing collides on the straight joint line between two postures, ends included.

        Args:
            q_from: (n,) joint angles, in [rad] or [m].
            q_to: (n,) joint angles, in [rad] or [m].
            step: largest joint motion between two checks, in [rad] or [m]. With a reach of 0.9 m, 0.01 rad
                moves the fingertips by at most 9 mm; a collision margin of half that distance covers the gaps
                between checks.
        """
        if self._end_collides(q_to) or self._end_collides(q_from):
            return False
        way = q_to - q_from
        count = max(1, math.ceil(max(map(abs, way.tolist())) / step))
        shares = _coarse_first(count)
        return not any(map(self.in_collision, shares * (way / count) + q_from))

    def path_free(self, path: FloatArray, step: float = 0.01) -> bool:
        """Return True if all straight joint lines along a path are free of collisions, the path's points
        included.

        Args:
            path: (m, n) joint angles, in [rad] or [m].
            step: largest joint motion between two checks, in [rad] or [m].
        """
        if len(path) == 1:
            return not self.in_collision(path[0])
        return all(self.line_free(a, b, step) for a, b in pairwise(path))

    def _end_collides(self, q: FloatArray) -> bool:
        """Return whether bodies collide at the end of a line, `q` (n,): each one ends several lines."""
        key = q.tobytes()
        known = self._known_ends.get(key)
        if known is None:
            known = self._known_ends[key] = self.in_collision(q)
        return known

    def _add(self, body: Shape, name: str, joint: int, joint_T_frame: pin.SE3) -> None:
        unique = f"{name}#{len(self._names)}"
        placement = joint_T_frame * pin.SE3(body.pose)
        self._bodies.addGeometryObject(pin.GeometryObject(unique, joint, placement, coal_body(body)))
        self._names.append(name)

    def _pair(self) -> None:
        """Choose the pairs of bodies that are checked."""
        joints = np.array([body.parentJoint for body in self._bodies.geometryObjects], dtype=np.intp)
        if not len(joints):  # an arm without bodies, and nothing around it
            return
        parents = np.array(self._model.parents)[joints]
        links, count = len(self._links), len(joints)
        apart = joints[:, None] != joints
        paired = apart & (parents[:, None] != joints) & (parents != joints[:, None])
        paired[:, links:] = apart[:, links:]
        paired[links:] = False
        if self._held is not None:
            paired[self._held, self._obstacles.start :] = True
        numbers = {name: number for number, name in enumerate(dict.fromkeys(self._names))}
        may_touch = np.zeros((len(numbers), len(numbers)), dtype=bool)
        for pair in self._allowed:
            rows = [numbers[name] for name in pair if name in numbers]
            if len(rows) == len(pair):
                may_touch[rows[0], rows[-1]] = may_touch[rows[-1], rows[0]] = True
        names = np.array([numbers[name] for name in self._names])
        paired &= ~may_touch[names[:, None], names] & np.triu(np.ones((count, count), dtype=bool), 1)
        self._bodies.setCollisionPairs(paired)


def _placement(pose: Transform) -> object:
    return pin.coal.Transform3s(pose[:3, :3], pose[:3, 3])


@lru_cache(maxsize=1024)
def _coarse_first(count: int) -> FloatArray:
    """Return 1 to count-1, (count-1, 1), so that far-apart ones are first: a collision is found sooner."""
    strides = [np.arange(offset, count - 1, 8) for offset in (3, 7, 1, 5, 0, 2, 4, 6)]
    return np.asarray(np.concatenate(strides)[:, None] + 1.0, dtype=np.float64)
