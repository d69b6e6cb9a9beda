"""Inertial measurement units."""

from __future__ import annotations

from handcart.backends.sensors.sensor_kind import SensorKind

KIND = SensorKind(
    "imu",
    spec="handcart.backends.description.sensor_specs:ImuSpec",
    capability="handcart.backends.capabilities.imu:Imu",
    simulated={
        "scene": "handcart.backends.simulation.sensors.field_imu:imu_for",
        "physics": "handcart.backends.physics.sensors.physics_field_imu:physics_imu_for",
    },
    checks="handcart.evaluation.conformance.checks.imu_checks:CHECKS",
)
