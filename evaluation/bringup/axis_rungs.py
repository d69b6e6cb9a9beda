"""The rungs that move one axis at a time."""

from __future__ import annotations

import math
from typing import NamedTuple

from backends.can.can_backend import CanBackend

from .jog import HAND_SPEED, Jogged, Jogger
from .rung import Facts, Rung, RungFailed
from .site import Site

SCALE = 0.05
"""Share by which tape and encoder may differ."""
_SHARE = 0.03  # of a joint's range that it is moved by
_NEAR = math.radians(0.5)


class Move(NamedTuple):
    """What an axis is tried with."""

    way: float
    """[m] or [rad]"""
    forward: str
    """What is to be seen."""
    unit: str
    shown: float
    """By which a way is multiplied to be told in that unit."""


def move_of(site: Site, axis: str) -> Move:
    """A small one, away from the nearer limit."""
    if axis.endswith("wheel"):
        return Move(0.1, "the wheel rolls the robot forward on this side", "mm", 1e3)
    if axis == "gripper":
        assert site.robot.gripper is not None
        return Move(-0.3 * site.robot.gripper.opening_mm / 1e3, "the fingers close", "mm", 1e3)
    return Move(
        math.radians(5.0), "the joint turns the way that the URDF's axis says", "deg", math.degrees(1.0)
    )


class AxesRung(Rung):
    """Each axis turns the way, and as far, as the robot's file says."""

    name = "axes"
    told = "one axis at a time, held by a key, hand at most 250 mm/s: direction and scale"

    def climb(self, site: Site) -> Facts:
        """See `Rung`."""
        facts: Facts = {"hand_speed_m_s": HAND_SPEED}
        with site.backend() as backend:
            jogger = Jogger(backend, site.robot)
            for axis in jogger.axes:
                facts[axis] = self._try(site, backend, jogger, axis)
        if not site.confirm("signed_off", "All axes are right: may the robot run faster than 250 mm/s?"):
            raise RungFailed("not signed off")
        return facts

    def _try(self, site: Site, backend: CanBackend, jogger: Jogger, axis: str) -> Facts:
        move, key = move_of(site, axis), axis.replace(" ", "_")
        if axis.startswith("joint"):
            move = move._replace(way=_inward(jogger, axis, move.way))
        before = _truth(backend, axis)
        done = _held(site, jogger, axis, move.way)
        true = abs(_truth(backend, axis) - before) * move.shown
        if not site.confirm(f"{key}_direction", f"{axis}: was it so that {move.forward}{_sign(move, axis)}?"):
            raise RungFailed(f"{axis} turns the wrong way: change `sign` in the robot's file")
        measured = site.number(
            f"{key}_scale", f"{axis}: by how much did it move, measured [{move.unit}]?", true
        )
        told = abs(done.way) * move.shown
        if abs(measured - told) > SCALE * told + 1.0:
            factor = told / measured if measured else math.inf
            hint = f"gear_ratio or counts_per_rev is {factor:.3g} times too small" if measured else "it stood"
            raise RungFailed(f"{axis} moved {measured:.4g} {move.unit}, by its encoder {told:.4g}: {hint}")
        _held(site, jogger, axis, -done.way)
        return {
            f"way_{move.unit}": round(told, 2),
            f"measured_{move.unit}": round(measured, 2),
            "top_speed": round(done.top_speed, 4),
        }


def _sign(move: Move, axis: str) -> str:
    return "" if move.way > 0 or axis == "gripper" else ", but the other way round"


def _inward(jogger: Jogger, axis: str, way: float) -> float:
    """A joint's way, away from the nearer limit."""
    lower, upper = jogger.limits(axis)
    at = jogger.position(axis)
    return way if upper - at > at - lower else -way


def _held(site: Site, jogger: Jogger, axis: str, way: float) -> Jogged:
    """Move by that while the key is held; raises `RungFailed` where it was let go."""
    with site.operator.hold(f"{axis}: hold the space bar; letting go stops it") as held:
        done = jogger.jog(axis, way, held)
    if done.ended != "there":
        raise RungFailed(f"{axis}: {done.ended} before it was there")
    return done


def _truth(backend: CanBackend, axis: str) -> float:
    """Where the bench's motor truly is, in [m] or [rad]; 0 for a real robot."""
    if backend.bench is None:
        return 0.0
    own = backend.axes[axis]
    return float(backend.bench.drives[own.spec.node].position / own.units.scale)


class LimitsRung(Rung):
    """Joints stop at the limits of the robot's file."""

    name = "limits"
    told = "each joint is jogged to both of its limits, and stops there"

    def left_out(self, site: Site) -> str:
        """See `Rung`."""
        return "" if site.spec.joints else "the robot has no joints"

    def climb(self, site: Site) -> Facts:
        """See `Rung`."""
        facts: Facts = {}
        with site.backend() as backend:
            jogger = Jogger(backend, site.robot)
            for axis in jogger.axes:
                if axis.startswith("joint"):
                    facts[axis] = self._try(site, jogger, axis)
        return facts

    def _try(self, site: Site, jogger: Jogger, axis: str) -> Facts:
        begun, facts = jogger.position(axis), {}
        key = axis.replace(" ", "_")
        if not site.confirm(f"{key}_free", f"{axis}: can it go to both limits without touching anything?"):
            raise RungFailed(f"{axis} has no room to its limits: bring the arm elsewhere with `handcart jog`")
        for end, limit in zip(("lower", "upper"), jogger.limits(axis), strict=True):
            with site.operator.hold(f"{axis}: hold the space bar, to its {end} limit") as held:
                done = jogger.jog(axis, (limit - jogger.position(axis)) + math.copysign(0.1, limit), held)
            at = jogger.position(axis)
            facts[f"{end}_deg"] = round(math.degrees(at), 2)
            if done.ended != "limit" or abs(at - limit) > _NEAR:
                raise RungFailed(
                    f"{axis} stands at {math.degrees(at):.1f} deg ({done.ended}); its limit is "
                    f"{math.degrees(limit):.1f} deg"
                )
        with site.operator.hold(f"{axis}: hold the space bar, back to where it was") as held:
            jogger.jog(axis, begun - jogger.position(axis), held)
        return facts
