"""A book as a body."""

from __future__ import annotations

import numpy as np
from typing_extensions import override

from handcart.backends.physics.engine.thing_form import Cuboid, Piece, Uvs, Wedge
from handcart.backends.physics.world.thing_body import ThingBody
from handcart.backends.simulation.books.book import SimulatedBook
from handcart.backends.simulation.books.painted_books import spine_levels
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

CHAMFER_M = 0.003  # of the leading edges of a book that is returned: covers are rounded [m]
_COVER = 0.2  # of the spine's grey: no light falls between the books of a row
_STRIP = 32  # width of the plain strips beside the spine in the picture [px]
_PAGES = 60
_LEAVES = np.array([0.93, 0.90, 0.82])
_PORTRAIT = 2  # of the spine's pictures: half as fine as the one that the camera sees
_FROM_AFAR = np.full((4, 4), 110, np.uint8)
_PRINTS = 1.5  # spines nearer than this to the camera are printed [m]


class BookBody(ThingBody):
    """Body of a book in a physics engine, a box with a printed spine.

    A book that is not on a shelf has rounded edges. The printed spine is drawn only while a camera is near. A
    book on a shelf is not simulated (it sleeps) until something touches it.
    """

    thing: SimulatedBook
    _printed = False

    def pieces(self) -> tuple[Piece, ...]:
        """Return the book's collision shapes, around its middle.

        A book on a shelf is a box. Other books are a box that ends in a blunt wedge opposite the spine,
        because their edges there are chamfered. Fingers hold the box, for which an engine finds flat
        contacts. A single convex hull would often have one contact point, about which a gripped book would
        turn.
        """
        depth, thickness, height = self.thing.size
        if self.thing.shelf is not None:
            return super().pieces()
        core = Cuboid((depth - CHAMFER_M, thickness, height), -CHAMFER_M / 2)
        return core, Wedge(depth / 2 - CHAMFER_M, depth / 2, thickness, height, CHAMFER_M)

    @override
    def uvs(self) -> tuple[Uvs, ...]:
        width = int(spine_levels(self.thing.spec)[1][0].shape[1]) + 2 * _STRIP
        return tuple(_uvs(face, width) for face in range(6))

    @override
    def first_picture(self) -> ByteArray:
        return _FROM_AFAR

    @override
    def printed(self) -> ByteArray:
        return _picture(self.thing)

    def portrait(self) -> ByteArray:
        """Return the colour picture (h, w, 3) in RGB of a book's faces.

        The spine is on the left; on its right are a strip in the cover's colour and one in the pages' colour.
        """
        spine = spine_levels(self.thing.spec)[_PORTRAIT][0].astype(np.float64)[..., None]
        grey, cloth = max(1, self.thing.spec.grey), np.array(self.thing.material[:3])
        # Pixels as dark as the cloth or darker are ink, lighter ones are paper.
        ink, paper = np.minimum(spine / grey, 1.0), np.clip((spine - grey) / (255.0 - grey), 0.0, 1.0)
        shown = 255.0 * ((1.0 - paper) * ink * cloth + paper)
        strips = [np.full((len(spine), _STRIP // 2, 3), 255.0) * item for item in (cloth, _LEAVES)]
        return np.hstack((shown, *strips)).astype(np.uint8)

    @override
    def asleep(self) -> bool:
        return self.thing.shelf is not None

    def look(self, eye: FloatArray) -> None:
        """Show the printed spine on the book if the camera is nearer than 1.5 m, otherwise a plain grey box.

        Args:
            eye: (3,) position of the camera in the world, in [m].
        """
        printed = self._is_near(eye)
        if printed != self._printed:
            self._printed = printed
            self.engine.show(self.id, _picture(self.thing) if printed else _FROM_AFAR)

    def _is_near(self, eye: FloatArray) -> bool:
        return bool(np.linalg.norm(self.engine.pose(self.id)[:3, 3] - eye) < _PRINTS)


def _uvs(face: int, width: int) -> list[tuple[float, float]]:
    """Return the corners (u, v), 0 to 1, of a side in the book's picture.

    Args:
        face: number of the side: -x (the spine), +x, -y, +y, +z, -z.
        width: width of the picture, in [px].
    """
    spine = (width - 2 * _STRIP) / width
    if face == 0:
        # Seen from before the spine, +y is left, and up is up; the picture's first row is the head.
        return [(0.0, 0.0), (spine, 0.0), (spine, 1.0), (0.0, 1.0)]
    strip = 0.5 if face < 4 else 1.5
    u = spine + strip * _STRIP / width
    return [(u, 0.25), (u, 0.25), (u, 0.75), (u, 0.75)]


def _picture(book: SimulatedBook) -> ByteArray:
    """Return the book's grey picture (h, w): the spine, then strips for cover and pages."""
    spine = spine_levels(book.spec)[1][0]
    cover = np.full((spine.shape[0], _STRIP), round(_COVER * book.spec.grey), np.uint8)
    return np.hstack((spine, cover, np.full((spine.shape[0], _STRIP), _PAGES, np.uint8)))
