"""Growing description from which MuJoCo compiles a model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.backends.physics.engine.engine import GRAVITY_M_S2
from handcart.backends.physics.engine.thing_form import Cuboid, Piece, Rod, ThingForm, Wedge
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import FloatArray

from .mujoco_module import mujoco

CONTACT_COMPLIANCE = (0.005, 1.0)
"""Compliance of contacts: time constant in [s], of two steps, and damping ratio; resting things sink in 0.01
mm.
"""
PAD_IMPEDANCE = (0.95, 0.99, 0.0005, 0.5, 2.0)
"""Impedance of pads: with MuJoCo's default, 60 N press a thing of 40 g 0.6 mm into each pad, with this 0.25
mm.

A thing held by a turning hand drifts, because MuJoCo's steps follow the tangent of its path. The points of
`Grip` bring it back, against friction that gives a little. With the hardest impedance (0.999), or with
MuJoCo's own remedies for slipping (`impratio` 10, `noslip_iterations` 5), friction would oppose this
return.
"""
TYRE_IMPEDANCE = (0.995, 0.999, 0.0005, 0.5, 2.0)
"""Impedance of sticking tyres: with MuJoCo's default, a car on rough ground turns by 0.6 degrees in a
minute.
"""
LINKAGE_IMPEDANCE = (0.999, 0.9999, 0.0005, 0.5, 2.0)
"""Impedance of a linkage between two joints: a load on the following joint moves it by less than 1e-5 [rad]
or [m].
"""
SOFT_GROUND_IMPEDANCE = (0.9, 0.9, 0.001, 0.5, 2.0)
"""Impedance of wheels on soft ground: equal at each depth, so that a point's force is proportional to it.

MuJoCo's force at rest is its stiffness times the depth, divided by (1 - impedance) and by the body's
inverse mass at the contact. In motion it acts as if 9 times that mass moved along, so the ground gives
slowly.
"""
HOLDS_ON_SOFT = 100.0
"""Ratio of frictional to normal impedance on soft ground (`impratio`); with 1, a car creeps."""
AXLE_FRICTION_RATIO = 2.0
"""Factor on the requested friction along an axle. The ATRV then turns on the spot by 0.99 to 1.02
of the turn that its file predicts, without the factor by 1.06 to 1.10."""
ROBOT_PREFIX = "robot/"
"""Prefix of the names of the robot's links and joints."""
ROBOT_GROUP = 1
"""Group of the robot's geometries: no beam of its range sensor meets it."""
GROUND_DEPTH_M = 1.0  # [m] of solid ground below the lowest point of a tile


class WorldSpec:
    """Builder of a world's `MjSpec`, MuJoCo's editable model.

    Each body is named by the number that this project's engine gives it.
    """

    def __init__(self, step: float) -> None:
        """Create a world whose solver has steps of that length, in [s]."""
        mj = mujoco()
        self.spec: Any = mj.MjSpec()
        option = self.spec.option
        option.timestep, option.gravity = step, (0.0, 0.0, -GRAVITY_M_S2)
        option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
        option.cone = mj.mjtCone.mjCONE_ELLIPTIC
        option.enableflags |= mj.mjtEnableBit.mjENBL_SLEEP
        self._floor = ""
        self._hung: dict[str, tuple[str, Transform]] = {}
        """Names and first poses of bodies on joints, by their labels."""

    def floor(self, number: int, friction: float) -> None:
        """Add a level floor at height 0, named by `number`; `friction` is a coefficient, without unit."""
        kind = mujoco().mjtGeom.mjGEOM_PLANE
        self._floor = f"{number}"
        self.solid(self.spec.worldbody, self._floor, friction, type=kind, size=(0.0, 0.0, 1.0))

    def box(self, number: int, box: Box, friction: float, moves: bool) -> None:
        """Add a box that forces do not move.

        Args:
            number: number of the box, which is its name.
            box: pose in the world and size, in [m].
            friction: coefficient of friction, without unit.
            moves: True for a box that `Engine.set_pose` moves; only such a box is a body of its own in
                MuJoCo.
        """
        kind, half = mujoco().mjtGeom.mjGEOM_BOX, [size / 2 for size in box.size]
        body, placed = self.spec.worldbody, where(box.pose)
        if moves:
            body, placed = self.spec.worldbody.add_body(name=f"{number}", mocap=True, **placed), {}
        self.solid(body, f"{number}", friction, type=kind, size=half, **placed)

    def tile(
        self, number: int, corner: FloatArray, cell: float, heights: FloatArray, friction: float
    ) -> None:
        """Add a square of rough ground as a height field.

        Args:
            number: number of the tile, which is part of its name.
            corner: (2,) least x and y in the world, in [m].
            cell: distance of neighbouring heights, in [m].
            heights: (k, k) in [m], a row for each y.
            friction: coefficient of friction, without unit.
        """
        low, span = float(heights.min()), max(float(np.ptp(heights)), 1e-6)
        half = cell * (len(heights) - 1) / 2
        field = self.spec.add_hfield(
            name=f"field {number}",
            size=(half, half, span, GROUND_DEPTH_M),
            nrow=len(heights),
            ncol=len(heights),
            userdata=((heights - low) / span).ravel(),
        )
        kind, (x, y) = mujoco().mjtGeom.mjGEOM_HFIELD, corner + half
        self.solid(
            self.spec.worldbody, f"{number}", friction, type=kind, hfieldname=field.name, pos=(x, y, low)
        )

    def thing(self, number: int, form: ThingForm) -> None:
        """Add a rigid body that moves freely, or on a joint of the world.

        The body's frame is at its centre of mass.

        Args:
            number: number of the body in this project's engine, from which its name in MuJoCo is made.
            form: initial pose, mass, shapes, friction and joint of the body.
        """
        body = self._hang(number, form) if form.hung is not None else self._set_free(number, form)
        body.explicitinertial, body.ipos = True, (0.0, 0.0, 0.0)
        inertia = rod_inertia if form.is_round else box_inertia
        body.mass, body.inertia = form.mass, inertia(form.mass, form.size)
        if form.hung is None or form.hung.joint is not None:
            sleeps = mujoco().mjtSleepPolicy
            body.sleep = sleeps.mjSLEEP_INIT if form.asleep else sleeps.mjSLEEP_ALLOWED
        for index, piece in enumerate(form.pieces):
            name = f"{number}" if index == 0 else f"{number}.{index}"
            self.solid(body, name, form.friction, **self._piece(name, piece))

    def _set_free(self, number: int, form: ThingForm) -> Any:
        body = self.spec.worldbody.add_body(name=f"{number}", **where(form.middle))
        body.add_freejoint(name=f"{number}")
        return body

    def _hang(self, number: int, form: ThingForm) -> Any:
        """Return a body on its joint, or fixed to the earlier body of its label."""
        assert form.hung is not None
        label, joint = form.hung
        if joint is None:
            name, middle = self._hung[label]
            return self.spec.body(name).add_body(name=f"{number}", **where(inverse(middle) @ form.middle))
        body = self.spec.worldbody.add_body(name=f"{number}", **where(form.middle))
        self._hung[label] = f"{number}", form.middle
        kinds, to_body = mujoco().mjtJoint, inverse(form.middle)
        body.add_joint(
            name=f"{number}",
            type=kinds.mjJNT_SLIDE if joint.slides else kinds.mjJNT_HINGE,
            pos=(to_body @ (*joint.point, 1.0))[:3],
            axis=to_body[:3, :3] @ joint.axis,
            limited=True,
            range=joint.limits if joint.slides else np.degrees(joint.limits),
            frictionloss=joint.friction,
            damping=joint.damping,
        )
        return body

    def solid(self, body: Any, name: str, friction: float, **shape: Any) -> None:
        """Add a geometry with a coefficient of friction to a body.

        MuJoCo uses the larger coefficient of two touching geometries, not the product of both. Each geometry
        therefore gets the square of its coefficient, so that two equal coefficients act as their product.

        Args:
            body: body of MuJoCo's `MjSpec`.
            name: name of the geometry.
            friction: coefficient of friction, without unit.
            shape: further attributes of MuJoCo's geometry, such as type, size and pose.
        """
        body.add_geom(
            name=name,
            friction=(friction**2, 0.005, 0.0001),
            solref=CONTACT_COMPLIANCE,
            condim=3,
            mass=0.0,
            **shape,
        )

    def bulge(self, wheel: Any) -> None:
        """Replace a cylindrical wheel by an ellipsoid, which touches the ground at one point.

        A cylinder touches the ground along both its edges. When the base turns, the edges move at different
        speeds, and the contact would jump from one edge to the other.
        """
        kinds = mujoco().mjtGeom
        if wheel.type == kinds.mjGEOM_CYLINDER:
            radius, half_width, _ = wheel.size
            wheel.type, wheel.size = kinds.mjGEOM_ELLIPSOID, (radius, radius, half_width)

    def scrub(self, wheel: Any, along_axle: float) -> None:
        """Give a wheel less friction with the floor along its axle than across it.

        The wheel becomes a capsule, because MuJoCo aligns the first tangent of a capsule's contacts with its
        axis, and a pair of geometries can have a coefficient for each tangent. The capsule is as thick as the
        wheel, and touches the floor at two points as far apart as the wheel is wide.

        Args:
            wheel: geometry of the wheel.
            along_axle: friction along the axle as a share (0 to 1) of the friction across the axle.
        """
        radius, _, half_width = wheel.size  # of one that bulges
        wheel.type, wheel.size = mujoco().mjtGeom.mjGEOM_CAPSULE, (radius, half_width, 0.0)
        wheel.name = f"{wheel.parent.name} rim"
        friction = float(wheel.friction[0])
        pair = self.spec.add_pair(geomname1=self._floor, geomname2=wheel.name, condim=3)
        pair.friction, pair.solref = (
            (AXLE_FRICTION_RATIO * along_axle * friction, friction, 0.005, 0.0001, 0.0001),
            CONTACT_COMPLIANCE,
        )

    def _piece(self, name: str, piece: Piece) -> dict[str, Any]:
        kinds = mujoco().mjtGeom
        if isinstance(piece, Cuboid):
            half = [size / 2 for size in piece.size]
            return {"type": kinds.mjGEOM_BOX, "size": half, "pos": (piece.ahead, 0.0, 0.0)}
        if isinstance(piece, Rod):
            return {"type": kinds.mjGEOM_CYLINDER, "size": (piece.radius, piece.length / 2, 0.0)}
        mesh = self.spec.add_mesh(name=f"wedge {name}", uservert=_corners(piece).ravel())
        return {"type": kinds.mjGEOM_MESH, "meshname": mesh.name}


def where(pose: Transform) -> dict[str, Any]:
    """Return a pose (4, 4) in any frame as MuJoCo's `pos` (3,) in [m], and `quat` (4,) w, x, y, z."""
    return {"pos": pose[:3, 3], "quat": quaternion(pose)}


def quaternion(pose: Transform) -> FloatArray:
    """Return the orientation of a pose (4, 4) in any frame as a unit quaternion (4,): w, x, y, z."""
    return np.asarray(Rotation.from_matrix(pose[:3, :3]).as_quat()[[3, 0, 1, 2]])


def box_inertia(mass: float, size: Sequence[float]) -> tuple[float, float, float]:
    """Return the moments of inertia of a box about the axes x, y, z through its middle, in [kg m²].

    Args:
        mass: mass of the box, in [kg].
        size: (3,) lengths along x, y and z, in [m].
    """
    x, y, z = (length**2 for length in size)
    return mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y)


def rod_inertia(mass: float, size: Sequence[float]) -> tuple[float, float, float]:
    """Return the moments of inertia of a cylinder along z about the axes x, y, z through its middle, in [kg
    m²].

    Args:
        mass: mass of the cylinder, in [kg].
        size: (3,) diameter, diameter and length, in [m].
    """
    across = mass / 12 * (0.75 * size[0] ** 2 + size[2] ** 2)
    return across, across, mass / 8 * size[0] ** 2


def _corners(wedge: Wedge) -> FloatArray:
    """Return the corners (8, 3) of a wedge around the thing's middle, in [m]: four at the bottom, then four
    at the top.
    """
    y, z, narrow = wedge.thickness / 2, wedge.height / 2, wedge.thickness / 2 - wedge.chamfer
    outline = ((wedge.base, -y), (wedge.base, y), (wedge.end, narrow), (wedge.end, -narrow))
    return np.array([(x, across, up) for up in (-z, z) for x, across in outline])
