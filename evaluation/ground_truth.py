"""The true state of a simulated robot and its world, as far as outcomes are held against it."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handcart.backends.backend import Backend
from handcart.backends.robot_file import RobotFile
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, difference, inverse

from .sensor_sigmas import (
    BASE_SIGMA_DEG,
    BASE_SIGMA_MM,
    JOINT_SIGMA_DEG,
    OBJECT_SIGMA_MM,
    SIGMAS,
    SLIDE_SIGMA_MM,
)

GRIPPER_SIGMA_MM = 0.05  # of the measured opening
STILL = {
    "base mm": 0.5,
    "base deg": 0.05,
    "joints deg": 0.05,
    "slides mm": 0.2,
    "gripper mm": 0.2,
    "body mm": 1.0,
}
"""Within which what stands may be seen to move, in two seconds."""


@dataclass(frozen=True)
class Body:
    """Something that can be moved."""

    support: str
    """What carries it: "hand", "tray" or the name of a shelf; "floor" if it fell."""
    pose: Transform
    """(4, 4) in the frame of what carries it: hand, base, else the world."""


@dataclass(frozen=True)
class GroundTruth:
    """Robot and world at one instant."""

    base: Pose2
    """world_T_base."""
    joints: NDArray[np.float64]
    """(n,) in [rad], or [m] of those that slide."""
    slides: NDArray[np.bool_]
    """(n,) which joints do."""
    width: float
    """Between the finger pads, in [m]."""
    bodies: Mapping[str, Body]
    bumps: int
    """How often the base has run into something so far."""


def scene_of(backend: Backend) -> Any:
    """The scene behind a backend, through all that is put around it; None where nothing is simulated."""
    inner = getattr(backend, "inner", None)
    return getattr(backend, "scene", None) if inner is None else scene_of(inner)


def ground_truth(backend: Backend) -> GroundTruth | None:
    """Read it; None where nothing is simulated."""
    return true_state(scene_of(backend))


def true_state(scene: Any) -> GroundTruth | None:
    """Of a simulated world; None of none."""
    if scene is None:
        return None
    bodies = {each.name: _body(scene, each) for each in (*scene.books.values(), *scene.blocks.values())}
    slides = np.array(scene.robot.joint_units.slides[: scene.joints.size], dtype=np.bool_)
    bumps = sum(contact.body == "base" for contact in scene.contacts)
    return GroundTruth(scene.base, scene.joints.copy(), slides, float(scene.width), bodies, bumps)


def _body(scene: Any, thing: Any) -> Body:
    if scene.held is thing:
        return Body("hand", inverse(scene.world_T("hand")) @ thing.pose)
    if thing.rest.value == "tray":
        return Body("tray", inverse(scene.world_T_base) @ thing.pose)
    return Body(getattr(thing, "shelf", None) or thing.rest.value, thing.pose.copy())


def moved(before: GroundTruth, after: GroundTruth) -> dict[str, float]:
    """How far everything moved: name with unit to size; infinitely far what another thing carries now."""
    joints = np.abs(before.joints - after.joints)
    result = {
        "base mm": 1e3 * before.base.distance(after.base),
        "base deg": math.degrees(before.base.turn(after.base)),
        "joints deg": math.degrees(float(joints[~before.slides].max(initial=0.0))),
        "slides mm": 1e3 * float(joints[before.slides].max(initial=0.0)),
        "gripper mm": 1e3 * abs(before.width - after.width),
    }
    for name, body in before.bodies.items():
        now = after.bodies.get(name)
        lost = now is None or now.support != body.support
        result[f"{name} mm"] = math.inf if lost or now is None else 1e3 * difference(body.pose, now.pose)[0]
    return result


def not_restored(before: GroundTruth, after: GroundTruth, spec: RobotFile) -> list[str]:
    """What is not where it was: beyond the tolerance of the robot's file and 5 sigma of what measures it."""
    tolerance = spec.tolerance
    allowed = {
        "base mm": tolerance.base_mm + SIGMAS * BASE_SIGMA_MM,
        "base deg": tolerance.base_deg + SIGMAS * BASE_SIGMA_DEG,
        "joints deg": tolerance.joints_deg + SIGMAS * JOINT_SIGMA_DEG,
        "slides mm": tolerance.slides_mm + SIGMAS * SLIDE_SIGMA_MM,
        "gripper mm": tolerance.gripper_mm + SIGMAS * GRIPPER_SIGMA_MM,
    }
    body = tolerance.object_mm + SIGMAS * OBJECT_SIGMA_MM
    return _beyond(moved(before, after), allowed, body)


def not_still(before: GroundTruth, after: GroundTruth) -> list[str]:
    """What moved although all should stand."""
    return _beyond(moved(before, after), STILL, STILL["body mm"])


def disturbed(before: GroundTruth, after: GroundTruth, most_mm: float, without: Collection[str]) -> list[str]:
    """Bodies but those named in `without` that were moved further than `most_mm`."""
    others = {f"{name} mm" for name in before.bodies if name not in without}
    found = moved(before, after)
    return [f"{name} {found[name]:.1f}" for name in sorted(others) if not found[name] <= most_mm]


def _beyond(found: Mapping[str, float], allowed: Mapping[str, float], body: float) -> list[str]:
    limits = {name: allowed.get(name, body) for name in found}
    return [
        f"{name} {size:.2f} (at most {limits[name]:.2f})"
        for name, size in found.items()
        if not size <= limits[name]
    ]
