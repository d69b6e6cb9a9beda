"""Beams of a range sensor are as free as MuJoCo says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.mujoco.engine.beams import LidarBeams
from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.backends.mujoco.engine.world_spec import ROBOT_GROUP
from handcart.backends.mujoco.mujoco_backend import MujocoBackend
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.robotics.geometry.transform import transform

WORLD = {
    "format": "handcart-world/1",
    "start": {"x_m": 1.0, "y_m": 1.0},
    "walls": [{"from_m": [0.0, 0.0], "to_m": [4.0, 0.5]}, {"from_m": [4.0, 0.5], "to_m": [4.0, 3.0]}],
    "furniture": [{"name": "desk", "x_m": 2.2, "y_m": 1.4, "heading_deg": 20, "size_m": [0.6, 0.4, 0.75]}],
    "tray": {
        "accession": 1,
        "call": "1 A",
        "thickness_mm": 30,
        "height_mm": 200,
        "depth_mm": 150,
        "grey": 90,
    },
}
ROUGH = {
    "format": "handcart-world/1",
    "start": {"x_m": 0.0, "y_m": 0.0},
    "ground": {"roughness_deg": 2.5},
    "sensors": {"count": 1},
}


@pytest.fixture(scope="module")
def engine() -> Iterator[Any]:
    backend = MujocoBackend(load_robot("librarian"), world_model().model_validate(WORLD), 0)
    yield backend._engine
    backend.close()


@pytest.mark.parametrize("height", [0.2, 0.6, -0.1])
@pytest.mark.parametrize("tilt", [0.0, 0.1])
def test_beams_end_where_mujoco_has_them_end(engine: Any, height: float, tilt: float) -> None:
    turned = np.linspace(-np.pi, np.pi, 90, endpoint=False)
    pose = transform((1.0, 1.0, height), (0.0, tilt, 0.0))
    ends = pose[:3, 3] + 6.0 * np.c_[np.cos(turned), np.sin(turned), 0 * turned] @ pose[:3, :3].T
    shares = engine.free_shares(pose[:3, 3], ends)
    expected = np.array([_first(engine, pose[:3, 3], end) for end in ends])
    assert np.isfinite(expected).any() == (height > 0.0 or tilt > 0.0)
    np.testing.assert_allclose(shares, expected, rtol=1e-9)
    np.testing.assert_allclose(engine._beams._asked(engine.links(), pose[:3, 3], ends), expected, rtol=1e-9)


def _first(engine: Any, start: Any, end: Any) -> float:
    """Return the end of one beam, by MuJoCo's function for a single one."""
    groups, met = np.ones(6, np.uint8), np.zeros(1, np.int32)
    groups[ROBOT_GROUP] = 0
    share = mujoco().mj_ray(engine.model, engine.links(), start, end - start, groups, 1, -1, met, None)
    return float(share) if met[0] >= 0 and share <= 1.0 else np.inf


def test_what_is_no_box_is_left_to_mujoco(engine: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []
    of_mujoco = LidarBeams._asked

    def listening(self: LidarBeams, data: Any, start: Any, ends: Any) -> Any:
        asked.append(float(start[2]))
        return of_mujoco(self, data, start, ends)

    monkeypatch.setattr(LidarBeams, "_asked", listening)
    model, data = engine.model, engine.links()
    wedge = int(
        np.flatnonzero((model.geom_type == mujoco().mjtGeom.mjGEOM_MESH) & (model.geom_group != 1))[0]
    )
    beside = data.geom_xpos[wedge] + np.array([0.3, 0.0, 0.0])
    for height in (0.0, -0.4):  # through its edge, and below it
        start = beside + np.array([0.0, 0.0, height])
        engine.free_shares(start, start + np.array([[-0.6, 0.0, 0.0], [0.6, 0.0, 0.0]]))
    assert asked == [float(beside[2])]


@pytest.fixture(scope="module")
def outdoors() -> Iterator[Any]:
    world = {**ROUGH, "furniture": [{"name": "rock", "x_m": 3.0, "y_m": 0.5, "size_m": [0.5, 0.5, 1.2]}]}
    backend = MujocoBackend(load_robot("el_verde"), world_model().model_validate(world), 3)
    yield backend._engine
    backend.close()


@pytest.mark.slow
@pytest.mark.parametrize("height", [0.15, 0.5, 1.5])
@pytest.mark.parametrize("tilt", [0.0, 0.1, -0.4])
def test_beams_end_at_rough_ground_where_mujoco_has_them_end(
    outdoors: Any, height: float, tilt: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Across tiles as well; ground is bilinear here, and of two triangles a cell in MuJoCo."""
    turned = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    pose = transform((0.3, -0.4, height), (0.5 * tilt, tilt, 0.0))
    start, long = pose[:3, 3], 8.0
    ends = start + long * np.c_[np.cos(turned), np.sin(turned), 0 * turned] @ pose[:3, :3].T
    expected = long * outdoors._beams._asked(outdoors.links(), start, ends)
    monkeypatch.setattr(LidarBeams, "_asked", None)
    shares = long * outdoors.free_shares(start, ends)
    met = np.isfinite(expected)
    assert met.any() == (height < 1.0 or tilt < 0.0)
    if not met.any():
        assert np.isinf(shares).all()
        return
    off = np.abs(shares[met & np.isfinite(shares)] - expected[met & np.isfinite(shares)])
    grazing = (met != np.isfinite(shares)).sum() + (off > 0.1).sum()
    assert grazing <= 4  # beams along a ridge: 2 mm up or down is some metres on
    assert np.quantile(off, 0.95) < 0.03
