"""Calibration values that a run found for the robot, as a file to review.

The file is `calibration.yaml` in the run's folder.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.files.whole_file import write_whole
from handcart.primitives.outcomes.calibrated import Calibrated

CALIBRATION_FILE = "calibration.yaml"
_DIGITS = 3  # of a standard deviation: rounding then adds nothing to it
_HEAD = """\
# What a run found of the robot. `handcart adopt` shows what that changes in the robot's file, and writes it.
"""

NotNegative = Annotated[float, Field(ge=0.0)]


class Value(FileModel):
    """Calibrated value of a key in the robot's file, with its standard deviation, in the key's unit."""

    value: float | tuple[float, ...]
    sigma: NotNegative | tuple[NotNegative, ...]
    """Standard deviation of the value; for a list, one for each number."""

    @model_validator(mode="after")
    def _alike(self) -> Self:
        if _length(self.value) != _length(self.sigma):
            raise ValueError("value and sigma aren't alike; allowed: two numbers, or two lists of one length")
        return self


class Calibration(FileModel):
    """Calibration values that a run found for the robot."""

    format: Literal["handcart-calibration/1"]
    robot: str
    """A shipped robot's name, or the path of a robot's file."""
    backend: str
    """Backend of the run: values found in a simulation hold for the simulation only."""
    found: Annotated[dict[str, Value], Field(min_length=1)]
    """Values by key in the robot's file: `camera.calibrated.focal_px`."""

    def text(self) -> str:
        """Return the calibration values as text of a calibration file, in YAML."""
        from ruamel.yaml import YAML

        yaml = YAML()
        yaml.default_flow_style = None
        yaml.width = 200
        out = StringIO()
        yaml.dump(self.model_dump(mode="json"), out)
        return _HEAD + out.getvalue()


def rounded(found: Mapping[str, Calibrated]) -> dict[str, Value]:
    """Return the calibrated values, rounded to the digits that their standard deviations allow."""
    result = {}
    for key, calibrated in found.items():
        values, sigmas = _tuple(calibrated.value), _tuple(calibrated.sigma)
        places = [_places(sigma) for sigma in sigmas]
        value = tuple(round(number, place) for number, place in zip(values, places, strict=True))
        sigma = tuple(round(number, place) for number, place in zip(sigmas, places, strict=True))
        single = isinstance(calibrated.value, float)
        result[key] = Value(value=value[0] if single else value, sigma=sigma[0] if single else sigma)
    return result


def _places(sigma: float) -> int:
    """Return the decimal places of a number with a standard deviation."""
    if sigma <= 0.0 or not math.isfinite(sigma):
        return 6
    return max(0, _DIGITS - 1 - math.floor(math.log10(sigma)))


def _tuple(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def _length(value: float | tuple[float, ...]) -> int:
    return len(value) if isinstance(value, tuple) else 0


def calibration_path(run: Path) -> Path:
    """Return the path of the calibration file in a run's folder; any other path is returned unchanged."""
    return run / CALIBRATION_FILE if run.is_dir() else run


def keep_calibrated(run: Path, robot: str, backend: str, calibrated: Mapping[str, Calibrated]) -> None:
    """Add values that an action calibrated to a run's `calibration.yaml`; they replace earlier ones.

    Args:
        run: the run's folder.
        robot: name of a shipped robot, or path of the robot's file.
        backend: name of the run's backend.
        calibrated: calibrated values by key in the robot's file.
    """
    path = run / CALIBRATION_FILE
    before = dict(load(path, Calibration).found) if path.exists() else {}
    by_path = robot.endswith((".yaml", ".yml"))
    whole = Calibration(
        format="handcart-calibration/1",
        robot=str(Path(robot).resolve()) if by_path else robot,
        backend=backend,
        found=before | rounded(calibrated),
    )
    write_whole(path, whole.text())
