"""Generated libraries: sound whatever the seed."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from handcart.backends.simulation.world_files.world_model import world_model
from handcart.evaluation.books.library_books import GeneratedBook
from handcart.evaluation.books.library_files import write_library
from handcart.evaluation.books.library_generator import NoSuchLibrary, make_library
from handcart.files.models.loading import load
from handcart.primitives.books.catalogue import Catalogue
from handcart.primitives.knowledge.place import Places, load_map


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_every_library_has_a_slot_for_the_book(seed: int) -> None:
    library = make_library(seed)
    books = [item for row in library.rows for item in row.standing if isinstance(item, GeneratedBook)]
    assert len(books) >= 60
    assert len({book.accession for book in books} | {library.wanted[0].accession}) == len(books) + 1
    row = next(item for item in library.rows if item.shelf == library.wanted[0].shelf)
    gaps = [item for item in row.standing if isinstance(item, float)]
    play = gaps[row.lent.index(library.wanted[0])] - library.wanted[0].thickness_mm
    assert 0.0 < play <= 8.0


def test_its_files_are_right(tmp_path: Path) -> None:
    write_library(make_library(3, blocked="way_around"), tmp_path)
    world: Any = load(tmp_path / "world.yaml", world_model())
    assert len(world.shelves) >= 3
    assert len(world.surprises) == 1
    assert "shelf_1" in load(tmp_path / "places.yaml", Places).places
    assert world.tray is not None
    assert world.tray.accession in load(tmp_path / "catalogue.yaml", Catalogue).by_accession
    grid, warning = load_map(tmp_path / "map.yaml")
    assert warning is None
    assert grid.occupied.any()


def test_the_same_seed_gives_the_same_library(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_library(make_library(9), tmp_path / name)
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10_000), level=st.floats(0.0, 1.0))
def test_unfriendly_libraries_are_sound(seed: int, level: float) -> None:
    library = make_library(seed, unfriendly=("all",), level=level)
    wanted = library.wanted[0]
    row = next(item for item in library.rows if item.shelf == wanted.shelf)
    assert wanted in row.lent
    if wanted.accession not in library.no_slot:
        gaps = [item for item in row.standing if isinstance(item, float) and item >= 10.0]
        assert gaps[row.lent.index(wanted)] >= wanted.thickness_mm + 3.0
    with tempfile.TemporaryDirectory() as folder:
        write_library(library, Path(folder))
        world: Any = load(Path(folder) / "world.yaml", world_model())
    assert all(len(shelf.books) >= 8 for shelf in world.shelves)


def test_what_makes_a_library_hard_is_said(tmp_path: Path) -> None:
    with pytest.raises(NoSuchLibrary, match="'dust'; allowed: all, covers, light"):
        make_library(0, unfriendly=("dust",))
    write_library(make_library(4, unfriendly=("light", "labels"), level=0.5), tmp_path)
    world: Any = load(tmp_path / "world.yaml", world_model())
    assert {shelf.light for shelf in world.shelves} == {0.55}
    books = [book for shelf in world.shelves for book in shelf.books if hasattr(book, "label_mm")]
    assert {book.label_lines for book in books} == {1, 2}
    assert min(book.label_mm for book in books) < 9.0


def test_an_unknown_option_is_refused() -> None:
    with pytest.raises(NoSuchLibrary, match="allowed: none, way_around, closed"):
        make_library(0, blocked="somewhere")  # type: ignore[arg-type]
