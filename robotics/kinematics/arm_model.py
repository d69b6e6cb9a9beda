"""Forward, differential and inverse kinematics of any serial arm in a URDF."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.coal_bodies import hull_of_mesh, meshes, shape_of
from handcart.robotics.kinematics.following_joints import following
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.kinematics.shapes import Shape
from handcart.robotics.kinematics.tip_descent import TipScrews, descend, nearest_of_groups, tip_screws
from handcart.robotics.kinematics.urdf_mounts import joints_above
from handcart.robotics.kinematics.urdf_reading import known_urdf
from handcart.robotics.kinematics.urdf_tree import followers_of, urdf_of_arm
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IndexArray


class ArmModel:
    """The joints `joint_names` of a URDF robot, from its link `base` to its link `tip`.

    All other joints (wheels, fingers) are fixed at `others[name]`, in [rad] or [m], or at zero. Joints that
    mimic a joint of the arm follow it, wherever they are in the tree. A joint that slides has [m] where
    others have [rad]. Poses are given in `base`. A link's mesh is replaced by its convex hull; mesh files are
    named by absolute paths. An object reuses its memory: use it from one thread at a time.

    Attributes:
        lower, upper: joint limits (n,), in [rad]; for a continuous joint -pi and pi, not real limits.
        endless: (n,) True for continuous joints: they have no limits, see `within` and `nearest`.
        followers: names (k,) of joints that mimic one of the arm's.
        velocity: joint speed limits (n,), in [rad/s].
        slides: (n,) True for prismatic joints, whose numbers are in [m].
        moves_tip: (n,) True for joints that move the tip, unlike those of a head.
        allowed: pairs of links that may touch each other.

    Raises:
        ValueError: a joint or link is not in the URDF, a mesh can't be read, or the arm moves `base`
            itself.
    """

    def __init__(
        self,
        urdf_text: str,
        joint_names: Sequence[str],
        tip: str = "hand",
        base: str = "base",
        others: Mapping[str, float] | None = None,
        allowed: Collection[tuple[str, str]] = (),
    ) -> None:
        self._urdf = urdf_text
        self.allowed = frozenset(allowed)
        self.joint_names = tuple(joint_names)
        self.tip = tip
        self.base = base
        self._others = dict(others or {})
        self._alike: dict[tuple[tuple[str, float], ...], ArmModel] = {}
        reduced = urdf_of_arm(urdf_text, self.joint_names, self._others)
        self._model = pin.buildModelFromXML(reduced, True)
        self._geometry = pin.buildGeomFromUrdfString(
            self._model, reduced, pin.GeometryType.COLLISION, None, [], meshes()
        )
        for body in self._geometry.geometryObjects:
            if isinstance(body.geometry, pin.coal.BVHModelBase):
                body.geometry = hull_of_mesh(body.geometry, self._model.frames[body.parentFrame].name)
        self._order = np.array([self._index(name) for name in joint_names], dtype=np.intp)
        self._places = np.argsort(self._order)
        led = followers_of(urdf_text, self.joint_names)
        self.followers = tuple(led)
        self._spread, self._offset = following(led, joint_names, self._index, int(self._model.nq))
        self._led = np.array([self._index(name) for name in led], dtype=np.intp)
        types = {match.get("name"): match.get("type") for match in known_urdf(urdf_text).findall("joint")}
        self.endless = np.array([types[name] == "continuous" for name in joint_names], dtype=bool)
        self.lower: FloatArray = self._model.lowerPositionLimit[self._order]
        self.upper: FloatArray = self._model.upperPositionLimit[self._order]
        self.velocity: FloatArray = self._model.velocityLimit[self._order]
        kinds = [self._model.joints[self._model.getJointId(name)].shortname() for name in joint_names]
        self.slides = np.array([kind.startswith("JointModelP") for kind in kinds], dtype=bool)
        self._lowest = np.where(self.endless, -np.inf, self.lower)
        self._highest = np.where(self.endless, np.inf, self.upper)
        self._data = self._model.createData()
        self._last_poses: dict[tuple[bytes, int], Transform] = {}  # asked several times in a period
        self._frames: dict[str, int] = {}
        self._tip_id = self._frame(tip)
        self.moves_tip = self.moving(tip)
        self._root_T_base = self._fixed_placement(self._frame(base))
        self._base_T_root = self._root_T_base.inverse()

    def with_others(self, others: Mapping[str, float]) -> ArmModel:
        """Return this arm's model with joints outside the arm at given positions, for example with open
        fingers.

        Repeated calls return the same object.
        """
        key = tuple(sorted(others.items()))
        if key not in self._alike:
            if len(self._alike) >= _ALIKE:
                self._alike.clear()
            everyone = {**self._others, **others}
            self._alike[key] = ArmModel(
                self._urdf, self.joint_names, self.tip, self.base, everyone, self.allowed
            )
        return self._alike[key]

    @property
    def dof(self) -> int:
        """Number n of the arm's joints."""
        return len(self.joint_names)

    def within(self, q: FloatArray, rounding: float = 0.0) -> bool:
        """Return whether joint angles are within the limits of all joints that have limits.

        Args:
            q: (n,) in [rad] or [m].
            rounding: distance beyond a limit that still counts as within it, in [rad] or [m].
        """
        return bool(np.all(q >= self._lowest - rounding) and np.all(q <= self._highest + rounding))

    def clipped(self, q: FloatArray) -> FloatArray:
        """Return the joint angles (n,) within the limits that are nearest to `q` (n,), in [rad] or [m]."""
        return np.clip(q, self._lowest, self._highest)

    def nearest(self, q: FloatArray, near: FloatArray) -> FloatArray:
        """Return the posture `q` (n,), with full turns added to continuous joints so that they are as near as
        possible to `near` (n,), all in [rad] or [m].
        """
        if not self.endless.any():
            return q
        turns = np.round((near - q) / (2.0 * np.pi))
        return np.where(self.endless, q + 2.0 * np.pi * turns, q)

    def forward(self, q: FloatArray, frame: str | None = None) -> Transform:
        """Return base_T_frame (4, 4) of a link (None: the tip) at the joint angles `q` (n,), in [rad] or
        [m].
        """
        index = self._tip_id if frame is None else self._frame(frame)
        key = q.tobytes(), index
        placement = self._last_poses.get(key)
        if placement is None:
            pin.forwardKinematics(self._model, self._data, self.ordered(q))
            placed = self._base_T_root * pin.updateFramePlacement(self._model, self._data, index)
            if len(self._last_poses) >= _POSES:
                del self._last_poses[next(iter(self._last_poses))]
            placement = self._last_poses[key] = placed.homogeneous
        return placement.copy()

    def jacobian(self, q: FloatArray) -> FloatArray:
        """Return the Jacobian (6, n) at joint angles `q` (n,), in [rad] or [m].

        Rows 0 to 2 are the tip's velocity in [m/s], rows 3 to 5 its turn rate in [rad/s], both in the axes of
        `base`, for 1 rad/s or 1 m/s of each joint.
        """
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        root_J = pin.computeFrameJacobian(self._model, self._data, self.ordered(q), self._tip_id, aligned)
        root_J = self.of_arm(root_J.reshape(6, -1))  # Pinocchio gives a single column as (6,)
        turn = self._base_T_root.rotation
        return np.vstack((turn @ root_J[:3], turn @ root_J[3:]))

    def gravity_torque(self, q: FloatArray) -> FloatArray:
        """Return the torques (n,), in [Nm] or [N], that carry the arm's weight at joints `q` (n,), in [rad]
        or [m], if the base is upright.
        """
        return self.of_arm(pin.computeGeneralizedGravity(self._model, self._data, self.ordered(q)))

    def own_gravity_torques(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return torques or forces that carry the arm's weight if mimicking joints have drives of their own.

        The first array (n,) is for the arm's joints alone, the second (k,) for the joints that mimic them
        (`followers`), both in [Nm] or [N], at joint angles `q` (n,) in [rad] or [m].
        """
        torques: FloatArray = pin.computeGeneralizedGravity(self._model, self._data, self.ordered(q))
        return torques[self._order], torques[self._led]

    def load_torque(self, q: FloatArray, point: FloatArray, mass: float) -> FloatArray:
        """Return the torques (n,), in [Nm] or [N], that carry a load held by the tip, if the base is upright.

        Args:
            q: (n,) joint angles in [rad] or [m].
            point: (3,) centre of mass in `base`, in [m].
            mass: mass of the load, in [kg].
        """
        jacobian = self.jacobian(q)
        arm = point - self.forward(q)[:3, 3]
        rises = jacobian[2] + jacobian[3] * arm[1] - jacobian[4] * arm[0]
        return np.asarray(mass * _GRAVITY * rises)

    def inverse(
        self, base_T_tip: Transform, near: FloatArray, restarts: int = 20, seed: int = 0
    ) -> FloatArray | None:
        """Return joint angles (n,) within the limits that put the tip at a pose; None if none was found.

        The angles are in [rad], or in [m] for sliding joints. If the iteration from `near` converges, its
        result is returned. Continuous joints are in the turn nearest to `near`.

        Args:
            base_T_tip: (4, 4) pose of the tip.
            near: (n,) start of the first iteration, in [rad] or [m].
            restarts: number of random starts tried otherwise, those closest to `near` first.
            seed: seed of the random starts.
        """
        return next(self.solutions(base_T_tip, near, restarts, seed), None)

    def solutions(
        self, base_T_tip: Transform, near: FloatArray, restarts: int = 20, seed: int = 0
    ) -> Iterator[FloatArray]:
        """Yield different joint angles (n,), in [rad] or [m], that bring the tip to one pose, as they are
        found.

        Args:
            base_T_tip: (4, 4) pose of the tip.
            near: (n,) start of the first iteration, in [rad] or [m].
            restarts: number of random starts that follow, those closest to `near` first.
            seed: seed of the random starts.
        """
        target, found = self._root_T_base.homogeneous @ base_T_tip, list[FloatArray]()
        for start in self._all_starts(target, near, restarts, seed):
            q = self._descend(target, start)
            q = None if q is None else self.nearest(q, near)
            if q is not None and all(float(np.abs(q - other).max()) > _SAME for other in found):
                found.append(q)
                yield q

    def _all_starts(
        self, root_T_target: FloatArray, near: FloatArray, restarts: int, seed: int
    ) -> Iterator[FloatArray]:
        yield self.clipped(near)
        if not restarts:
            return
        drawn = self._starts(root_T_target, near, restarts, np.random.default_rng(seed))
        starts = [self.nearest(start, near) for start in drawn]
        yield from sorted(starts, key=lambda start: float(np.linalg.norm(start - near)))

    def link_poses(self, q: FloatArray) -> FloatArray:
        """Return base_T_shape (g, 4, 4) of each body of `link_shapes`, in the same order.

        Args:
            q: (n,) joint angles in [rad] or [m].
        """
        pin.forwardKinematics(self._model, self._data, self.ordered(q))
        joints, rows, joint_T_bodies = self._mounts
        base_T_joints = np.array([(self._base_T_root * self._data.oMi[j]).homogeneous for j in joints])
        base_T_joints = base_T_joints.reshape(-1, 4, 4)  # of an arm without bodies too
        return np.asarray(base_T_joints[rows] @ joint_T_bodies)

    def moving(self, frame: str) -> BoolArray:
        """Return a mask (n,), True for joints that move a link, directly or by joints that mimic them."""
        joints = set(joints_above(self._urdf, frame))
        joints |= {
            led[0] for name, led in followers_of(self._urdf, self.joint_names).items() if name in joints
        }
        return np.array([name in joints for name in self.joint_names], dtype=np.bool_)

    @cached_property
    def _mounts(self) -> tuple[list[int], IndexArray, FloatArray]:
        """Joints that carry bodies, which of them carries each body, and joint_T_body (g, 4, 4)."""
        bodies = self._geometry.geometryObjects
        joints, rows = np.unique([body.parentJoint for body in bodies], return_inverse=True)
        placements = np.array([body.placement.homogeneous for body in bodies]).reshape(-1, 4, 4)
        return joints.astype(int).tolist(), rows, placements

    def link_shapes(self, q: FloatArray) -> list[Shape]:
        """Return all collision bodies of the robot, posed in `base`, each named after its link.

        Args:
            q: (n,) joint angles in [rad] or [m].
        """
        names = [self._model.frames[body.parentFrame].name for body in self._geometry.geometryObjects]
        bodies = zip(self._geometry.geometryObjects, names, self.link_poses(q), strict=True)
        return [shape_of(body.geometry, pose, name) for body, name, pose in bodies]

    def moved_shapes(self, q: FloatArray) -> list[Shape]:
        """Return the collision bodies that the arm moves, posed in `base` and named after their links.

        Args:
            q: (n,) joint angles in [rad] or [m].
        """
        bodies = zip(self._geometry.geometryObjects, self.link_shapes(q), strict=True)
        return [shape for body, shape in bodies if body.parentJoint > 0]

    def for_collision(self) -> tuple[pin.Model, pin.GeometryModel, pin.SE3]:
        """Return the data of a collision checker: Pinocchio's model, a copy of the bodies, and the pose of
        the link `base` in the root link of the URDF.
        """
        return self._model, self._geometry.copy(), self._root_T_base

    def tip_mount(self) -> tuple[int, pin.SE3]:
        """Return Pinocchio's index of the joint that carries the tip, and the pose joint_T_tip of the tip.

        A checker of collisions needs both to attach a held body.
        """
        frame = self._model.frames[self._tip_id]
        return frame.parentJoint, frame.placement

    def ordered(self, q: FloatArray) -> FloatArray:
        """Return positions (m,) of all movable joints in Pinocchio's order, given the arm's positions (n,).

        Both are in [rad] or [m].
        """
        if self._spread is not None:
            return np.asarray(self._spread @ q + self._offset)
        return q.take(self._places)

    def ordered_rates(self, rates: FloatArray) -> FloatArray:
        """Return the rates (m,) of all movable joints in Pinocchio's order, given the arm's rates (n,).

        Both are speeds in [rad/s] or [m/s], or accelerations in [rad/s²] or [m/s²].
        """
        return self.ordered(rates) if self._spread is None else self.ordered(rates) - self._offset

    def effort_limits(self) -> FloatArray:
        """Return the effort limits (n,) of the URDF, in [Nm] or [N]."""
        limits: FloatArray = self._model.effortLimit[self._order]
        return limits

    def of_arm(self, columns: FloatArray) -> FloatArray:
        """Select the values (..., n) of the arm's joints from values (..., m) of all joints of Pinocchio's
        model.

        Values are torques in [Nm] or [N], or columns of a Jacobian, in its units. A joint's torque includes
        those of its followers.
        """
        if self._spread is not None:
            return np.asarray(columns @ self._spread)
        return columns.T.take(self._order, axis=0).T  # faster than columns[..., order], in the same layout

    def _index(self, joint: str) -> int:
        return int(self._model.idx_qs[self._model.getJointId(joint)])

    def _frame(self, name: str) -> int:
        if name not in self._frames:
            if not self._model.existFrame(name, pin.FrameType.BODY):
                raise ValueError(f"the URDF has no link {name!r}")
            self._frames[name] = self._model.getFrameId(name, pin.FrameType.BODY)
        return self._frames[name]

    def _fixed_placement(self, index: int) -> pin.SE3:
        frame = self._model.frames[index]
        if frame.parentJoint != 0:
            raise ValueError(f"link {frame.name!r} can't be the base: the arm's joints move it")
        return frame.placement

    def _descend(self, root_T_target: FloatArray, start: FloatArray) -> FloatArray | None:
        q = np.array(start, dtype=np.float64)
        return q if descend(self._screws, root_T_target, q) else None

    def _starts(
        self, root_T_target: FloatArray, near: FloatArray, count: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return starts (count, n), each the nearest to the target of some random ones: cheaper than more
        descents.

        Joints that do not move the tip, such as those of a head, stay at `near` (n,).
        """
        drawn = rng.uniform(self.lower, self.upper, (count, _DRAWN, self.dof))
        drawn = np.where(self.moves_tip, drawn, near)
        best = np.zeros(count, dtype=np.int64)
        nearest_of_groups(self._screws, root_T_target, drawn, best)
        return drawn[np.arange(count), best]

    @cached_property
    def _screws(self) -> TipScrews:
        """Joints that move the tip, for compiled loops."""
        factors = self._spread
        if factors is None:
            factors = np.zeros((len(self._offset), self.dof))
            factors[self._order, np.arange(self.dof)] = 1.0
        limits = self._lowest, self._highest
        return tip_screws(self._model, self._tip_id, factors, self._offset, limits)


_GRAVITY = 9.81  # [m/s²]
_POSES = 4  # of frames at postures that are kept
_ALIKE = 32  # models with other joints elsewhere that are kept
_SAME = 1e-3  # [rad] or [m] between two solutions that count as one
_DRAWN = 8
