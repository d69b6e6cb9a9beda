"""`handcart make-library`: a library's world, and the robot's prior knowledge of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def make_library(
    out: Annotated[Path, typer.Option(help="folder to write into")],
    seed: Annotated[int, typer.Option(help="of everything that chance decides")] = 0,
    misplaced: Annotated[bool, typer.Option(help="put one book on each shelf in the wrong place")] = True,
    gap: Annotated[bool, typer.Option(help="the slot of the book to return is there")] = True,
    tag: Annotated[str, typer.Option(help="readable, smeared or unknown")] = "readable",
    blocked: Annotated[str, typer.Option(help="none, way_around or closed")] = "none",
    books: Annotated[int, typer.Option(help="to return, each to another shelf")] = 1,
    unfriendly: Annotated[
        list[str] | None, typer.Option(help="difficulties: all, or covers, light, glare, objects ...")
    ] = None,
    level: Annotated[float, typer.Option(min=0.0, max=1.0, help="how hard, from 0 to 1")] = 1.0,
) -> None:
    """Write world.yaml, places.yaml, catalogue.yaml, map.yaml and map.png of a generated library."""
    from handcart.evaluation.books import library_generator
    from handcart.evaluation.books.library_files import write_library
    from handcart.tools.terminal.writing import check_folder

    check_folder(out)
    library = library_generator.make_library(
        seed,
        misplaced,
        gap,
        tag,  # type: ignore[arg-type]
        blocked,  # type: ignore[arg-type]
        books,
        tuple(unfriendly or ()),
        level,
    )
    write_library(library, out)
    calls = ", ".join(book.call for book in library.wanted)
    print(f"a library of {len(library.rows)} shelves is in {out}; to return: {calls}")
