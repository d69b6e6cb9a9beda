"""Lidars: scanning range sensors."""

from __future__ import annotations

from handcart.backends.sensors.sensor_kind import SensorKind

KIND = SensorKind(
    "lidar",
    spec="handcart.backends.description.range_spec:RangeSpec",
    capability="handcart.backends.capabilities.range_sensor:RangeSensor",
    simulated={
        "kinematic": "handcart.backends.kinematic.kinematic_parts:KinematicRangeSensor",
        "physics": "handcart.backends.physics.sensors.physics_range_sensor:PhysicsRangeSensor",
    },
)
