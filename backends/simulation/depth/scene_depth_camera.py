"""Depth camera whose pictures are computed from the scene."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Self

import numpy as np
from typing_extensions import override

from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.backends.simulation.rendering.renderer import METAL_GREY, paint_scene
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite
from handcart.backends.simulation.world.material import Material
from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box, Cylinder
from handcart.robotics.numerics.arrays import ByteArray, IntArray

from .box_depth import BoxDepth
from .simulated_depth_camera import SimulatedDepthCamera, TrueDepth

GREY_MATERIAL = Material(METAL_GREY / 255, METAL_GREY / 255, METAL_GREY / 255)
Body = tuple[Box | Cylinder, Material]


class SceneDepthCamera(SimulatedDepthCamera):
    """Depth camera that casts rays at the scene's boxes, cylinders and a level floor.

    Its picture has the brightness that the grey camera's renderer paints. Like that renderer, it shows the
    fingers and the tray, but not the rest of arm and base, and no rough ground.
    """

    @classmethod
    @override
    def build(cls, site: SensorSite[DepthCameraSpec]) -> Self:
        return cls(site)

    @cached_property
    def _caster(self) -> BoxDepth:
        return BoxDepth(self._spec.model)

    @override
    def _draw(self, world_T_camera: Transform) -> TrueDepth:
        scene, model = self._site.scene, self._spec.model
        bodies = list(bodies_of(scene))
        depth, shown = self._caster.cast(world_T_camera, [box for box, _ in bodies])
        grey = paint_scene(scene, model.K, (model.width, model.height), world_T_camera)
        return TrueDepth(_coloured(grey, shown, [material for _, material in bodies]), depth)


def bodies_of(scene: Scene) -> Iterator[Body]:
    """Yield boxes with materials that a depth camera may see: solids now present, things, tray, fingers."""
    for solid in scene.solids:
        if solid.appears <= scene.time < solid.leaves:
            yield solid.box, solid.material
    for thing in scene.things():
        yield thing.solid(), thing.material
    if scene.arm is None:
        return
    if scene.robot.has_tray:
        tray = scene.robot.tray_shape
        middle = scene.world_T_base @ transform((*tray.middle, tray.top - tray.size[2] / 2))
        yield Box(middle, tray.size), GREY_MATERIAL
    if scene.robot.gripper is not None:
        hand, finger = scene.world_T("hand"), scene.robot.finger_shape
        for side in (-1.0, 1.0):
            place = (finger.tip - finger.length / 2, side * (scene.width + finger.thickness) / 2, 0.0)
            yield (
                Box(hand @ transform(place), (finger.length, finger.thickness, finger.height)),
                GREY_MATERIAL,
            )


def _coloured(grey: ByteArray, shown: IntArray, materials: list[Material]) -> ByteArray:
    """Return the picture (h, w, 3) in RGB, 0 to 255: the brightness of a grey picture in the hue of the
    materials.

    Args:
        grey: (h, w) brightness, 0 to 255.
        shown: (h, w) number of the body that each pixel shows, as `BoxDepth.cast` returns it.
        materials: material of each body.
    """
    hues = np.ones((len(materials) + 2, 3))  # the last two: nothing, and the floor
    for number, material in enumerate(materials):
        hues[number] = np.array(material[:3]) / max(material[:3])
    return np.rint(grey[..., None] * hues[shown]).astype(np.uint8)
