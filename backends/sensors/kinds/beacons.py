"""Radio beacons."""

from __future__ import annotations

from handcart.backends.sensors.sensor_kind import SensorKind

KIND = SensorKind(
    "beacons",
    spec="handcart.backends.description.beacons_spec:BeaconsSpec",
    capability="handcart.backends.capabilities.beacons:Beacons",
    simulated={"scene": "handcart.backends.simulation.sensors.simulated_beacons:SimulatedBeacons"},
    checks="handcart.evaluation.conformance.checks.beacon_checks:CHECKS",
)
