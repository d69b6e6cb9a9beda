"""A cart with a depth camera on a mast, in a room with a box, on each simulated backend."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from handcart.backends.backend import Backend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend

CART = Path(__file__).parents[4] / "backends" / "robots" / "cart"
MAST = """
  <link name="mast"/>
  <joint name="mast_mount" type="fixed"><parent link="base"/><child link="mast"/>
    <origin xyz="0.35 0 1.0" rpy="{tilt} 0 -1.5707963267948966"/></joint>
</robot>
"""
LEVEL, DOWN = -1.5707963267948966, -2.0
WORLD = """\
format: handcart-world/1
start: {{x_m: 1.0, y_m: 1.5, heading_deg: 0}}
camera: {camera}
walls:
  - {{from_m: [0, 0], to_m: [4, 0]}}
  - {{from_m: [4, 0], to_m: [4, 3]}}
  - {{from_m: [4, 3], to_m: [0, 3]}}
  - {{from_m: [0, 3], to_m: [0, 0]}}
furniture:
  - {{name: box, x_m: 2.6, y_m: 1.5, heading_deg: 0, size_m: [0.4, 0.5, 1.4]}}
"""
EXACT = "errors: {none: true}\n"

Make = Callable[..., Backend]


@pytest.fixture(params=["kinematic", "mujoco", "pybullet"])
def backend_name(request: pytest.FixtureRequest) -> str:
    if request.param == "pybullet":
        pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    return str(request.param)


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    """Builds a backend by its name; all are closed in the end."""
    built = []

    def one(
        name: str,
        keys: str = "",
        errors: str = EXACT,
        tilt: float = LEVEL,
        camera: str = "scene",
        seed: int = 3,
        things: str = "",
    ) -> Backend:
        urdf = (CART / "cart.urdf").read_text(encoding="utf-8").replace("</robot>", MAST.format(tilt=tilt))
        (tmp_path / "cart.urdf").write_text(urdf, encoding="utf-8")
        text = (CART / "robot.yaml").read_text(encoding="utf-8")
        kept = text[: text.index("errors:")] + text[text.index("tolerance:") :]
        section = f"{{kind: depth_camera, width_px: 120, height_px: 90, focal_px: 100{keys}}}"
        (tmp_path / "robot.yaml").write_text(
            f"{kept}{errors}sensors: {{mast: {section}}}\n", encoding="utf-8"
        )
        (tmp_path / "world.yaml").write_text(WORLD.format(camera=camera) + things, encoding="utf-8")
        robot = load_robot(str(tmp_path / "robot.yaml"))
        built.append(make_backend(name, robot, tmp_path / "world.yaml", seed))
        return built[-1]

    yield one
    for backend in built:
        backend.close()
