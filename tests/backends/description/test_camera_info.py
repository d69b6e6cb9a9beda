"""Cameras as ROS describes them."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.mounted_camera import camera_model, known_camera, mount_of
from handcart.evaluation.trials.rig import build_rig
from handcart.files.errors import FileError
from handcart.primitives.books.recognize import Recognize
from handcart.primitives.outcomes.outcome import Success

INFO = """\
image_width: 640
image_height: 480
camera_name: hand
camera_matrix: {rows: 3, cols: 3, data: [601.5, 0, 319.2, 0, 602.5, 241.7, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.28, 0.09, 0.001, -0.0005, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [600, 0, 319, 0, 0, 600, 241, 0, 0, 0, 1, 0]}
"""


RATIONAL = [0.52, -0.21, 1e-4, -3e-4, 0.011, 0.85, -0.12, 0.004]


def robot_with(folder: Path, info: str, camera: str = "{camera_info: hand.yaml}") -> Path:
    """Write a librarian whose camera a file of ROS describes."""
    shutil.copytree(robot_path("librarian").parent, folder, dirs_exist_ok=True)
    (folder / "hand.yaml").write_text(info, encoding="utf-8")
    path = folder / "robot.yaml"
    lines = path.read_text(encoding="utf-8").split("\n")
    start = next(number for number, line in enumerate(lines) if line.startswith("camera:"))
    end = next(number for number in range(start + 1, len(lines)) if lines[number][:1].strip())
    path.write_text("\n".join([*lines[:start], f"camera: {camera}", *lines[end:]]), encoding="utf-8")
    return path


def refused(path: Path) -> str:
    with pytest.raises(FileError) as error:
        load_robot(str(path))
    return str(error.value).replace(f"{path.parent}/", "")


def test_camera_is_as_its_file_of_ros_says(tmp_path: Path) -> None:
    robot = load_robot(str(robot_with(tmp_path, INFO)))
    assert robot.camera is not None
    model = known_camera(robot.camera, mount_of(robot, robot.camera)).model
    assert (model.width, model.height, robot.camera.focal_px) == (640, 480, 601.5)
    assert model.K[1].tolist() == [0.0, 602.5, 241.7]
    assert model.distortion.tolist() == [-0.28, 0.09, 0.001, -0.0005, 0.0]


@pytest.mark.parametrize(
    ("name", "data", "lens", "distortion"),
    [
        ("plumb_bob", [-0.3, 0.1, 0.0, 0.0], "brown", [-0.3, 0.1, 0.0, 0.0, 0.0]),
        ("plumb_bob", [-0.3, 0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], "brown", [-0.3, 0.1, 0.0, 0.0, 0.0]),
        ("rational_polynomial", RATIONAL, "brown", RATIONAL),
        ("rational_polynomial", RATIONAL + [0] * 6, "brown", RATIONAL),
        ("equidistant", [0.01, 0.02, 0.0, 0.0], "fisheye", [0.01, 0.02, 0.0, 0.0]),
        ("plumb_bob", [], "brown", [0.0] * 5),
    ],
)
def test_lenses_of_ros_are_read(
    tmp_path: Path, name: str, data: list[float], lens: str, distortion: list[float]
) -> None:
    text = INFO.replace("plumb_bob", name).replace("[-0.28, 0.09, 0.001, -0.0005, 0]", str(data))
    camera: Any = load_robot(str(robot_with(tmp_path, text))).camera
    model = camera_model(camera)
    assert model.lens == lens
    assert np.array_equal(model.distortion, distortion)


@pytest.mark.parametrize("key", ["distortion_model", "camera_model"])
def test_fisheye_named_by_either_key_is_a_fisheye(tmp_path: Path, key: str) -> None:
    data = [0.0176, -0.0032, 0.0004, -0.0007]
    text = INFO.replace("distortion_model: plumb_bob", f"{key}: fisheye")
    text = text.replace("[-0.28, 0.09, 0.001, -0.0005, 0]", str(data))
    camera: Any = load_robot(str(robot_with(tmp_path, text))).camera
    model = camera_model(camera)
    assert (model.lens, model.distortion.tolist()) == ("fisheye", data)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("plumb_bob", "plump_bob", "plump_bob"),
        (
            "-0.0005, 0]",
            "-0.0005, 0, 0, 0.1]",
            "plumb_bob has 7 coefficients, zeros at their end aside; allowed: 5, or rational_polynomial",
        ),
        ("0, 0, 1]}\ndist", "0, 0]}\ndist", "camera_matrix has 8 numbers; allowed: 9"),
        ("[601.5, 0,", "[601.5, -0.67,", "camera_matrix has a skew of -0.67 px; allowed: 0"),
        ("[601.5", "[0", "camera_matrix is not [fx, 0, cx, 0, fy, cy, 0, 0, 1]"),
        ("image_width: 640", "image_width: 0", "image_width"),
        (
            "image_width: 640\nimage_height: 480",
            "image_width: 320\nimage_height: 240",
            "camera_matrix has its centre at (319.2, 241.7) px, in a picture of 320 x 240 px; allowed",
        ),
        ("319.2, 0, 602.5, 241.7", "0.499, 0, 602.5, 0.504", "has its centre at (0.499, 0.504) px"),
        ("distortion_coefficients", "distortion_coeficients", "hand.yaml:6:1: unknown key 'distortion_coef"),
        ("image_width", "image_widht", "unknown key 'image_widht'; did you mean 'image_width'?"),
        ("[-0.28, 0.09,", "[-2.8, 0.09,", "the lens model folds back within the picture"),
    ],
)
def test_broken_camera_info_is_refused_at_its_place(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in INFO
    said = refused(robot_with(tmp_path, INFO.replace(old, new)))
    assert said.startswith("hand.yaml:")
    assert message in said


@pytest.mark.parametrize(
    ("camera", "message"),
    [
        ("{camera_info: head.yaml}", "missing file 'head.yaml'; allowed: one beside the robot's file"),
        ("{camera_info: hand.yaml, k1: 0.1}", "camera_info and k1; allowed: camera_info, which has them"),
        ("{width_px: 640, height_px: 480}", "no focal_px; needed: numbers above 0, or the key camera_info"),
        ("{camera_info: ../../hand.yaml}", "leads out of"),
    ],
)
def test_wrong_camera_section_is_refused(tmp_path: Path, camera: str, message: str) -> None:
    assert message in refused(robot_with(tmp_path / "robots" / "mine", INFO, camera))


def test_fisheye_that_sees_too_far_off_its_axis_is_refused(tmp_path: Path) -> None:
    text = INFO.replace("plumb_bob", "equidistant").replace(
        "[-0.28, 0.09, 0.001, -0.0005, 0]", "[0, 0, 0, 0]"
    )
    assert "degrees off the axis; allowed: 75" in refused(robot_with(tmp_path, text.replace("60", "28")))


def test_robot_with_a_fisheye_reads_the_book_on_its_tray(tmp_path: Path) -> None:
    text = INFO.replace("plumb_bob", "equidistant").replace(
        "-0.28, 0.09, 0.001, -0.0005, 0", "-0.02, 0.004, 0, 0"
    )
    with build_rig(robot=str(robot_with(tmp_path, text))) as rig:
        assert isinstance(rig.do(Recognize()), Success)
