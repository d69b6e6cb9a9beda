"""Indoor positioning systems."""

from __future__ import annotations

from handcart.backends.sensors.sensor_kind import SensorKind

KIND = SensorKind(
    "positioning",
    spec="handcart.backends.description.sensor_specs:PositioningSpec",
    capability="handcart.backends.capabilities.positioning:Positioning",
    simulated={"scene": "handcart.backends.simulation.sensors.simulated_positioning:SimulatedPositioning"},
    checks="handcart.evaluation.conformance.checks.positioning_checks:CHECKS",
)
