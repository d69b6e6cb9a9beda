"""Grey cameras."""

from __future__ import annotations

from handcart.backends.sensors.sensor_kind import SensorKind

KIND = SensorKind(
    "camera",
    spec="handcart.backends.description.sensor_specs:CameraSpec",
    capability="handcart.backends.capabilities.camera:Camera",
    simulated={
        "scene": "handcart.backends.simulation.sensors.simulated_camera:SceneCamera",
        "pybullet": "handcart.backends.pybullet.bullet_camera:BulletCamera",
        "mujoco": "handcart.backends.mujoco.rendering.mujoco_camera:MujocoCamera",
    },
)
