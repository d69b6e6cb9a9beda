"""The books of a library."""

from __future__ import annotations

from collections import Counter
from functools import cached_property
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.files.models.model import FileModel
from handcart.robotics.perception.landmarks.tag_family import DEFAULT_FAMILY, TagFamily, tags_of

Positive = Annotated[float, Field(gt=0.0)]


class Book(FileModel):
    """Book in the library's catalogue, with the number of its tag, call number, title, size and shelf."""

    accession: Annotated[int, Field(ge=0)]
    """Number of its tag."""
    call: str
    """Call number, as on its label."""
    title: str
    shelf: str
    """The place where it belongs."""
    thickness_mm: Positive
    height_mm: Positive
    depth_mm: Positive


class Catalogue(FileModel):
    """All books that the library owns."""

    format: Literal["handcart-catalogue/1"]
    tags: TagFamily = DEFAULT_FAMILY
    """The family that the books' tags are of."""
    books: tuple[Book, ...]

    @model_validator(mode="after")
    def _tags_are_there(self) -> Self:
        if beyond := [book.accession for book in self.books if book.accession >= tags_of(self.tags)]:
            allowed = f"allowed: below {tags_of(self.tags)}"
            raise ValueError(f"the family {self.tags} has no tag {', '.join(map(str, beyond))}; {allowed}")
        counts = Counter(book.accession for book in self.books)
        if twice := [number for number, count in counts.items() if count > 1]:
            several = f"several books have the tag {', '.join(map(str, twice))}"
            raise ValueError(f"{several}; allowed: a tag of its own for each")
        return self

    @cached_property
    def by_accession(self) -> dict[int, Book]:
        """Books of the catalogue, by the number that each book's tag encodes."""
        return {book.accession: book for book in self.books}


def name_of_book(book: Book) -> str:
    """Return the name of a book in the simulated world."""
    return f"book {book.accession}"
