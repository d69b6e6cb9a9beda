"""A detector for handcart that runs an ONNX file of yours: boxes in the picture, places from the depths."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handcart.backends.capabilities.depth_camera import DepthImage
from handcart.primitives.detectors.detector import Detection, Detector
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.objects.known_solids import KnownSolid

MIN_READINGS = 20  # of depth in a box
NEAR_SHARE = 0.2  # of the readings in a box, the nearest ones: the upper side


class OnnxDetector(Detector):
    """Runs a network on the picture, (1, 3, h, w) from 0 to 1.

    Its first output is (n, 6): left, top, right and bottom in [px], score, and number of the class.

    Options: `model`, the file; `classes`, kinds in the order of the network's classes; `min_score`, 0.5.
    """

    def __init__(self, kinds: Mapping[str, KnownSolid], options: Mapping[str, Any], folder: Path) -> None:
        import onnxruntime

        super().__init__(kinds, options, folder)
        model = folder / str(options.get("model", "model.onnx"))
        if not model.is_file():
            raise ValueError(f"no such file: {model}; allowed: `model`, an ONNX file")
        self.classes = list(options.get("classes", []))
        unknown = [class_ for class_ in self.classes if class_ not in kinds]
        if unknown or not self.classes:
            raise ValueError(f"unknown classes {unknown}; allowed: `classes`, a list of {', '.join(kinds)}")
        self.min_score = float(options.get("min_score", 0.5))
        self.session = onnxruntime.InferenceSession(str(model), providers=["CPUExecutionProvider"])

    def detect(self, image: DepthImage, camera: CameraModel) -> Sequence[Detection]:
        name = self.session.get_inputs()[0].name
        picture = image.colour.astype(np.float32).transpose(2, 0, 1)[None] / 255.0
        boxes = np.asarray(self.session.run(None, {name: picture})[0]).reshape(-1, 6)
        return list(self._located(boxes, image, camera))

    def _located(
        self, boxes: npt.NDArray[Any], image: DepthImage, camera: CameraModel
    ) -> Iterator[Detection]:
        for left, top, right, bottom, score, number in boxes.tolist():
            if score < self.min_score or not 0 <= number < len(self.classes):
                continue
            rows, columns = (
                slice(max(0, round(a)), max(0, round(b))) for a, b in ((top, bottom), (left, right))
            )
            depth = np.asarray(image.depth[rows, columns], dtype=np.float64)
            near = np.sort(depth[np.isfinite(depth)])
            if len(near) >= MIN_READINGS:
                kind = self.kinds[self.classes[int(number)]]
                yield self._upright(kind, near, ((left + right) / 2, (top + bottom) / 2), image, camera)

    def _upright(
        self,
        kind: KnownSolid,
        near: npt.NDArray[np.float64],
        middle: tuple[float, float],
        image: DepthImage,
        camera: CameraModel,
    ) -> Detection:
        """Put an upright object below the middle of its box; its heading is unknown.

        The covariance is that of the depths, and of a middle that is anywhere within a tenth of the object.
        """
        upper = near[: max(MIN_READINGS, round(NEAR_SHARE * len(near)))]
        z = float(np.median(upper))
        ray = camera.undistort(np.array([middle]))[0]
        camera_T_base = np.linalg.inv(image.base_T_camera)
        pose = np.eye(4)
        pose[:3, :3] = camera_T_base[:3, :3]
        pose[:3, 3] = np.array([*(ray * z), z]) - kind.size[2] * camera_T_base[:3, 2]
        lateral = max(kind.size[:2]) / 10.0
        sigmas = [lateral, lateral, max(float(upper.std()), 1e-4)]
        covariance = np.diag(np.square([*sigmas, math.pi, math.pi, math.pi]))
        return Detection(kind.name, pose, covariance)
