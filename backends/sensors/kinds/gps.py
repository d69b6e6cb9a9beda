"""Satellite receivers."""

from __future__ import annotations

from handcart.backends.sensors.sensor_kind import SensorKind

KIND = SensorKind(
    "gps",
    spec="handcart.backends.description.ground_spec:GpsSpec",
    capability="handcart.backends.capabilities.gps:Gps",
    simulated={"scene": "handcart.backends.simulation.sensors.simulated_gps:SimulatedGps"},
    checks="handcart.evaluation.conformance.checks.gps_checks:CHECKS",
)
