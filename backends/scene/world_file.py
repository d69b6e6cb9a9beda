"""A world's file: what stands around the robot, seen and unseen by its map."""

from __future__ import annotations

from collections import Counter
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.backends.board_layout import BoardLayout
from handcart.backends.ground_spec import GroundSpec
from handcart.backends.map_file import MapPlace
from handcart.files.errors import InputError
from handcart.files.model import FileModel
from handcart.robotics.perception.tag_family import USUAL, TagFamily, tags_of


class MissingWorld(InputError):
    """A simulated backend was asked for without a world to simulate."""


Coordinate = Annotated[float, Field(ge=-1e7, le=1e7)]  # as on maps, which may use a grid of the Earth
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]
Length = Annotated[float, Field(gt=0.0, le=100.0)]
Millimetres = Annotated[float, Field(gt=0.0, le=1000.0)]
Seconds = Annotated[float, Field(ge=0.0)]
Name = Annotated[str, Field(min_length=1, max_length=60)]


class Place(FileModel):
    """A pose on the floor."""

    x_m: Coordinate
    y_m: Coordinate
    heading_deg: Degrees = 0.0


class Wall(FileModel):
    """A straight wall about the line between two points, 2 m high."""

    from_m: tuple[Coordinate, Coordinate]
    to_m: tuple[Coordinate, Coordinate]
    thickness_m: Length = 0.1

    @model_validator(mode="after")
    def _has_length(self) -> Self:
        if self.from_m == self.to_m:
            raise ValueError("the wall has no length; allowed: two different points")
        return self


class Furniture(Place):
    """A solid box, on the floor or above it; its pose is that of its middle."""

    name: Name
    size_m: tuple[Length, Length, Length]
    """Along its own x, along its own y, height."""
    above_m: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """Of its underside above the floor, for what is hung up or lies on something else."""


class Surprise(Furniture):
    """A box that no map shows; with times, somebody who comes and goes."""

    appears_s: Seconds | None = None
    """When it comes, in simulated time; it is there from the start where this is missing."""
    leaves_s: Seconds | None = None

    @model_validator(mode="after")
    def _comes_first(self) -> Self:
        if self.leaves_s is not None and self.leaves_s <= (self.appears_s or 0.0):
            raise ValueError("it leaves before it appears; allowed: leaves_s later than appears_s")
        return self


class TableSpec(Place):
    """A table: a slab on a pedestal in its middle. Its pose is that of the slab's middle on the floor."""

    name: Name
    size_m: tuple[Length, Length, Length]
    """Of the slab along its own x and y, and the height of its top."""
    slab_m: Length = 0.04
    """Its thickness."""
    foot_m: tuple[Length, Length]
    """Of the pedestal along x and y."""

    @model_validator(mode="after")
    def _stands(self) -> Self:
        if self.slab_m >= self.size_m[2]:
            raise ValueError("the slab is thicker than the table is high; allowed: a thinner one")
        return self


class MarkSpec(Place):
    """Something painted on a level surface; its pose is that of its middle."""

    kind: Literal["landmark", "square", "disc", "frame", "board"] = "landmark"
    """A landmark, what might be taken for one, or a board to calibrate cameras with."""
    height_m: Annotated[float, Field(ge=0.0, le=3.0)]
    """Of the surface."""
    size_mm: Annotated[float, Field(gt=0.0, le=500.0)] = 60.0
    """Its side; of a board, the side of one of its squares."""
    board: BoardLayout = BoardLayout()
    """A board's pattern."""


class BlockSpec(Place):
    """A block, and where a person sets it down: the middle of its foot."""

    name: Name
    on: Literal["world", "robot"] = "world"
    """Whose frame its place is in: the world's, or that of the robot's base, on its own table."""
    height_m: Annotated[float, Field(ge=0.0, le=3.0)]
    """Of its foot."""
    size_mm: tuple[Millimetres, Millimetres, Millimetres] = (25.0, 80.0, 40.0)
    """Length, width, height: along its x, y and z."""
    grey: Annotated[int, Field(ge=0, le=255)] = 190


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


class ShelfSpec(Place):
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


class OutageSpec(FileModel):
    """A time without satellites."""

    from_s: Seconds
    to_s: Seconds


class SkySpec(FileModel):
    """What befalls a satellite receiver, beside its own noise."""

    reflection_every_s: Annotated[float, Field(gt=0.0)] | None = None
    """Mean time from the end of one reflection (multipath) to the next; none where this is missing."""
    reflection_s: Annotated[float, Field(gt=0.0)] = 20.0
    """Its mean duration."""
    reflection_m: Annotated[float, Field(ge=0.0)] = 8.0
    """By which it moves the fixes, an axis: sigma."""
    outlier_percent: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    """Of single fixes that are `outlier_m` off."""
    outlier_m: Annotated[float, Field(ge=0.0)] = 5.0
    """An axis: sigma."""
    outages: tuple[OutageSpec, ...] = ()


class SensorSpec(FileModel):
    """Seismic sensors that a robot carries in its magazine, to be laid out one after the other."""

    count: Annotated[int, Field(ge=0, le=2000)]
    size_mm: tuple[Millimetres, Millimetres, Millimetres] = (60.0, 60.0, 120.0)
    """Along its x, y and z."""


class StationSpec(FileModel):
    """A total station, for evaluation only: it follows a reflector on the robot's hand."""

    x_m: Coordinate
    y_m: Coordinate
    height_m: Annotated[float, Field(gt=0.0, le=10.0)] = 1.5
    period_s: Annotated[float, Field(gt=0.0)] = 0.3
    accuracy_mm: Annotated[float, Field(ge=0.0)] = 10.0
    """Within which its readings lie, an axis: two sigma."""


class WorldFile(FileModel):
    """The surroundings of the robot, and the book on its tray."""

    format: Literal["handcart-world/1"]
    start: Place
    """Where a person puts the robot at first, within `errors.start_mm` and `start_deg` of its file."""
    map: MapPlace | None = None
    """A map in ROS format: what is occupied on it stands here as well, 2 m high."""
    walls: tuple[Wall, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    surprises: tuple[Surprise, ...] = ()
    tables: tuple[TableSpec, ...] = ()
    marks: tuple[MarkSpec, ...] = ()
    blocks: tuple[BlockSpec, ...] = ()
    shelves: tuple[ShelfSpec, ...] = ()
    tray: BookSpec | None = None
    """The book on the robot's tray."""
    ground: GroundSpec | None = None
    """Open ground, rough; left out: a level floor."""
    sky: SkySpec = SkySpec()
    sensors: SensorSpec | None = None
    """In the robot's magazine."""
    total_station: StationSpec | None = None
    handed_over: tuple[BookSpec, ...] = ()
    """Books that a person puts onto the empty tray, one after the other, when the robot is home."""

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        books = [e.accession for shelf in self.shelves for e in shelf.books if isinstance(e, BookSpec)]
        if self.tray is not None:
            books.append(self.tray.accession)
        books += [each.accession for each in self.handed_over]
        shelves = [shelf.name for shelf in self.shelves]
        blocks = [block.name for block in self.blocks]
        for what, names in (("accession", list(map(str, books))), ("shelf", shelves), ("block", blocks)):
            twice = sorted(name for name, times in Counter(names).items() if times > 1)
            if twice:
                raise ValueError(f"{what} {', '.join(twice)} is there twice; allowed: each once")
        return self
