"""Steps that move one axis at a time."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from typing_extensions import override

from handcart.backends.can.can_backend import CanBackend
from handcart.backends.description.mount_findings import FINGER_LINKS
from handcart.backends.description.robot_file import RobotFile
from handcart.evaluation.robot_report.masses import corners_of
from handcart.evaluation.robot_report.postures import LINK_MARGIN_M
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

from .jog import HAND_SPEED, Jogged, Jogger, slides
from .rung import Facts, Rung, RungFailed
from .site import Site

MAX_SCALE_DIFFERENCE = 0.05
"""Share by which tape and encoder may differ."""
_SHARE = 0.3  # of their range by which the fingers are moved
_TURN = math.radians(5.0)
_SLIDE = 0.02  # [m]
_STEP = math.radians(1.0)
_SLIDE_STEP = 0.005  # [m]
_DEEPER = 1e-4  # [m]
_NEAR = math.radians(0.5)
_SLIDE_NEAR = 0.002  # [m]
_BEYOND = 0.2  # [rad] or [m] past its limit that a joint is asked to go


class Move(NamedTuple):
    """Short test motion of an axis, and the visible effect that the operator confirms."""

    way: float
    """Travel of the axis, in [m] or [rad]; negative towards its lower limit."""
    seen: str
    """Visible motion that the operator should confirm."""
    unit: str
    shown: float
    """Factor from [m] or [rad] to the displayed unit."""


def move_of(jogger: Jogger, axis: str) -> Move:
    """Return a small test motion of an axis: a wheel moves forward, any other axis moves away from its nearer
    limit.
    """
    if axis.endswith("wheel"):
        return Move(0.1, "the wheel rolled the robot forward on its side", "mm", 1e3)
    lower, upper = jogger.limits(axis)
    at = jogger.position(axis)
    up = upper - at > at - lower
    if axis == "gripper":
        way = _SHARE * (upper - lower)
        return Move(way if up else -way, "the fingers opened" if up else "the fingers closed", "mm", 1e3)
    if slides(jogger.robot, axis):
        slid = "along the URDF's axis" if up else "against the URDF's axis"
        return Move(_SLIDE if up else -_SLIDE, f"the joint slid {slid}", "mm", 1e3)
    turned = "the way that the URDF's axis says" if up else "against the way that the URDF's axis says"
    way = _TURN if up else -_TURN
    return Move(way, f"the joint turned {turned}", "deg", math.degrees(1.0))


class AxesRung(Rung[Site]):
    """Bring-up step that checks direction and scale of each axis against the robot's file."""

    name = "axes"
    summary = "one axis at a time, held by a key, hand at most 250 mm/s: direction and scale"

    @override
    def climb(self, site: Site) -> Facts:
        facts: Facts = {"hand_speed_m_s": HAND_SPEED}
        with site.backend() as backend:
            jogger = Jogger(backend, site.robot)
            for axis in jogger.axes:
                facts[axis] = self._try(site, backend, jogger, axis)
        if not site.confirm("signed_off", "All axes are right: may the robot run faster than 250 mm/s?"):
            raise RungFailed("not signed off")
        return facts

    def _try(self, site: Site, backend: CanBackend, jogger: Jogger, axis: str) -> Facts:
        move, key = move_of(jogger, axis), axis.replace(" ", "_")
        before = _truth(backend, axis)
        done = _held(site, jogger, axis, move.way)
        true = abs(_truth(backend, axis) - before) * move.shown
        if not site.confirm(f"{key}_direction", f"{axis}: is it so that {move.seen}?"):
            raise RungFailed(f"{axis} turns the wrong way: change `sign` in the robot's file")
        measured = site.number(
            f"{key}_scale", f"{axis}: by how much did it move, measured [{move.unit}]?", true
        )
        by_encoder = abs(done.way) * move.shown
        if abs(measured - by_encoder) > MAX_SCALE_DIFFERENCE * by_encoder + 1.0:
            factor = by_encoder / measured if measured else math.inf
            hint = f"gear_ratio or counts_per_rev is {factor:.3g} times too small" if measured else "it stood"
            raise RungFailed(
                f"{axis} moved {measured:.4g} {move.unit}, by its encoder {by_encoder:.4g}: {hint}"
            )
        _held(site, jogger, axis, -done.way, back=True)
        return {
            f"way_{move.unit}": round(by_encoder, 2),
            f"measured_{move.unit}": round(measured, 2),
            "top_speed": round(done.top_speed, 4),
        }


def _held(site: Site, jogger: Jogger, axis: str, way: float, back: bool = False) -> Jogged:
    """Jog an axis by `way`, in [m] or [rad], while a key is held; raises `RungFailed` if it stops short of
    it.
    """
    with site.operator.hold(f"{axis}: hold the space bar; letting go stops it") as held:
        done = jogger.jog(axis, way, held)
    if done.ended != "there" and not (back and done.ended == "limit"):
        raise RungFailed(f"{axis}: {done.ended} before it was there")
    return done


def _truth(backend: CanBackend, axis: str) -> float:
    """Return the true position of the bench's motor, in [m] or [rad]; 0 for a real robot."""
    if backend.bench is None:
        return 0.0
    own = backend.axes[axis]
    return float(backend.bench.drives[own.spec.node].position / own.units.scale)


class LimitsRung(Rung[Site]):
    """Bring-up step that checks that joints stop at the limits given in the robot's file."""

    name = "limits"
    summary = "each joint is jogged to those of its limits that it reaches freely, and stops there"

    @override
    def left_out(self, site: Site) -> str:
        return "" if site.spec.joints else "the robot has no joints"

    @override
    def climb(self, site: Site) -> Facts:
        facts: Facts = {}
        with site.backend() as backend:
            jogger, free = Jogger(backend, site.robot), FreeWay(site.robot)
            for number, axis in enumerate(item for item in jogger.axes if item.startswith("joint")):
                if math.isinf(jogger.limits(axis)[0]):
                    facts[axis] = {"left_out": "it turns without end"}
                else:
                    facts[axis] = self._try(site, backend, jogger, free, number, axis)
        return facts

    def _try(
        self, site: Site, backend: CanBackend, jogger: Jogger, free: FreeWay, number: int, axis: str
    ) -> Facts:
        facts: Facts = {}
        begun = jogger.position(axis)
        units = site.robot.joint_units
        unit = units.unit(number)
        for end, limit, sense in zip(("lower", "upper"), jogger.limits(axis), (-1.0, 1.0), strict=True):
            posture = np.array([joint.position for joint in backend.axes.joints])
            touches = free.touches_at(posture, number, limit)
            if touches is not None:
                facts[f"{end}_touches_{unit}"] = round(units.user_value(number, touches), 1)
                continue
            question = f"{axis}: is the way to its {end} limit, {units.words(number, limit, 0)}, free?"
            if not site.confirm(f"{axis.replace(' ', '_')}_{end}", question):
                raise RungFailed(f"{axis}: not free; bring the arm elsewhere with `handcart jog`")
            stands = _to_limit(site, jogger, axis, Limit(limit, sense), partial(units.words, number))
            facts[f"{end}_{unit}"] = round(units.user_value(number, stands), 2)
            _held(site, jogger, axis, begun - jogger.position(axis), back=True)
        return facts


class Limit(NamedTuple):
    """Lower or upper limit of a joint's range, with its position and direction."""

    at: float
    """Position of the limit, in [rad] or [m]."""
    sense: float
    """-1.0 for the lower limit, 1.0 for the upper one, also if the joint is at the limit already."""


def _to_limit(site: Site, jogger: Jogger, axis: str, limit: Limit, words: Callable[[float], str]) -> float:
    """Jog a joint against its limit; return its position then, in [rad] or [m].

    Args:
        site: robot or bench.
        jogger: moves the axis.
        axis: name of the joint.
        limit: limit to reach.
        words: formats a position for people.
    """
    left = abs(limit.at - jogger.position(axis))
    with site.operator.hold(f"{axis}: hold the space bar, to its limit") as held:
        done = jogger.jog(axis, limit.sense * (left + _BEYOND), held)
    at = jogger.position(axis)
    near = _SLIDE_NEAR if slides(jogger.robot, axis) else _NEAR
    if done.ended != "limit" or abs(at - limit.at) > near:
        raise RungFailed(f"{axis} is at {words(at)} ({done.ended}); its limit is {words(limit.at)}")
    return at


class FreeWay:
    """Test, by the URDF, whether the arm would touch robot or floor in the motion of a single joint.

    The fingers are open.
    """

    def __init__(self, robot: RobotFile) -> None:
        half = 0.0 if robot.gripper is None else robot.gripper.opening_mm / 2e3
        fingers = dict.fromkeys(FINGER_LINKS, half) if robot.gripper else {}
        self._model = robot.arm_model().with_others(fingers)
        self._own = CollisionModel(self._model, margin=LINK_MARGIN_M)
        self._slides = robot.joint_units.slides

    def touches_at(self, posture: FloatArray, joint: int, limit: float) -> float | None:
        """Return the position at which the arm first touches itself or the floor when one joint moves to
        `limit`.

        It is in [rad] or [m]; None if the way is free.

        Args:
            posture: (n,) of all joints, in [rad] or [m].
            joint: number of the joint that moves, from 0.
            limit: position to move it to, in [rad] or [m].
        """
        floor = self._lowest(posture) - _DEEPER  # wheels and casters are on it
        step = _SLIDE_STEP if self._slides[joint] else _STEP
        steps = max(2, math.ceil(abs(limit - posture[joint]) / step))
        for angle in np.linspace(posture[joint], limit, steps):
            there = posture.copy()
            there[joint] = angle
            if self._own.in_collision(there) or self._lowest(there) < floor:
                return float(angle)
        return None

    def _lowest(self, posture: FloatArray) -> float:
        shapes = self._model.link_shapes(posture)
        return min(float(corners_of(shape)[:, 2].min()) for shape in shapes)
