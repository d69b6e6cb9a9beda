"""Depth cameras and several cameras by topics."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.depth_camera import DepthCamera
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosCameraSpec, RosDepthSpec, RosSpec
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.air_check.air_report import listen
from handcart.backends.ros2.bench.bench_faults import BenchFaults, TopicFault
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.bench.robot_differences import RobotDifferences
from handcart.backends.ros2.cameras.ros_depth_camera import colour_of, depth_of
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.ros_topics import check_ros_section
from handcart.backends.ros2.wire.ros_errors import WrongRosSection
from handcart.backends.sensors.depth_spec import DepthCameraSpec

from .conftest import WORLD

DEPTH = RosDepthSpec(topic="head/depth/image_raw", colour="head/color/image_raw", stale_ms=700.0)
SPEC = RosSpec(depth={"deep": DEPTH}, cameras={"second": RosCameraSpec(topic="second/image_raw")})


def robot_with_cameras() -> RobotFile:
    """Return the librarian with a second camera and a depth camera, at the frame of its first."""
    robot = load_robot("librarian")
    assert robot.camera is not None
    small = {"width_px": 64, "height_px": 48, "focal_px": 80.0}
    first = robot.name_of(robot.camera)
    second = robot.camera.model_copy(update={"frame": "camera", **small, "width_px": 32, "height_px": 24})
    deep = DepthCameraSpec(frame="camera", width_px=64, height_px=48, focal_px=60.0)
    sensors = {**robot.sensors, first: robot.camera.model_copy(update=small), "second": second, "deep": deep}
    return robot.model_copy(update={"sensors": sensors, "ros2": SPEC}).read_in(robot.folder)


def backend_with(faults: tuple[str, ...] = ()) -> RosBackend:
    """Return that robot by topics."""
    robot = robot_with_cameras()
    planned = BenchFaults(robot.period_s, tuple(map(TopicFault.read, faults)))
    return RosBackend(robot, LocalBench(robot, SPEC, KinematicBackend.build(robot, WORLD, 0), planned))


def test_depth_by_topics_is_that_of_the_simulation() -> None:
    with backend_with() as backend:
        backend.step()
        deep, inner = backend.sensor("deep"), backend.inner.sensor("deep")  # type: ignore[union-attr]
        assert isinstance(deep, DepthCamera)
        assert isinstance(inner, DepthCamera)
        image, true = deep.image(), inner.image()
        assert np.array_equal(image.depth, true.depth, equal_nan=True)
        assert np.isfinite(image.depth).any()
        assert np.array_equal(image.colour, true.colour)
        assert image.base_T_camera == pytest.approx(true.base_T_camera, abs=1e-9)


def test_each_camera_has_its_own_pictures() -> None:
    with backend_with() as backend:
        backend.step()
        second, first = backend.sensor("second"), backend.get(Camera)  # type: ignore[type-abstract]
        assert isinstance(second, Camera)
        assert first is not None
        assert second.image().shape == (24, 32)
        assert first.image().shape == (48, 64)
        assert first is backend.sensor(first.sensor_name)


@pytest.mark.slow
def test_the_pose_of_depth_is_that_of_its_stamp() -> None:
    """A picture that comes late shows what was seen before: with the joints of then."""
    with backend_with(("delayed@head/depth/image_raw@0.5", "delayed@head/color/image_raw@0.5")) as backend:
        arm, deep = backend.get(Arm), backend.sensor("deep")  # type: ignore[type-abstract]
        assert arm is not None
        assert isinstance(deep, DepthCamera)
        begun = arm.joints()
        for period in range(24):
            arm.move(begun + 0.01 * (period + 1) * np.eye(len(begun))[0])
            backend.step()
        image = deep.image()
        turned = math.atan2(image.base_T_camera[1, 0], image.base_T_camera[0, 0])
        now = math.atan2(*deep._pose(1e9)[1::-1, 0])  # type: ignore[attr-defined]
        assert abs(math.remainder(now - turned, math.tau)) == pytest.approx(0.1, abs=0.015)


@pytest.mark.slow
def test_depth_that_lies_gives_no_picture() -> None:
    topic = DEPTH.colour
    with backend_with((f"old-stamps@{topic}@0.1",)) as backend:
        for _ in range(20):
            backend.step()
        with pytest.raises(RobotFault, match=rf"\({topic}\).*its stamp is 60 s old"):
            backend.sensor("deep").image()  # type: ignore[union-attr]


def message(encoding: str, pixels: np.ndarray, pad: int = 0) -> Any:
    """Return an Image with some bytes of padding in each row."""
    rows = pixels.reshape(pixels.shape[0], -1).view(np.uint8)
    padded = np.pad(rows, ((0, 0), (0, pad)))
    height, width = pixels.shape[:2]
    form = {"encoding": encoding, "step": padded.shape[1], "is_bigendian": int(pixels.dtype.byteorder == ">")}
    return SimpleNamespace(height=height, width=width, data=padded.tobytes(), **form)


def test_depth_in_mm_and_in_m_reads_alike() -> None:
    metres = np.array([[0.0, 0.2, 1.0], [2.5, 7.0, np.inf]], np.float32)
    wanted = np.array([[np.nan, np.nan, 1.0], [2.5, np.nan, np.nan]], np.float32)
    steps = np.array([[0, 200, 1000], [2500, 7000, 0]])
    for made in (
        message("32FC1", metres, pad=4),
        *(message("16UC1", steps.astype(k), 3) for k in ("<u2", ">u2")),
    ):
        assert np.allclose(depth_of(made, 0.3, 6.0), wanted, atol=1e-6, equal_nan=True)
    blue = np.array([[[255, 0, 0]]], np.uint8)
    assert colour_of(message("bgr8", blue)).tolist() == [[[0, 0, 255]]]
    assert colour_of(message("rgb8", blue)).tolist() == [[[255, 0, 0]]]


def test_a_check_names_depth_of_another_size_or_lens() -> None:
    robot = robot_with_cameras()
    sensors = {
        **robot.sensors,
        "deep": DepthCameraSpec(frame="camera", width_px=64, height_px=48, focal_px=90.0),
    }
    true = robot.model_copy(update={"sensors": sensors}).read_in(robot.folder)
    bench = LocalBench(true, SPEC, KinematicBackend.build(true, WORLD, 0))
    report = listen(robot, SPEC, bench.link, bench.step, 0.3)
    bench.close()
    assert len(report.faults) == 1
    assert "head/depth/camera_info: its lens (focal 90.0 90.0" in report.faults[0].words


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1000.0, r"\d+% of its readings are beyond 6 m \(reach_m\).*in mm\? \(32FC1 means m\)"),
        (0.001, r"nearer than half of 0.3 m \(range_min_m\).*in m or cm\?"),
    ],
)
def test_a_check_names_depth_in_another_unit(factor: float, words: str) -> None:
    robot = robot_with_cameras()
    wrong = RobotDifferences({"depth": factor})
    bench = LocalBench(robot, SPEC, KinematicBackend.build(robot, WORLD, 0), differences=wrong)
    report = listen(robot, SPEC, bench.link, bench.step, 0.3)
    bench.close()
    (fault,) = report.faults
    assert fault.key == ("ros2", "depth")
    assert re.search(words, fault.words), fault.words


def test_cameras_that_the_robot_lacks_are_named() -> None:
    robot = robot_with_cameras()
    assert robot.camera is not None
    wrong = RosSpec(depth={"dep": DEPTH}, cameras={robot.name_of(robot.camera): RosCameraSpec()})
    with pytest.raises(WrongRosSection) as caught:
        check_ros_section(robot, wrong)
    assert "depth: the robot has no further depth camera 'dep'; did you mean 'deep'?" in str(caught.value)
    assert "is the first camera; needed: its topic under the key camera" in str(caught.value)
