"""From the engine to the scene: the ground truth that evaluation reads."""

from __future__ import annotations

import numpy as np

from handcart.backends.scene.book import Book, Rest
from handcart.backends.scene.scene import Scene
from handcart.backends.scene.shelf import DEPTH
from handcart.backends.scene.thing import Thing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse

from .block_rest import block_rest
from .robot_body import RobotBody
from .world_bodies import WorldBodies

_NEAR = 1.3  # books of shelves further from the hand than this sleep [m]
_ON = 0.03  # [m] that a book's foot may be off the board or tray
_BESIDE = 0.01  # [m] that its middle may be beside the tray
_UPRIGHT = np.radians(45.0)
_FALLEN = 0.5  # [m] above the floor


class SceneSync:
    """Writes where everything truly is into the scene, after each period."""

    def __init__(self, scene: Scene, body: RobotBody, world: WorldBodies) -> None:
        self._scene, self._body, self._world = scene, body, world
        self._tray = scene.robot.tray_shape if scene.robot.has_tray else None
        self._shelves = np.array([each.pose[:3, 3] for each in scene.shelves.values()]).reshape(-1, 3)
        """Where shelves stand, (n, 3) in [m]."""

    def base(self) -> None:
        """Where the base stands, and how it leans."""
        scene = self._scene
        scene.tilted_base = self._body.base_pose()
        standing = self._body.standing_pose()
        heading = float(np.arctan2(standing[1, 0], standing[0, 0]))
        scene.base = Pose2(float(standing[0, 3]), float(standing[1, 3]), heading)

    def things(self, held: Thing | None) -> None:
        """Where the books and blocks are that may have moved, and what carries them."""
        scene = self._scene
        world_T_hand = self._body.link_pose("hand") if "hand" in self._body.link_index else np.eye(4)
        self._books(held, world_T_hand)
        self._blocks(held)
        scene.held = held
        if held is not None:
            scene.hand_T_held = inverse(world_T_hand) @ held.pose
        tray = scene.tray_book()
        if tray is not None:
            scene.base_T_tray_book = inverse(scene.world_T_base) @ tray.pose
        scene.changes += 1

    def _books(self, held: Thing | None, world_T_hand: Transform) -> None:
        scene = self._scene
        away = np.linalg.norm(self._shelves - world_T_hand[:3, 3], axis=1)
        near = {name for name, far in zip(scene.shelves, away.tolist(), strict=True) if far < _NEAR}
        for book in scene.books.values():
            if book.rest is Rest.SHELF and book.shelf not in near:
                continue
            book.pose = self._world.pose(book)
            book.rest, book.shelf = (Rest.HAND, None) if book is held else self._rest(book)

    def _blocks(self, held: Thing | None) -> None:
        scene = self._scene
        for block in scene.blocks.values():
            if block.name not in self._world.bodies:
                continue
            block.pose = self._world.pose(block)
            if block.rest is Rest.TRAY and scene.open_ground:
                continue  # the magazine has it
            block.rest = Rest.HAND if block is held else block_rest(scene, block)
            if block.rest is Rest.TRAY:
                block.base_T_block = inverse(scene.world_T_base) @ block.pose

    def _rest(self, book: Book) -> tuple[Rest, str | None]:
        for name, shelf in self._scene.shelves.items():
            x, y, z = (shelf.inverse_pose @ book.pose)[:3, 3]
            on_board = -book.depth / 2 < x < DEPTH and abs(y) < shelf.half_width and abs(z) < _ON
            if on_board and book.tilt() < _UPRIGHT:
                return Rest.SHELF, name
        if self._on_tray(book):
            return Rest.TRAY, None
        if book.pose[2, 3] < _FALLEN or book.rest is not Rest.HAND:
            return Rest.FLOOR, None
        return book.rest, None

    def _on_tray(self, book: Book) -> bool:
        if self._tray is None:
            return False
        x, y, z = (inverse(self._scene.world_T_base) @ book.pose @ book.thing_T_middle)[:3, 3]
        from_middle = np.abs(np.array((x, y)) - self._tray.middle)
        above = z - book.height / 2 - self._tray.top
        return bool((from_middle < np.array(self._tray.size[:2]) / 2 + _BESIDE).all() and abs(above) < _ON)
