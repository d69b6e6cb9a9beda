"""How a book looks to Bullet's renderers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.backends.scene.book import Book
from handcart.backends.scene.renderer import spine_levels

from .box_mesh import box_mesh
from .physics import Physics

_COVER = 0.2  # of the spine's grey: no light falls between the books of a row
_STRIP = 32  # width of the plain strips beside the spine in the picture [px]
_PAGES = 60


class PrintedBook:
    """A box with a printed spine: plain from afar, its picture made when a camera first comes near."""

    def __init__(self, physics: Physics, book: Book, plain: int) -> None:
        """Make the visual shape of a book, which will be shown with the texture `plain` at first."""
        self._physics, self._book, self._plain = physics, book, plain
        self._texture: int | None = None
        self._printed: bool | None = None
        self._width = self._picture_width()
        self.visual = box_mesh(physics, book.size, [self._uvs(face) for face in range(6)])

    def _picture_width(self) -> int:
        return int(spine_levels(self._book.spec)[1][0].shape[1]) + 2 * _STRIP

    def _uvs(self, face: int) -> list[tuple[float, float]]:
        spine = (self._width - 2 * _STRIP) / self._width
        if face == 0:
            # Seen from before the spine, +y is left, and up is up; the picture's first row is the head.
            return [(0.0, 0.0), (spine, 0.0), (spine, 1.0), (0.0, 1.0)]
        strip = 0.5 if face < 4 else 1.5
        u = spine + strip * _STRIP / self._width
        return [(u, 0.25), (u, 0.25), (u, 0.75), (u, 0.75)]

    def show(self, body: int, printed: bool) -> None:
        """Let the renderer show it printed, or plain: as near or far as it is now, whoever looked before."""
        if printed == self._printed:
            return
        self._printed = printed
        if printed and self._texture is None:
            self._texture = self._physics.load_texture(self._picture())
        texture = self._texture if printed else self._plain
        p, client = self._physics.p, self._physics.client
        p.changeVisualShape(body, -1, textureUniqueId=texture, physicsClientId=client)

    def _picture(self) -> NDArray[np.uint8]:
        """The spine, then strips for cover and pages."""
        spine = spine_levels(self._book.spec)[1][0]
        cover = np.full((spine.shape[0], _STRIP), round(_COVER * self._book.spec.grey), np.uint8)
        return np.hstack((spine, cover, np.full((spine.shape[0], _STRIP), _PAGES, np.uint8)))
