"""ROS camera calibration: the YAML file that `camera_calibration` and `camera_info_manager` write."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AliasChoices, ConfigDict, Field, model_validator
from typing_extensions import override

from handcart.files.errors import Finding
from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.files.suggest import MISSPELLED, nearest
from handcart.files.yaml.yaml_document import Document
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.cameras.lens_fold import LensKind

Pixels = Annotated[int, Field(gt=0, le=20_000)]
MAX_OFF_AXIS_DEG = 75  # the field of view is computed in a plane, which grows without bound toward 90
FOLD_PX = 0.5
RIM_SHARE = 0.05
"""Width of a picture's rim, as a share of its width or height, in which no optical axis is."""
COEFFICIENT_COUNTS = {
    "plumb_bob": (4, 5),
    "rational_polynomial": (8,),
    "equidistant": (4,),
    "fisheye": (4,),
}
"""Distortion models by name, each with its allowed numbers of coefficients; further ones have to be 0."""


class Matrix(FileModel):
    """A matrix of a camera in a ROS `camera_info` file; `data` holds the matrix's values row by row."""

    model_config = ConfigDict(extra="ignore")

    data: tuple[float, ...]


class CameraInfo(FileModel):
    """Picture size, camera matrix and distortion from a ROS `camera_info` file.

    Other keys of the file are skipped.
    """

    model_config = ConfigDict(extra="ignore")

    image_width: Pixels
    image_height: Pixels
    camera_matrix: Matrix
    """Camera matrix K, 3 x 3, in [px]."""
    distortion_model: Literal["plumb_bob", "rational_polynomial", "equidistant", "fisheye"] = Field(
        "plumb_bob", validation_alias=AliasChoices("distortion_model", "camera_model")
    )
    """Distortion model; some versions of `camera_calibration` call this key `camera_model` for fisheye
    lenses.
    """
    distortion_coefficients: Matrix = Matrix(data=())
    """Coefficients D in the order k1, k2, p1, p2, k3, k4, k5, k6, or the four of `equidistant`."""

    @model_validator(mode="after")
    def _is_camera(self) -> Self:
        k = self.camera_matrix.data
        if len(k) != 9:
            raise ValueError(f"camera_matrix has {len(k)} numbers; allowed: 9")
        if k[1] != 0.0:
            raise ValueError(
                f"camera_matrix has a skew of {k[1]:g} px; allowed: 0, calibrate with a fixed skew"
            )
        if k[0] <= 0.0 or k[4] <= 0.0 or k[8] != 1.0 or any(k[at] != 0.0 for at in (3, 6, 7)):
            raise ValueError("camera_matrix is not [fx, 0, cx, 0, fy, cy, 0, 0, 1] with fx, fy above 0")
        if not self._is_centre_inside():
            size = f"a picture of {self.image_width} x {self.image_height}"
            wrong = f"camera_matrix has its centre at ({k[2]:g}, {k[5]:g}) px, in {size} px"
            raise ValueError(
                f"{wrong}; allowed: inside it, not at its rim; image_width and image_height are those of the "
                "calibration, and the centre is in pixels"
            )
        count, allowed = len(self._coefficients), COEFFICIENT_COUNTS[self.distortion_model]
        if count > max(allowed):
            wrong = f"{self.distortion_model} has {count} coefficients, zeros at their end aside"
            other = ", or rational_polynomial" if self.distortion_model == "plumb_bob" and count <= 8 else ""
            raise ValueError(f"{wrong}; allowed: {max(allowed)}{other}")
        if fault := _lens_fault(self.model):
            raise ValueError(fault)
        return self

    @override
    def contradictions(self, document: Document) -> Iterator[Finding]:
        meant = {"distortion_model", "distortion_coefficients"} - document.data.keys()
        for key in document.data:
            if (right := nearest(key, meant, MISSPELLED)) and key not in type(self).model_fields:
                yield document.finding((key,), f"unknown key {key!r}; did you mean {right!r}?", at_key=True)

    def _is_centre_inside(self) -> bool:
        """Return whether the optical axis meets the picture farther than `RIM_SHARE` from its edges.

        Otherwise the matrix is one of another picture size, or in shares of the picture.
        """
        k = self.camera_matrix.data
        shares = k[2] / self.image_width, k[5] / self.image_height
        return all(RIM_SHARE <= share <= 1.0 - RIM_SHARE for share in shares)

    @property
    def _coefficients(self) -> tuple[float, ...]:
        """Distortion coefficients without the zeros at their end."""
        data = self.distortion_coefficients.data
        while data and data[-1] == 0.0:
            data = data[:-1]
        return data

    @property
    def model(self) -> CameraModel:
        """Camera model (lens and picture size) that a calibration file `camera_info` describes."""
        return CameraModel(self.K, self.distortion, self.image_width, self.image_height, self.lens)

    @property
    def lens(self) -> LensKind:
        """Kind of lens model that OpenCV needs for the picture, by the file's `distortion_model`."""
        return "fisheye" if self.distortion_model in ("equidistant", "fisheye") else "brown"

    @property
    def distortion(self) -> FloatArray:
        """Distortion coefficients in OpenCV's order, without unit.

        Their shape is (4,) for a fisheye lens, (5,) or (8,) for other lenses.
        """
        size = next(size for size in (5, 8) if size >= len(self._coefficients))
        filled = np.zeros(4 if self.lens == "fisheye" else size)
        filled[: len(self._coefficients)] = self._coefficients
        return filled

    @property
    def K(self) -> FloatArray:
        """Camera matrix (3, 3), in [px]."""
        return np.array(self.camera_matrix.data).reshape(3, 3)


def _lens_fault(camera: CameraModel) -> str:
    """Return why the lens model cannot be used in the whole picture; "" if it can."""
    last = np.array([camera.width - 1.0, camera.height - 1.0])
    rim = np.array([[x, y] for x in (0.0, 0.5, 1.0) for y in (0.0, 0.5, 1.0)]) * last
    rays = camera.undistort(rim)
    again = camera.project(np.column_stack([rays, np.ones(len(rays))]))
    if not np.allclose(again, rim, atol=FOLD_PX):
        return "the lens model folds back within the picture; allowed: one that holds up to its corners"
    off_axis = float(np.degrees(np.arctan(np.hypot(*rays.T).max())))
    if off_axis > MAX_OFF_AXIS_DEG:
        return f"the picture shows {off_axis:.0f} degrees off the axis; allowed: {MAX_OFF_AXIS_DEG}"
    return ""


def load_camera_info(path: Path) -> CameraInfo:
    """Read a ROS `camera_info` file.

    Raises:
        FileError: the file is missing or invalid; the error lists all findings.
    """
    return load(path, CameraInfo)
