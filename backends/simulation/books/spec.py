"""Books and shelves in a world's file."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.backends.simulation.world.world_file import FloorPose, Name, each_once
from handcart.files.models.model import FileModel
from handcart.robotics.perception.landmarks.tag_family import USUAL, TagFamily, tags_of


class BookSpec(FileModel):
    """A book: what is printed on its spine, and its measures."""

    accession: Annotated[int, Field(ge=0)]
    """The number in its tag."""
    call: Annotated[str, Field(min_length=3, max_length=16)]
    """Call number on the label, "512.7 NAG"."""
    title: str = ""
    thickness_mm: Annotated[float, Field(ge=15.0, le=45.0)]
    height_mm: Annotated[float, Field(ge=170.0, le=260.0)]
    depth_mm: Annotated[float, Field(ge=100.0, le=200.0)]
    grey: Annotated[int, Field(ge=0, le=255)] = 120
    font: str = "DejaVuSans"
    """A TTF of matplotlib's, without its ending."""
    tag: Literal["readable", "smeared", "none"] = "readable"
    tags: TagFamily = USUAL
    """The family that its tag is of."""

    @model_validator(mode="after")
    def _tag_is_there(self) -> Self:
        if self.accession >= tags_of(self.tags):
            allowed = f"allowed: below {tags_of(self.tags)}"
            raise ValueError(f"the family {self.tags} has no tag {self.accession}; {allowed}")
        return self


class GapSpec(FileModel):
    """A free slot in a row of books."""

    gap_mm: Annotated[float, Field(gt=0.0, le=1000.0)]


class ShelfSpec(FloorPose):
    """One row of books; its pose is that of frame S: middle of the board's front edge, x into the shelf."""

    name: Name
    width_m: Annotated[float, Field(ge=0.1, le=3.0)] = 1.0
    """Between the side panels."""
    books: tuple[BookSpec | GapSpec, ...] = ()
    """From left (+y) to right; a book end fills what is left on the right."""

    @model_validator(mode="after")
    def _books_fit(self) -> Self:
        used = sum(e.gap_mm if isinstance(e, GapSpec) else e.thickness_mm for e in self.books)
        if used > self.width_m * 1e3 + 1e-6:
            raise ValueError(f"books and gaps take {used:.1f} mm; allowed: at most {self.width_m * 1e3:.1f}")
        return self


class BooksSection(FileModel):
    """Keys of a world's file that are about books."""

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
        books += [each.accession for each in self.handed_over]
        each_once("accession", map(str, books))
        each_once("shelf", (shelf.name for shelf in self.shelves))
        return self
