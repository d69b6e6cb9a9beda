"""Objects without tags in depth pictures: by their known sizes and by where they are believed to be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np

from handcart.backends.capabilities.depth_camera import DepthCamera, DepthImage
from handcart.backends.robot.robot import Robot
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.objects.depth_view import DepthView, over_surface
from handcart.robotics.perception.objects.known_solids import (
    HEIGHT_TOLERANCE_M,
    KnownSolid,
    SolidCandidate,
    candidates,
)
from handcart.robotics.perception.objects.standing_clusters import PointCluster, standing_clusters

from .tag_readings import ARM_SIGMA_M, ARM_SIGMA_RAD, Located

MIN_LOG_RATIO = math.log(100.0)  # by which one assignment of objects must be likelier than any other
MAX_OFF_SIGMAS = 5.0  # of the only object of a kind from where it is believed to be
CLEAR_M = 0.010  # around an object within which points are its own
MIN_OBSTACLE_POINTS = 30
INNER_SHARE = 0.7  # of an upper side, around its middle
SQUARE_M = 0.001  # maximum difference of two sides that count as equal


class ObjectBelief(NamedTuple):
    """Believed place and heading, in the base frame, of one of several objects of the same kind."""

    object: str
    place: tuple[float, float] | None
    """x and y in [m]; None for anywhere on the surface."""
    sigma: float
    """Standard deviation along each axis, in [m]."""
    heading: float
    """Believed heading, in [rad]."""


class Standing(NamedTuple):
    """Thing seen on a surface in depth pictures, with the kinds and poses that would explain it."""

    cluster: PointCluster
    may_be: tuple[SolidCandidate, ...]


def take_depth(robot: Robot) -> tuple[DepthImage, CameraModel] | None:
    """Return this period's depth picture and the model of its camera; None if the robot has no depth
    camera.
    """
    camera = robot.backend.get(DepthCamera)  # type: ignore[type-abstract]
    return None if camera is None else (camera.image(), camera.model)


def standing(
    views: Sequence[DepthView],
    base_T_surface: Transform,
    surface: ObjectSurface,
    kinds: Mapping[str, ObjectKind],
) -> list[Standing]:
    """Return the things on a surface that the depth pictures from one place of the base show together.

    Their points are merged, so a thing need not be in every picture.

    Args:
        views: pictures.
        base_T_surface: (4, 4) pose of the middle of the surface's top.
        surface: the surface.
        kinds: all known kinds, by their names.
    """
    known = [KnownSolid(name, kind.size, kind.is_round) for name, kind in kinds.items()]
    levelled = [over_surface(view, base_T_surface, surface.size_m) for view in views]
    found = standing_clusters([view for view in levelled if view is not None], surface.size_m)
    return [Standing(cluster, tuple(candidates(cluster, known))) for cluster in found]


def identify(
    name: str,
    kind_name: str,
    kind: ObjectKind,
    found: Sequence[Standing],
    beliefs: Sequence[ObjectBelief],
    base_T_surface: Transform,
    views: int,
) -> Located:
    """Return the pose of an object without tags, chosen among the things that were seen on its surface.

    Args:
        name: name of the object.
        kind_name: name of its kind.
        kind: its kind.
        found: all that stands on the surface.
        beliefs: believed poses of the object, and of all other objects of its kind on this surface.
        base_T_surface: (4, 4) of the middle of the surface's top.
        views: number of pictures that were taken.

    Raises:
        Discrepancy: no object of this kind is seen, it has fallen over, or it may be another object.
    """
    possible = [
        standing_
        for standing_ in found
        if any(c.name == kind_name and c.is_upright for c in standing_.may_be)
    ]
    for standing_ in possible:
        others = sorted({_in_words(other) for other in standing_.may_be if not _is(other, kind_name)})
        if others:
            raise Discrepancy(
                f"{name} is ambiguous: what stands there may be a {kind_name} or {', '.join(others)}",
                measured=Measured("DepthCamera", "kinds that fit", float(len(others) + 1), 1.0),
                cause=causes.AMBIGUOUS,
            )
    if not possible:
        if any(c.name == kind_name for standing_ in found for c in standing_.may_be):
            raise Discrepancy(f"{name} doesn't stand upright: it lies on a side", cause=causes.MISPLACED)
        unseen = Measured("DepthCamera", f"of {views} views those that show a {kind_name}", 0, 1)
        words = ", ".join(describe(standing_) for standing_ in found) or "nothing"
        raise Discrepancy(f"{name} isn't seen; seen: {words}", measured=unseen, cause=causes.NOT_SEEN)
    mine = [_candidate(standing_, kind_name) for standing_ in possible]
    places = np.array([(base_T_surface @ candidate.surface_T_solid)[:2, 3] for candidate in mine])
    chosen = _assigned(name, kind_name, places, beliefs)
    belief = next(object_belief for object_belief in beliefs if object_belief.object == name)
    eye = possible[chosen].cluster.eye
    return _located(mine[chosen], kind, belief.heading, base_T_surface, eye)


def obstacles(
    found: Sequence[Standing], base_T_surface: Transform, base_T_object: Transform, kind: ObjectKind
) -> Iterator[Box]:
    """Yield boxes, posed in the base frame, around the things that were seen next to an object on its
    surface.

    Args:
        found: all that stands on the surface.
        base_T_surface: (4, 4) of the middle of the surface's top.
        base_T_object: (4, 4) of the object.
        kind: kind of the object.
    """
    object_T_surface = inverse(base_T_object) @ base_T_surface
    half = np.array(kind.size[:2]) / 2 + CLEAR_M
    for number, standing_ in enumerate(found):
        points = standing_.cluster.points
        local = points @ object_T_surface[:3, :3].T + object_T_surface[:3, 3]
        beside = points[(np.abs(local[:, :2]) > half).any(axis=1)]
        if len(beside) >= MIN_OBSTACLE_POINTS:
            low, high = beside.min(axis=0), beside.max(axis=0)
            low[2] = 0.0
            x, y, z = (high - low).tolist()
            pose = base_T_surface @ transform(((low + high) / 2).tolist())
            yield Box(np.asarray(pose), (x, y, z), f"something seen {number + 1}")


def contradiction(
    found: Sequence[Standing],
    base_T_surface: Transform,
    base_T_object: Transform,
    kind_name: str,
    kind: ObjectKind,
) -> str:
    """Describe what was seen at an object's place, if it can't be the object; "" if it may be the object.

    Args:
        found: all things seen on the surface.
        base_T_surface: (4, 4) of the middle of the surface's top.
        base_T_object: (4, 4) of the object, by its tag.
        kind_name: name of the object's kind.
        kind: kind of the object.
    """
    place = (inverse(base_T_surface) @ base_T_object)[:2, 3]
    inner = INNER_SHARE * min(kind.size[:2]) / 2
    for standing_ in found:
        points = standing_.cluster.points
        heights = points[np.hypot(*(points[:, :2] - place).T) < inner, 2]
        if len(heights) < MIN_OBSTACLE_POINTS:
            continue
        if standing_.may_be and all(other.name != kind_name for other in standing_.may_be):
            return describe(standing_)
        height = float(np.median(heights))
        if abs(height - kind.size[2]) > HEIGHT_TOLERANCE_M:
            return f"something {1e3 * height:.0f} mm high"
    return ""


def describe(found: Standing) -> str:
    """Return a text with the kinds of object that could explain a thing seen in depth pictures; if no kind
    can, a text with the thing's size.
    """
    if found.may_be:
        return " or ".join(dict.fromkeys(_in_words(candidate) for candidate in found.may_be))
    x, y = 1e3 * np.ptp(found.cluster.points[:, :2], axis=0)
    return f"something {x:.0f} x {y:.0f} mm, {1e3 * found.cluster.top:.0f} mm high"


def _is(candidate: SolidCandidate, kind_name: str) -> bool:
    return candidate.name == kind_name and candidate.is_upright


def _in_words(candidate: SolidCandidate) -> str:
    return f"a {candidate.name}" if candidate.is_upright else f"a fallen {candidate.name}"


def _candidate(found: Standing, kind_name: str) -> SolidCandidate:
    return next(candidate for candidate in found.may_be if _is(candidate, kind_name))


def _assigned(name: str, kind_name: str, places: FloatArray, beliefs: Sequence[ObjectBelief]) -> int:
    """Return the index of the place that belongs to an object, out of places (n, 2) in the base frame, in
    [m].

    All places are assigned to objects of the kind. The best assignment has to be far likelier than any in
    which the object is at another place.
    """
    mine = next(number for number, object_belief in enumerate(beliefs) if object_belief.object == name)
    if len(places) > len(beliefs):
        many = Measured("DepthCamera", f"objects like a {kind_name}", len(places), len(beliefs))
        raise Discrepancy(
            f"{name} is ambiguous: {len(places)} like a {kind_name} are seen, {len(beliefs)} are known",
            measured=many,
            cause=causes.AMBIGUOUS,
        )
    best: dict[int | None, float] = {}
    for owners in permutations(range(len(beliefs)), len(places)):
        score = sum(_log_density(places[i], beliefs[owner]) for i, owner in enumerate(owners))
        spot = owners.index(mine) if mine in owners else None
        best[spot] = max(best.get(spot, -math.inf), score)
    ranked = sorted(best.items(), key=lambda item: -item[1])
    chosen, score = ranked[0]
    if len(ranked) > 1 and score - ranked[1][1] < MIN_LOG_RATIO:
        likelier = Measured("DepthCamera", "likelihood over the next", math.exp(score - ranked[1][1]), 100.0)
        raise Discrepancy(
            f"{name} may be another {kind_name}",
            measured=likelier,
            cause=causes.AMBIGUOUS,
        )
    if chosen is None:
        raise Discrepancy(f"{name} isn't seen; seen: another {kind_name}", cause=causes.NOT_SEEN)
    belief = beliefs[mine]
    if belief.place is not None:
        off = math.hypot(places[chosen, 0] - belief.place[0], places[chosen, 1] - belief.place[1])
        most = MAX_OFF_SIGMAS * belief.sigma
        if off > most:
            away = Measured("DepthCamera", "off its place", 1e3 * off, 1e3 * most, "mm")
            raise Discrepancy(
                f"{name} is ambiguous: a {kind_name} is far from where it is believed to be",
                measured=away,
                cause=causes.AMBIGUOUS,
            )
    return chosen


def _log_density(place: FloatArray, belief: ObjectBelief) -> float:
    if belief.place is None:
        return 0.0  # anywhere on a square metre
    off = math.hypot(place[0] - belief.place[0], place[1] - belief.place[1]) / belief.sigma
    return -0.5 * off**2 - math.log(2.0 * math.pi * belief.sigma**2)


def _located(
    found: SolidCandidate, kind: ObjectKind, heading: float, base_T_surface: Transform, eye: FloatArray
) -> Located:
    """Return a candidate in the base frame; of headings that look the same, with the one nearest to
    `heading`.

    Args:
        found: the candidate, in the frame of its surface.
        kind: kind of the object.
        heading: expected heading in the base frame, in [rad].
        base_T_surface: (4, 4) of the middle of the surface's top.
        eye: (3,) position of the camera in the frame of the surface, in [m].
    """
    pose = np.asarray(base_T_surface @ found.surface_T_solid)
    yaw = math.atan2(pose[1, 0], pose[0, 0])
    step = math.pi / 2 if abs(kind.size[0] - kind.size[1]) < SQUARE_M else math.pi
    yaw = heading if kind.is_round else yaw + step * round((heading - yaw) / step)
    turn = base_T_surface[:2, :2]
    covariance = found.covariance.copy()
    covariance[:2, :2] = turn @ covariance[:2, :2] @ turn.T
    distance = float(np.linalg.norm(eye - found.surface_T_solid[:3, 3]))
    by_arm = ARM_SIGMA_M**2 + (ARM_SIGMA_RAD * distance) ** 2
    covariance += np.diag([by_arm, by_arm, ARM_SIGMA_RAD**2])
    x, y, z = pose[:3, 3].tolist()
    return Located(transform((x, y, z), (0.0, 0.0, yaw)), covariance, 0.0)
