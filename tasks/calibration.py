"""Measuring what a robot's file says of its camera and its suspension."""

from __future__ import annotations

from .domain import Domain

DOMAIN = Domain(
    "calibration",
    props="handcart.backends.scene.calibration.mark_props:MarkProps",
    primitives={
        "CALIBRATE_SUSPENSION": "handcart.primitives.calibration.calibrate_suspension:CalibrateSuspension",
        "CALIBRATE_CAMERA": "handcart.primitives.calibration.calibrate_camera:CalibrateCamera",
    },
    files={"calibration": "handcart.networks.runs.calibration:Calibration"},
)
