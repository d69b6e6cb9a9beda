"""Renderer of the hand's camera."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from handcart.backends.description.simulated_errors import Errors
from handcart.backends.simulation.world.canvas import Canvas
from handcart.backends.simulation.world.paint_order import painting_order
from handcart.backends.simulation.world.painting import Painted, paint_sheet, plain_box
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

from .lens import Lens

_BACKGROUND, _FLOOR, _WALL, _FURNITURE, METAL_GREY = 150, 95, 165, 110, 90
_AROUND = frozenset({Rest.TABLE, Rest.FLOOR})


class Renderer:
    """Renderer of the pictures that one grey camera takes of a simulated scene.

    It paints convex bodies face by face, each after those that it hides (painter's algorithm). Of the robot
    only the fingers and the tray are shown.
    """

    def __init__(self, camera: CameraModel, errors: Errors, seed: int) -> None:
        self._camera, self._errors, self._seed = camera, errors, seed

    @cached_property
    def _lens(self) -> Lens:
        return Lens(self._camera, self._errors, self._seed)

    def render(self, scene: Scene, world_T_camera: Transform, period: int) -> ByteArray:
        """Return the picture (height, width), grey, with the lens, light and noise of a period.

        Args:
            scene: true state of the world.
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            period: number of the period.
        """
        return self._lens.take(self.ideal(scene, world_T_camera), period)

    def ideal(self, scene: Scene, world_T_camera: Transform) -> ByteArray:
        """Return the grey picture (h, w) of an ideal pinhole camera, without distortion, light and noise.

        It is larger than the camera's picture, so that the lens can distort it.

        Args:
            scene: true state of the world.
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
        """
        return paint_scene(scene, self._lens.K, self._lens.size, world_T_camera)


def paint_scene(scene: Scene, K: FloatArray, size: tuple[int, int], world_T_camera: Transform) -> ByteArray:
    """Return the picture (height, width), grey, of an ideal pinhole camera.

    Args:
        scene: true state of the world.
        K: (3, 3) camera matrix, in [px]; an integer pixel is a pixel's centre.
        size: width and height in [px].
        world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
    """
    canvas = Canvas(K, size, world_T_camera, _BACKGROUND)
    x, y = canvas.eye[:2]
    floor = np.array([[-30, -30, 0], [30, -30, 0], [30, 30, 0], [-30, 30, 0]]) + np.array([x, y, 0.0])
    canvas.polygon(floor, _FLOOR)
    shown = [*_room(canvas, scene), *_sheets(scene), *_things(canvas, scene, _AROUND), *_robot(canvas, scene)]
    for number in painting_order(canvas, [item.box for item in shown]):
        shown[number].paint(canvas)
    return canvas.picture


def _room(canvas: Canvas, scene: Scene) -> Iterator[Painted]:
    """Yield walls and furniture, what is low and near last: if it reaches into a wall, it is painted over
    the wall.
    """
    there = [s for s in scene.plain_solids if s.appears <= scene.time < s.leaves]
    there.sort(key=lambda s: (s.box.size[2] < 2.0, -_away(canvas, s.box)))
    for solid in there:
        plain = _WALL if solid.box.name.startswith("wall") else _FURNITURE
        yield plain_box(solid.box, plain if solid.grey is None else solid.grey)


def _away(canvas: Canvas, box: Box) -> float:
    """Return the horizontal distance from the camera to a box, in [m]."""
    return float(np.linalg.norm(box.pose[:2, 3] - canvas.eye[:2]))


def _sheets(scene: Scene) -> Iterator[Painted]:
    return (paint_sheet(sheet) for props in scene.props.values() for sheet in props.sheets())


def _things(canvas: Canvas, scene: Scene, resting: frozenset[Rest]) -> list[Painted]:
    """Return the things with these supports, the nearest one last."""
    there = [painted for props in scene.props.values() for painted in props.painted(resting)]
    there.sort(key=lambda item: -float(np.linalg.norm(item.box.pose[:3, 3] - canvas.eye)))
    return there


def _robot(canvas: Canvas, scene: Scene) -> Iterator[Painted]:
    """Yield the tray and its load, then the hand's load and fingers."""
    if scene.arm is None:
        return
    if scene.robot.has_tray:
        tray = scene.robot.tray_shape
        middle = scene.world_T_base @ transform((*tray.middle, tray.top - tray.size[2] / 2))
        yield plain_box(Box(middle, tray.size), scene.robot.tray_grey)
    yield from _things(canvas, scene, frozenset({Rest.TRAY}))
    yield from _things(canvas, scene, frozenset({Rest.HAND}))
    if scene.robot.gripper is None:
        return
    hand, finger = scene.world_T("hand"), scene.robot.finger_shape
    for side in (-1.0, 1.0):
        middle = hand @ transform(
            (finger.tip - finger.length / 2, side * (scene.width + finger.thickness) / 2, 0.0)
        )
        yield plain_box(Box(middle, (finger.length, finger.thickness, finger.height)), METAL_GREY)
