"""Measuring what a robot's file says of its camera and its suspension."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "calibration",
    primitives={
        "CALIBRATE_SUSPENSION": "handcart.primitives.calibrate_suspension:CalibrateSuspension",
        "CALIBRATE_CAMERA": "handcart.primitives.calibrate_camera:CalibrateCamera",
    },
    survey="handcart.evaluation.calibration_survey:CalibrationSurvey",
    files={"calibration": "handcart.networks.calibration:Calibration"},
    rehearsals={
        _HERE / "calibrate_camera" / "task.yaml": {"views": "24"},
        _HERE / "calibrate_suspension" / "task.yaml": {"rounds": "3", "swings": "8"},
    },
)
