"""The example that runs a reader's ONNX file as a detector."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.depth_camera import DepthImage
from handcart.primitives.detectors.detector import checked_detections
from handcart.robotics.geometry.transform import transform
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.objects.known_solids import KnownSolid

from .onnx_bytes import constant_boxes

pytest.importorskip("onnxruntime")
EXAMPLE = Path(__file__).parents[3] / "examples" / "onnx_detector" / "handcart_onnx.py"
KINDS = {"tin": KnownSolid("tin", (0.06, 0.06, 0.1), True)}
CAMERA = CameraModel(np.array([[100.0, 0, 31.5], [0, 100.0, 23.5], [0, 0, 1]]), np.zeros(5), 64, 48)


def detector(folder: Path, boxes: list[list[float]], **options: Any) -> Any:
    spec = importlib.util.spec_from_file_location("handcart_onnx", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (folder / "mine.onnx").write_bytes(constant_boxes(boxes))
    return module.OnnxDetector(KINDS, {"model": "mine.onnx", "classes": ["tin"], **options}, folder)


def test_onnx_box_becomes_an_upright_object_below_its_upper_side(tmp_path: Path) -> None:
    made = detector(tmp_path, [[24.0, 16.0, 40.0, 32.0, 0.9, 0.0], [0.0, 0.0, 9.0, 9.0, 0.2, 0.0]])
    depth = np.full((48, 64), 0.6, np.float32)
    depth[18:30, 26:38] = 0.5
    looking_down = transform((0.7, 0.1, 1.1), (np.pi, 0.0, 0.0))
    image = DepthImage(np.zeros((48, 64, 3), np.uint8), depth, looking_down, 0.0)
    (found,) = checked_detections("onnx", made, image, CAMERA)  # the other box has too low a score
    base_T_object = looking_down @ found.camera_T_object
    assert found.kind == "tin"
    assert base_T_object[:3, 3] == pytest.approx([0.7, 0.1, 0.5], abs=0.005)
    assert base_T_object[2, 2] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [({"model": "none.onnx"}, "no such file"), ({"classes": ["tim"]}, "unknown classes")],
)
def test_onnx_example_refuses_wrong_options(tmp_path: Path, options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        detector(tmp_path, [[0.0] * 6], **options)
