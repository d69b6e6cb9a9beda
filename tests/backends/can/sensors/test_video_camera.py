"""Camera beside the drives: from pictures and videos in files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from handcart.backends.can.sensors.video_camera import VideoCamera
from handcart.backends.description.can_sensor_spec import CameraSource
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.live.sensor_errors import NoSensor
from handcart.backends.robot.mounted_camera import MountedCamera, camera_model

CAMERA = CameraSpec(width_px=64, height_px=48, focal_px=60.0)


@pytest.fixture
def make_camera(clock: Any) -> Iterator[Callable[..., VideoCamera]]:
    made: list[VideoCamera] = []

    def make(source: Path, spec: CameraSpec = CAMERA) -> VideoCamera:
        made.append(
            VideoCamera(CameraSource(source=str(source)), MountedCamera(camera_model(spec), np.eye(4)), clock)
        )
        return made[-1]

    yield make
    for camera in made:
        camera.close()


def picture(grey: int) -> np.ndarray:
    return np.full((48, 64, 3), grey, np.uint8)


def test_a_picture_stays(tmp_path: Path, clock: Any, make_camera: Callable[..., VideoCamera]) -> None:
    path = tmp_path / "picture.png"
    cv2.imwrite(str(path), picture(77))
    camera = make_camera(path)
    for _ in range(5):
        clock.now += 1.0
        camera.advance()
        image = camera.image()
        assert image.shape == (48, 64)
        assert image.dtype == np.uint8
        assert int(image[0, 0]) == 77
    assert camera.model.width == 64


def test_a_video_goes_on_a_picture_a_period(tmp_path: Path, make_camera: Callable[..., VideoCamera]) -> None:
    path = tmp_path / "video.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10, (64, 48))
    for grey in (40, 120, 200):
        writer.write(picture(grey))
    writer.release()
    camera, seen = make_camera(path), []
    for _ in range(4):
        camera.advance()
        assert camera.image() is camera.image()
        seen.append(int(camera.image().mean()))
    np.testing.assert_allclose(seen, [40, 120, 200, 200], atol=3)


def test_a_picture_of_another_size_is_refused(
    tmp_path: Path, make_camera: Callable[..., VideoCamera]
) -> None:
    cv2.imwrite(str(tmp_path / "picture.png"), picture(77)[:40])
    with pytest.raises(NoSensor, match="the camera gives 64 x 40 pixels; the robot's file says 64 x 48"):
        make_camera(tmp_path / "picture.png")
    (tmp_path / "empty.png").write_bytes(b"")
    with pytest.raises(NoSensor, match=r"can't be opened|gives no picture"):
        make_camera(tmp_path / "empty.png")
