"""Recognition of known solids on a table, from depth pictures with the errors of structured light."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from handcart.backends.sensors.depth_spec import DepthCameraSpec, DepthErrors
from handcart.backends.simulation.depth.box_depth import BoxDepth
from handcart.backends.simulation.depth.depth_noise import DepthNoise
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box, Solid
from handcart.robotics.kinematics.shapes import Cylinder as Rod
from handcart.robotics.manipulation.grasping.camera_poses import camera_poses, from_direction
from handcart.robotics.perception.objects.depth_view import depth_view, over_surface
from handcart.robotics.perception.objects.known_solids import KnownSolid, SolidCandidate, candidates
from handcart.robotics.perception.objects.standing_clusters import standing_clusters

PARCEL = KnownSolid("parcel", (0.06, 0.09, 0.08))
CAN = KnownSolid("can", (0.062, 0.062, 0.115), True)
CARTON = KnownSolid("carton", (0.05, 0.12, 0.06))
TIN = KnownSolid("tin", (0.058, 0.058, 0.072), True)
KNOWN = (PARCEL, CAN, CARTON, TIN)
TABLE_M, SIZE_M = 0.6, (0.6, 0.9)
AHEAD = transform((0.8, 0.0, TABLE_M))
VIEWS_RAD = (0.0, 0.6)


def standing_at(solid: KnownSolid, y: float = 0.0, turn: float = 0.3, x: float = 0.7, down: int = 2) -> Solid:
    """Return a solid with its axis `down` vertical, posed in the base frame."""
    lying = {0: (0.0, math.pi / 2, 0.0), 1: (math.pi / 2, 0.0, 0.0), 2: (0.0, 0.0, 0.0)}[down]
    pose = transform((x, y, TABLE_M + solid.size[down] / 2), (0.0, 0.0, turn)) @ transform(rpy=lying)
    return Rod(pose, solid.size[0] / 2, solid.size[2]) if solid.is_round else Box(pose, solid.size)


def looked_at(
    *bodies: Solid,
    views: Sequence[float] = VIEWS_RAD,
    seed: int = 0,
    aside: float = 0.0,
    known: Sequence[KnownSolid] = KNOWN,
    **errors: float,
) -> list[list[SolidCandidate]]:
    """Return what each thing on the table may be, largest first."""
    spec = DepthCameraSpec(width_px=240, height_px=180, focal_px=280, errors=DepthErrors(**errors))  # type: ignore[arg-type]
    table = Box(transform((0.8, 0.0, TABLE_M - 0.05)), (*SIZE_M, 0.1))
    seen = []
    for number, tilt in enumerate(views):
        point = np.array([0.7, aside, TABLE_M + 0.08])
        pose = next(camera_poses(point, from_direction(tilt, math.pi), 0.45))
        true, _ = BoxDepth(spec.model).cast(pose, [table, *bodies])
        view = depth_view(DepthNoise(spec, seed).read(true, number), spec.model, pose)
        levelled = over_surface(view, AHEAD, SIZE_M)
        if levelled is not None:
            seen.append(levelled)
    return [candidates(cluster, known) for cluster in standing_clusters(seen, SIZE_M)]


@pytest.mark.parametrize("solid", KNOWN, ids=lambda item: item.name)
def test_known_solid_is_told_and_located(solid: KnownSolid) -> None:
    turn = 1.1
    found = looked_at(standing_at(solid, 0.02, turn), seed=1)
    assert [(item.name, item.is_upright) for item in found[0]] == [(solid.name, True)]
    off = (AHEAD @ found[0][0].surface_T_solid)[:2, 3] - (0.7, 0.02)
    covariance = found[0][0].covariance
    assert np.hypot(*off) < 0.004
    assert off @ np.linalg.inv(covariance[:2, :2] + 1e-6 * np.eye(2)) @ off < 9.0
    if not solid.is_round:
        yaw = math.atan2(found[0][0].surface_T_solid[1, 0], found[0][0].surface_T_solid[0, 0])
        assert abs(math.remainder(yaw - turn, math.pi)) < 0.03


@pytest.mark.parametrize("width", [0.006, 0.009, 0.012])
def test_narrow_boxes_are_told(width: float) -> None:
    """No point on top of one is far from its edges."""
    bar = KnownSolid("bar", (width, 0.12, 0.06))
    (found,) = looked_at(standing_at(bar, turn=1.1), seed=1, known=(bar,))
    assert [item.name for item in found] == ["bar"]


def test_two_touching_boxes_are_neither() -> None:
    assert looked_at(standing_at(PARCEL, -0.045, 0.0), standing_at(PARCEL, 0.046, 0.0)) == [[]]


@pytest.mark.parametrize(("solid", "down"), [(PARCEL, 0), (PARCEL, 1), (CAN, 0), (TIN, 0)])
def test_fallen_solid_is_never_upright(solid: KnownSolid, down: int) -> None:
    found = looked_at(standing_at(solid, down=down))
    assert [(item.name, item.is_upright) for item in found[0]] == [(solid.name, False)]


def test_stranger_of_another_size_is_unknown() -> None:
    assert looked_at(standing_at(KnownSolid("stranger", (0.075, 0.11, 0.08)))) == [[]]


def test_box_half_out_of_the_picture_is_not_misplaced() -> None:
    """It is either not named, or its place is right within what is claimed."""
    named = 0
    for aside in np.arange(0.12, 0.20, 0.02).tolist():
        for found in looked_at(standing_at(PARCEL, aside), views=(0.0,)):
            for item in found:
                named += 1
                off = (AHEAD @ item.surface_T_solid)[:2, 3] - (0.7, aside)
                assert off @ np.linalg.inv(item.covariance[:2, :2] + 1e-6 * np.eye(2)) @ off < 20.0
    assert named


def test_shiny_box_without_readings_is_unknown() -> None:
    found = looked_at(standing_at(PARCEL), dropout_percent=90.0)
    assert all(not any(item.name != "parcel" for item in one) for one in found)


def test_two_of_one_kind_are_two() -> None:
    found = looked_at(standing_at(CAN, -0.09), standing_at(CAN, 0.09))
    assert [[item.name for item in one] for one in found] == [["can"], ["can"]]
