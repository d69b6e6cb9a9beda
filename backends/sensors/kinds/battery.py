"""Batteries."""

from __future__ import annotations

from handcart.backends.sensors.sensor_kind import SensorKind

KIND = SensorKind(
    "battery",
    spec="handcart.backends.sensors.battery_spec:BatterySpec",
    capability="handcart.backends.capabilities.battery:Battery",
    simulated={"scene": "handcart.backends.simulation.sensors.simulated_battery:SimulatedBattery"},
    checks="handcart.evaluation.conformance.checks.battery_checks:CHECKS",
)
