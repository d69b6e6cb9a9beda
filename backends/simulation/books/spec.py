"""Books and shelves in a world's file."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.backends.simulation.world.world_file import FloorPose, Name, each_once
from handcart.files.models.model import FileModel
from handcart.robotics.perception.landmarks.tag_family import DEFAULT_FAMILY, TagFamily, tags_of

TAG_ROOM_MM = 14.0  # a tag of 10 mm and its white margins


class BookSpec(FileModel):
    """Description of a book in a world's file, with its dimensions, and the tag and label on its spine."""

    accession: Annotated[int, Field(ge=0)]
    """Number that its tag encodes."""
    call: Annotated[str, Field(min_length=3, max_length=16)]
    """Call number on the label, "512.7 NAG"."""
    title: str = ""
    thickness_mm: Annotated[float, Field(ge=6.0, le=80.0)]
    height_mm: Annotated[float, Field(ge=170.0, le=260.0)]
    depth_mm: Annotated[float, Field(ge=100.0, le=200.0)]
    grey: Annotated[int, Field(ge=0, le=255)] = 120
    font: str = "DejaVuSans"
    """A TTF of matplotlib's, without its ending."""
    label_mm: Annotated[float, Field(ge=6.0, le=25.0)] = 10.0
    """Width of the label, across the spine."""
    label_lines: Literal[1, 2] = 1
    """Number of lines; with two, the letters are below the number."""
    gloss: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """Share of a lamp's light that the spine mirrors: 1 outshines paper."""
    lean_deg: Annotated[float, Field(ge=-40.0, le=40.0)] = 0.0
    """Lean on a shelf, to the left, about the lower edge of that side; the list must leave it room."""
    tag: Literal["readable", "smeared", "none"] = "readable"
    tags: TagFamily = DEFAULT_FAMILY
    """Family of its tag."""

    @model_validator(mode="after")
    def _prints_fit(self) -> Self:
        if self.label_mm > self.thickness_mm:
            raise ValueError(
                f"a label of {self.label_mm:g} mm; allowed: at most the spine's {self.thickness_mm:g}"
            )
        if self.tag != "none" and self.thickness_mm < TAG_ROOM_MM:
            raise ValueError(
                f"a tag needs a spine of {TAG_ROOM_MM:g} mm; allowed on {self.thickness_mm:g} mm: tag: none"
            )
        return self

    @model_validator(mode="after")
    def _tag_is_there(self) -> Self:
        if self.accession >= tags_of(self.tags):
            allowed = f"allowed: below {tags_of(self.tags)}"
            raise ValueError(f"the family {self.tags} has no tag {self.accession}; {allowed}")
        return self


class ObjectSpec(FileModel):
    """Immovable object on a shelf's board, a box in front of, in or behind the row of books."""

    at_mm: Annotated[float, Field(ge=0.0, le=3000.0)]
    """Distance of its left side from the left panel."""
    width_mm: Annotated[float, Field(gt=0.0, le=500.0)]
    height_mm: Annotated[float, Field(gt=0.0, le=330.0)]
    front_mm: Annotated[float, Field(ge=-100.0, le=230.0)] = 0.0
    """Distance of its front behind the board's front edge."""
    depth_mm: Annotated[float, Field(gt=0.0, le=250.0)] = 20.0
    grey: Annotated[int, Field(ge=0, le=255)] = 120


class GapSpec(FileModel):
    """Free slot in a row of books, given by its width in a world's file."""

    gap_mm: Annotated[float, Field(gt=0.0, le=1000.0)]


class ShelfSpec(FloorPose):
    """Row of books on a board, with the 2D pose of the shelf frame S.

    The frame's origin is the middle of the board's front edge; its x axis points into the shelf.
    """

    name: Name
    width_m: Annotated[float, Field(ge=0.1, le=3.0)] = 1.0
    """Width between the side panels."""
    books: tuple[BookSpec | GapSpec, ...] = ()
    """Books and gaps from left (+y) to right; a book end fills the rest on the right."""
    objects: tuple[ObjectSpec, ...] = ()
    light: Annotated[float, Field(ge=0.0, le=1.0)] = 0.1
    """Share of the room's light that is left deep inside: 1 with lamps of its own."""
    board_m: Annotated[float, Field(ge=0.1, le=2.0)] = 0.70
    """Height of the board above the floor."""
    closed_from_m: Annotated[float, Field(ge=0.0, le=2.0)] = 0.0
    """Height from which the front is closed below the board: higher for a shelf above another one."""

    @model_validator(mode="after")
    def _books_fit(self) -> Self:
        used = sum(e.gap_mm if isinstance(e, GapSpec) else e.thickness_mm for e in self.books)
        if used > self.width_m * 1e3 + 1e-6:
            raise ValueError(f"books and gaps take {used:.1f} mm; allowed: at most {self.width_m * 1e3:.1f}")
        return self


class BooksSection(FileModel):
    """Section of a world's file with shelves, the book on the robot's tray, and books that a person hands
    over.
    """

    shelves: tuple[ShelfSpec, ...] = ()
    tray: BookSpec | None = None
    """The book on the robot's tray."""
    handed_over: tuple[BookSpec, ...] = ()
    """Books that a person puts onto the empty tray, one after the other, when the robot is home."""

    @model_validator(mode="after")
    def _each_book_and_shelf_once(self) -> Self:
        books = [e.accession for shelf in self.shelves for e in shelf.books if isinstance(e, BookSpec)]
        if self.tray is not None:
            books.append(self.tray.accession)
        books += [spec.accession for spec in self.handed_over]
        each_once("accession", map(str, books))
        each_once("shelf", (shelf.name for shelf in self.shelves))
        return self
