"""Mark on a level surface: a landmark, a decoy, a calibration board."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from handcart.backends.description.things.board_layout import BoardLayout
from handcart.backends.simulation.world.sheet import Sheet
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.landmarks.landmark import INK, PAPER, draw_landmark

from .spec import MarkSpec

PAPER_MARGIN_M = 0.01  # of paper around the painted part [m]
M_PER_PX = 1.25e-4


class Mark(Sheet):
    """Sheet of paper with a landmark, a picture that resembles a landmark, or a calibration board."""

    def __init__(self, spec: MarkSpec) -> None:
        pose = Pose2(spec.x_m, spec.y_m, math.radians(spec.heading_deg)).lift(spec.height_m)
        super().__init__(pose, _levels(spec.kind, spec.size_mm, spec.board))


@lru_cache(maxsize=64)
def _levels(kind: str, size_mm: float, board: BoardLayout) -> list[tuple[ByteArray, float]]:
    picture = (
        draw_landmark(size_mm / 1e3, PAPER_MARGIN_M, M_PER_PX)
        if kind == "landmark"
        else _other(kind, size_mm, board)
    )
    picture = _smooth(picture)
    half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA).astype(np.uint8)
    quarter = cv2.resize(half, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA).astype(np.uint8)
    levels = [(picture, M_PER_PX), (half, 2 * M_PER_PX), (quarter, 4 * M_PER_PX)]
    return [levels[0], *((_smooth(item), metres) for item, metres in levels[1:])]


def _smooth(picture: ByteArray) -> ByteArray:
    """Return a grey picture (h, w) with edges a pixel wide, so that sampling between pixels doesn't displace
    them.
    """
    return cv2.GaussianBlur(picture, (0, 0), 1.0).astype(np.uint8, copy=False)


def _other(kind: str, size_mm: float, board: BoardLayout) -> ByteArray:
    """Return the grey picture (h, w) of a calibration board, a full square, a disc, or a square's outline."""
    margin = round(PAPER_MARGIN_M / M_PER_PX)
    if kind == "board":
        return np.pad(board.board(size_mm).draw(M_PER_PX), margin, constant_values=PAPER)
    side = round(size_mm / 1e3 / M_PER_PX)
    ink: ByteArray = np.full((side, side), INK, dtype=np.uint8)
    if kind == "disc":
        ink[:] = PAPER
        cv2.circle(ink, (side // 2, side // 2), side // 2, (INK,), cv2.FILLED)
    elif kind == "frame":
        eighth = side // 8
        ink[eighth:-eighth, eighth:-eighth] = PAPER
    return np.pad(ink, margin, constant_values=PAPER)
