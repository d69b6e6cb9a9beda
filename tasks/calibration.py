"""Measuring what a robot's file says of its camera and its suspension."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "calibration",
    props="handcart.backends.simulation.calibration.mark_props:MarkProps",
    primitives={
        "CALIBRATE_SUSPENSION": "handcart.primitives.calibration.calibrate_suspension:CalibrateSuspension",
        "CALIBRATE_CAMERA": "handcart.primitives.calibration.calibrate_camera:CalibrateCamera",
    },
    survey="handcart.evaluation.calibration.calibration_survey:CalibrationSurvey",
    files={"calibration": "handcart.networks.runs.calibration:Calibration"},
    rehearsals={
        _HERE / "calibrate_camera" / "task.yaml": {"views": "24"},
        _HERE / "calibrate_suspension" / "task.yaml": {"rounds": "3", "swings": "8"},
    },
)
