from typing import Any

import numpy as np
import pytest

from handcart.backends.description.sensor_specs import CalibratedCamera
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.mounted_camera import camera_model, known_camera, mount_of, stated_camera
from handcart.backends.simulation.calibration.mark_props import MarkProps
from handcart.backends.simulation.rendering.renderer import Renderer
from handcart.backends.simulation.sensors.true_camera import true_camera
from handcart.backends.simulation.simulated_backend import build_scene
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.robotics.geometry.transform import apply, difference, inverse, transform
from handcart.robotics.perception.landmarks.charuco_board import CharucoBoard
from handcart.robotics.perception.landmarks.landmark_pose import facing

FOUND = CalibratedCamera(
    focal_px=812.5,
    cx_px=321.0,
    cy_px=238.0,
    k1=-0.3,
    k2=0.1,
    xyz_mm=(1.0, -2.0, 3.0),
    rpy_deg=(0.0, 0.0, 1.0),
)
WORLD = {"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}}


def test_without_errors_the_camera_is_as_stated() -> None:
    robot = load_robot("toyama")
    assert robot.camera is not None
    mount = mount_of(robot, robot.camera)
    stated, true = stated_camera(robot.camera, mount), true_camera(robot.camera, mount, robot.errors, 3)
    assert np.array_equal(true.hand_T_camera, stated.hand_T_camera)
    assert np.array_equal(true.model.K, camera_model(robot.camera).K)
    assert np.array_equal(known_camera(robot.camera, mount).hand_T_camera, stated.hand_T_camera)


def test_the_seed_draws_how_the_camera_is_off() -> None:
    robot = load_robot("toyama/uncalibrated")
    spec = robot.camera
    assert spec is not None
    mount = mount_of(robot, spec)
    stated = stated_camera(spec, mount)
    drawn = [true_camera(spec, mount, robot.errors, seed) for seed in range(60)]
    far, turned = np.array([difference(stated.hand_T_camera, camera.hand_T_camera) for camera in drawn]).T
    assert np.sqrt(np.mean(far**2)) == pytest.approx(1.5e-3 * np.sqrt(3), rel=0.2)
    assert np.sqrt(np.mean(turned**2)) == pytest.approx(10e-3 * np.sqrt(3), rel=0.2)
    assert np.std([camera.model.K[0, 0] for camera in drawn]) == pytest.approx(8.0, rel=0.3)
    again = true_camera(spec, mount, robot.errors, 7)
    assert np.array_equal(again.hand_T_camera, drawn[7].hand_T_camera)
    ideal = robot.without_errors()
    assert np.array_equal(true_camera(spec, mount, ideal.errors, 7).hand_T_camera, stated.hand_T_camera)


def test_a_calibration_changes_what_is_known_and_not_what_is() -> None:
    robot = load_robot("toyama/uncalibrated")
    before = robot.camera
    assert before is not None
    mount = mount_of(robot, before)
    after = before.model_copy(update={"calibrated": FOUND})
    known = known_camera(after, mount)
    assert pytest.approx(np.array([[812.5, 0, 321], [0, 812.5, 238], [0, 0, 1]])) == known.model.K
    assert known.model.distortion == pytest.approx([-0.3, 0.1, 0, 0, 0])
    off = inverse(stated_camera(before, mount).hand_T_camera) @ known.hand_T_camera
    assert off == pytest.approx(transform((1e-3, -2e-3, 3e-3), (0.0, 0.0, np.radians(1.0))))
    ways = [true_camera(spec, mount, robot.errors, 5) for spec in (before, after)]
    assert np.array_equal(ways[0].hand_T_camera, ways[1].hand_T_camera)
    assert np.array_equal(ways[0].model.K, ways[1].model.K)
    changed = robot.model_copy(update={"camera": after})
    backends = [KinematicBackend(item, world_model().model_validate(WORLD), 5) for item in (robot, changed)]
    pictures = []
    for backend in backends:
        backend.step()
        camera: Any = next(
            capability for capability in backend.capabilities() if hasattr(capability, "image")
        )
        pictures.append(camera.image())
    assert np.array_equal(*pictures)
    assert camera.model.K[0, 0] == 812.5


@pytest.mark.parametrize("square", [20.0, 15.0])
def test_a_board_is_seen_where_it_lies(square: float) -> None:
    robot = load_robot("toyama")
    mark = {
        "x_m": 0.1,
        "y_m": -0.05,
        "height_m": 0.4,
        "heading_deg": 30.0,
        "kind": "board",
        "size_mm": square,
    }
    scene = build_scene(robot, world_model().model_validate(WORLD | {"marks": [mark]}), 0)
    assert robot.camera is not None
    camera = camera_model(robot.camera)
    camera_T_board = facing(0.3) @ transform(rpy=(0.2, -0.3, 0.1))
    image = Renderer(camera, robot.errors, 0).render(
        scene, scene.of(MarkProps).marks[0].pose @ inverse(camera_T_board), 1
    )
    view = CharucoBoard(square=square / 1e3).find(image)
    assert view is not None and len(view.points) == 40
    off = view.pixels - camera.project(apply(camera_T_board, view.points))
    assert np.linalg.norm(off, axis=1).mean() < 0.1
