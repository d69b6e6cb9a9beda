"""A world's file: the robot's surroundings, on its map or not."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.backends.description.beacons_spec import BeaconPlace
from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.simulation.passers.passer_spec import PasserSpec
from handcart.files.errors import InputError
from handcart.files.maps.map_file import MapPlace
from handcart.files.models.model import FileModel
from handcart.robotics.geometry.pose2 import Pose2, wrap


class MissingWorld(InputError):
    """Error of a caller who starts a simulated backend without a world to simulate."""


Coordinate = Annotated[float, Field(ge=-1e7, le=1e7)]  # as on maps, which may use a grid of the Earth
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]
Length = Annotated[float, Field(gt=0.0, le=100.0)]
Millimetres = Annotated[float, Field(gt=0.0, le=1000.0)]
Seconds = Annotated[float, Field(ge=0.0)]
Name = Annotated[str, Field(min_length=1, max_length=60)]


class FloorPose(FileModel):
    """Base class of world-file entries that have a pose on the floor, in the world frame."""

    x_m: Coordinate
    y_m: Coordinate
    heading_deg: Degrees = 0.0


def floor_pose(pose: Pose2) -> FloorPose:
    """Convert a 2D pose world_T_base to the keys `x_m`, `y_m`, `heading_deg` of a world's file."""
    return FloorPose(x_m=pose.x, y_m=pose.y, heading_deg=math.degrees(wrap(pose.theta)))


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


class Furniture(FloorPose):
    """Piece of furniture in a simulated world, a solid box on the floor or above it.

    Its pose is that of its middle.
    """

    name: Name
    size_m: tuple[Length, Length, Length]
    """Size along its own x and y, and its height."""
    above_m: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """Height of its underside above the floor, if the piece hangs or lies on another one."""


class Surprise(Furniture):
    """Box-shaped obstacle that no map shows.

    It may appear and disappear at given times, as a person who comes and goes.
    """

    appears_s: Seconds | None = None
    """Simulated time at which it appears (default: present from the start)."""
    leaves_s: Seconds | None = None

    @model_validator(mode="after")
    def _comes_first(self) -> Self:
        if self.leaves_s is not None and self.leaves_s <= (self.appears_s or 0.0):
            raise ValueError("it leaves before it appears; allowed: leaves_s later than appears_s")
        return self


class TableSpec(FloorPose):
    """A table, made of a slab on a pedestal; its pose is that of the point on the floor below the slab's
    middle.
    """

    name: Name
    size_m: tuple[Length, Length, Length]
    """Size of the slab along its own x and y, and the height of its top."""
    slab_m: Length = 0.04
    """Thickness of the slab."""
    foot_m: tuple[Length, Length]
    """Size of the pedestal along x and y."""

    @model_validator(mode="after")
    def _stands(self) -> Self:
        if self.slab_m >= self.size_m[2]:
            raise ValueError("the slab is thicker than the table is high; allowed: a thinner one")
        return self


class OutageSpec(FileModel):
    """Interval of simulated time in which the satellite receiver has no fix."""

    from_s: Seconds
    to_s: Seconds

    @model_validator(mode="after")
    def _begins_first(self) -> Self:
        if self.to_s <= self.from_s:
            raise ValueError("the outage ends before it begins; allowed: to_s later than from_s")
        return self


class SkySpec(FileModel):
    """Disturbances of a simulated satellite receiver (reflections, outliers, outages), besides its noise."""

    reflection_every_s: Annotated[float, Field(gt=0.0)] | None = None
    """Mean time from the end of one reflection (multipath) to the next (default: no reflections)."""
    reflection_s: Annotated[float, Field(gt=0.0)] = 20.0
    """Mean duration of a reflection."""
    reflection_m: Annotated[float, Field(ge=0.0)] = 8.0
    """Standard deviation, on each axis, of the offset that a reflection adds to fixes."""
    outlier_percent: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    """Share of single fixes that are outliers."""
    outlier_m: Annotated[float, Field(ge=0.0)] = 5.0
    """Standard deviation, on each axis, of an outlier's offset."""
    outages: tuple[OutageSpec, ...] = ()


class BeaconsThere(FileModel):
    """True errors of the radio beacons in a simulated world: beacons that were moved away from the positions
    in the robot's file, and drifting biases of the ranges.

    The robot does not know them, because the robot's file does not contain them.
    """

    places_m: dict[str, BeaconPlace] = Field(default_factory=dict)
    """True positions of beacons that were moved, by name."""
    moved_at_s: Seconds = 0.0
    """Simulated time at which they are moved."""
    bias_walk_m_rt_s: Annotated[float, Field(ge=0.0)] = 0.0
    """Random walk of each bias: standard deviation after one second; it grows with the square root of
    time.
    """


class KidnapSpec(FileModel):
    """Time and pose at which a person lifts the robot and sets it down elsewhere, without turning wheels."""

    at_s: Annotated[float, Field(gt=0.0)]
    """Simulated time at which it happens, pauses counted."""
    to: FloorPose
    """Pose at which the robot is set down."""


class WorldFile(FileModel):
    """Content of a world's file (the robot's simulated surroundings), without keys of application domains.

    `handcart.backends.simulation.world_files.world_model` adds the keys of application domains.
    """

    format: Literal["handcart-world/1"]
    start: FloorPose
    """Initial pose of the robot, reached by a person within `errors.start_mm` and `start_deg` of its file."""
    misplaced: bool = False
    """True to put the robot far from the start that the task states, so that it has to localize itself."""
    kidnap: KidnapSpec | None = None
    """Instant at which the robot is lifted, and where it is set down (default: never)."""
    map: MapPlace | None = None
    """A map in ROS format; its occupied cells become solids 2 m high."""
    walls: tuple[Wall, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    surprises: tuple[Surprise, ...] = ()
    passers: tuple[PasserSpec, ...] = ()
    """People and carts that walk along waypoints; no map shows them."""
    tables: tuple[TableSpec, ...] = ()
    ground: GroundSpec | None = None
    """Open, rough ground (default: a level floor)."""
    sky: SkySpec = SkySpec()
    beacons: BeaconsThere = BeaconsThere()
    camera: Literal["scene", "engine"] = "scene"
    """Renderer of the robot's camera: the scene's, common to all simulated backends, or the physics
    engine's.
    """

    @model_validator(mode="after")
    def _tells_passers_apart(self) -> Self:
        each_once("passers:", (name for passer in self.passers for name in passer.members))
        return self


def each_once(what: str, names: Iterable[str]) -> None:
    """Raise ValueError if a name occurs twice; for use in a pydantic validator.

    Args:
        what: kind of the named things, for the message.
        names: names to check.
    """
    twice = sorted(name for name, times in Counter(names).items() if times > 1)
    if twice:
        raise ValueError(f"{what} {', '.join(twice)} is there twice; allowed: each once")
