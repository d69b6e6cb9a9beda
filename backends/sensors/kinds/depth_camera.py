"""Depth cameras: colour and depth."""

from __future__ import annotations

from handcart.backends.sensors.sensor_kind import SensorKind

KIND = SensorKind(
    "depth_camera",
    spec="handcart.backends.sensors.depth_spec:DepthCameraSpec",
    capability="handcart.backends.capabilities.depth_camera:DepthCamera",
    simulated={
        "scene": "handcart.backends.simulation.depth.scene_depth_camera:SceneDepthCamera",
        "pybullet": "handcart.backends.pybullet.bullet_depth_camera:BulletDepthCamera",
        "mujoco": "handcart.backends.mujoco.rendering.mujoco_depth_camera:MujocoDepthCamera",
    },
    checks="handcart.evaluation.conformance.checks.depth_checks:CHECKS",
)
