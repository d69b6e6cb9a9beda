"""Write a library: the files of its world, and the files for its robot."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from pydantic import Field

from handcart.backends.simulation.books.spec import TAG_ROOM_MM
from handcart.evaluation.viewing.drawing.picture_file import write_png
from handcart.files.models.model import FileModel
from handcart.files.whole_file import write_whole
from handcart.robotics.geometry.pose2 import Pose2

from .library_books import GeneratedBook, ShelfRow
from .library_generator import MAP_RESOLUTION_M, Blocked, Library, Tag, make_library, place_before
from .library_room import (
    BOARD_HEIGHT_M,
    CLEAR_WIDTH_M,
    HOME_POSE,
    OUTER_WIDTH_M,
    ROOM_FURNITURE,
    SHELF_POSES,
    STAND_OFF,
)

UNUSUAL_KEYS = ("label_mm", "label_lines", "gloss", "lean_deg")
UNLISTED_TAG = 249  # a tag's number that no catalogue of ours has


class Libraries(FileModel):
    """Generator of a library (shelves with books, and its map) for each seed of a campaign.

    The fields are arguments of `make_library`.
    """

    misplaced: bool = True
    gap: bool = True
    tag: Tag = "readable"
    blocked: Blocked = "none"
    books: int = Field(default=1, ge=1, le=len(SHELF_POSES))
    unfriendly: tuple[str, ...] = ()
    level: float = Field(default=1.0, ge=0.0, le=1.0)

    def __call__(self, seed: int, folder: Path) -> dict[str, str]:
        """Write the library of a seed into a folder; return its files by their keys in a task."""
        write_library(make_library(seed, **self.model_dump()), folder)
        return {name: f"{folder}/{name}.yaml" for name in ("world", "map", "places", "catalogue")}


def write_library(library: Library, folder: Path) -> None:
    """Write world.yaml, places.yaml, catalogue.yaml, map.yaml and map.png into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (
        ("world.yaml", _world(library)),
        ("places.yaml", _places(library)),
        ("catalogue.yaml", _catalogue(library)),
        ("map.yaml", _map_yaml(library)),
    ):
        write_whole(folder / name, text)
    picture = np.where(library.map.occupied, 0, 254).astype(np.uint8)
    write_png(folder / "map.png", picture[::-1])


def _made(library: Library, what: str) -> str:
    return f"# {what}; made by `handcart make-library --seed {library.seed}`.\n"


def _world(library: Library) -> str:
    lines = [
        _made(library, "Content of the library; the robot doesn't see this file")
        + "format: handcart-world/1",
        f"start: {_pose(HOME_POSE)}",
        "walls:",
        *(f"  - {{from_m: [{a}, {b}], to_m: [{c}, {d}]}}" for a, b, c, d in library.walls),
        "furniture:",
    ]
    lines += [
        f"  - {{name: {item.name}, x_m: {item.x}, y_m: {item.y}, "
        f"size_m: [{item.length}, {item.width}, {item.height}]}}"
        for item in ROOM_FURNITURE
    ]
    if library.surprises:
        lines.append("surprises: # missing on the map")
        lines += [
            f"  - {{name: box_{i + 1}, {_pose(surprise.pose)[1:-1]}, size_m: {list(surprise.size)}}}"
            for i, surprise in enumerate(library.surprises)
        ]
    lines.append("shelves:")
    for row, shelf in zip(library.rows, SHELF_POSES, strict=True):
        lines += [
            f"  - name: {row.shelf}",
            *_indented(_pose(shelf)),
            f"    width_m: {CLEAR_WIDTH_M}",
            *_unusual(row),
            "    books: # from left to right",
        ]
        lines += [
            f"      - {{gap_mm: {item:g}}}" if isinstance(item, float) else f"      - {_book(item)}"
            for item in row.standing
        ]
    tag = {"readable": "readable", "unknown": "readable", "smeared": "smeared"}[library.tag]
    first, *others = library.wanted
    accession = UNLISTED_TAG if library.tag == "unknown" else first.accession
    lines.append(f"tray: {_book(first, accession)[:-1]}, tag: {tag}}}")
    if others:
        lines += ["handed_over: # when the robot is home again", *(f"  - {_book(other)}" for other in others)]
    return "\n".join(lines) + "\n"


def _indented(flow: str) -> list[str]:
    return [f"    {pair}" for pair in flow[1:-1].split(", ")]


def _pose(pose: Pose2) -> str:
    heading = round(math.degrees(pose.theta), 3)
    return f"{{x_m: {round(pose.x, 4)}, y_m: {round(pose.y, 4)}, heading_deg: {heading}}}"


def _unusual(row: ShelfRow) -> list[str]:
    """Return the lines of unusual properties of a shelf."""
    lines = [f"    light: {row.light:g}"] if row.light != ShelfRow.light else []
    if row.objects:
        pairs = [", ".join(f"{key}: {value:g}" for key, value in object_.items()) for object_ in row.objects]
        lines += ["    objects:", *(f"      - {{{pair}}}" for pair in pairs)]
    return lines


def _book(book: GeneratedBook, accession: int | None = None) -> str:
    number = book.accession if accession is None else accession
    unusual = [
        f"{key}: {getattr(book, key):g}"
        for key in UNUSUAL_KEYS
        if getattr(book, key) != getattr(GeneratedBook, key)
    ]
    if book.thickness_mm < TAG_ROOM_MM:
        unusual.append("tag: none")
    return (
        f'{{accession: {number}, call: "{book.call}", thickness_mm: {book.thickness_mm:g}, '
        f"height_mm: {book.height_mm}, depth_mm: {book.depth_mm}, grey: {book.grey}, font: {book.font}"
        + "".join(f", {pair}" for pair in unusual)
        + "}"
    )


def _places(library: Library) -> str:
    lines = [_made(library, "Places of the robot's base") + "format: handcart-places/1", "places:"]
    lines.append(f"  home: {_pose(HOME_POSE)}")
    for row, shelf in zip(library.rows, SHELF_POSES, strict=True):
        widths = f"width_m: {CLEAR_WIDTH_M}, board_m: {BOARD_HEIGHT_M}, front_m: {OUTER_WIDTH_M}"
        front = f"{{distance_m: {STAND_OFF}, {widths}}}"
        lines.append(f"  {row.shelf}: {_pose(place_before(shelf))[:-1]}, shelf: {front}}}")
    return "\n".join(lines) + "\n"


def _catalogue(library: Library) -> str:
    lines = [_made(library, "All books that the library owns") + "format: handcart-catalogue/1", "books:"]
    for row in library.rows:
        standing = [item for item in row.standing if isinstance(item, GeneratedBook)]
        lines += [
            f'  - {{accession: {book.accession}, call: "{book.call}", title: "Volume {book.accession}", '
            f"shelf: {book.shelf}, thickness_mm: {book.thickness_mm:g}, height_mm: {book.height_mm}, "
            f"depth_mm: {book.depth_mm}}}"
            for book in sorted([*standing, *row.lent], key=lambda item: item.accession)
        ]
    return "\n".join(lines) + "\n"


def _map_yaml(library: Library) -> str:
    return (
        _made(library, "The floor plan, in ROS format")
        + f"image: map.png\nresolution: {MAP_RESOLUTION_M}\n"
        + f"origin: [{library.map.origin_x}, {library.map.origin_y}, 0.0]\n"
        + "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
