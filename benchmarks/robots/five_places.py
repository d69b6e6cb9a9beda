"""A room with five places to drive to, for foreign robots."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

CELL_M = 0.05
SIZE_M = (9.0, 8.0)
WALL_BOXES_M = (
    (3.6, 0.0, 3.7, 2.6),
    (5.6, 5.4, 5.7, 8.0),
    (0.0, 5.0, 1.2, 5.1),
    (7.8, 3.0, 9.0, 3.1),
    (2.0, 7.2, 2.6, 8.0),
)
"""Walls on the map: least x and y, largest x and y, in [m]."""
START_POSE = (1.5, 1.5, 0.0)
PLACE_POSES = {
    "behind_the_wall": (5.2, 1.4, 0.0),
    "corner": (7.5, 1.5, 90.0),
    "middle": (4.5, 4.2, 180.0),
    "far_side": (7.4, 6.6, -90.0),
    "alcove": (1.4, 6.3, 0.0),
}
"""x and y in [m], heading in [deg]."""


def write_room(folder: Path) -> dict[str, str]:
    """Write map and places; return the settings of `tasks/drive_map` for them."""
    columns, rows = (round(size / CELL_M) for size in SIZE_M)
    picture = np.full((rows, columns), 254, np.uint8)
    picture[:2], picture[-2:], picture[:, :2], picture[:, -2:] = 0, 0, 0, 0
    for x0, y0, x1, y1 in WALL_BOXES_M:
        c0, r0, c1, r1 = (round(item / CELL_M) for item in (x0, y0, x1, y1))
        picture[r0:r1, c0:c1] = 0
    cv2.imwrite(str(folder / "map.png"), picture[::-1])
    (folder / "map.yaml").write_text(
        f"image: map.png\nresolution: {CELL_M}\norigin: [0.0, 0.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        encoding="utf-8",
    )
    poses = {"home": START_POSE, **PLACE_POSES}
    lines = [f"  {n}: {{x_m: {x}, y_m: {y}, heading_deg: {h}}}\n" for n, (x, y, h) in poses.items()]
    (folder / "places.yaml").write_text(
        "format: handcart-places/1\nplaces:\n" + "".join(lines), encoding="utf-8"
    )
    named = {key: str(folder / f"{key}.yaml") for key in ("map", "places")}
    return {**named, "world": named["map"], "start": "home", "tour": f"[{', '.join(PLACE_POSES)}]"}
