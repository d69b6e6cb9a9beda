"""World model section of doors and drawers."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from typing_extensions import override

from handcart.files.models.loading import Loaded, load_document
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import read_document
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.section import NamedFiles, Section
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.movable_areas import MovableArea
from handcart.robotics.numerics.arrays import FloatArray

from .doors_file import DoorsFile, gripper_findings

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import RobotFile
    from handcart.files.errors import Finding
    from handcart.robotics.navigation.maps.grid_map import GridMap

NOTHING_KNOWN = DoorsFile(format="handcart-doors/1", doors={})


class MeasuredHinge(NamedTuple):
    """Vertical axis of a hinged door on the map, and its distance from the handle, measured while the door
    moved.
    """

    x: float
    y: float
    sigma: float
    """Standard deviation in the worse direction, relative to the base, in [m]."""
    radius: float
    """Distance from the axis to the handle, in [m]."""
    radius_sigma: float


class DoorState(NamedTuple):
    """State in which the robot left a door or drawer, with its opening, the pose of its closed handle, and
    the measured hinge or direction of sliding.
    """

    door: str
    motion: str
    """Shape of the measured path of its handle: `hinged`, `sliding` or `undetermined`."""
    opened: float
    """Opening, in [rad] if the door is hinged, otherwise in [m]; 0 if it is closed."""
    closed: Pose2
    """Pose of the closed door's handle on the map."""
    sign: float
    """Sign (1 or -1) of the turn about z when the door opens, or of the way along x of its handle."""
    hinge: MeasuredHinge | None = None


@dataclass
class Doors(Section):
    """World model section for opening and closing doors, with the robot's knowledge of the doors."""

    FILES: ClassVar = {"doors": DoorsFile}
    LEARNED: ClassVar = ("door_states",)

    doors: DoorsFile = NOTHING_KNOWN
    """Doors and drawers."""
    door_states: tuple[DoorState, ...] = ()
    """Doors that were moved, each once."""
    listed: Loaded[DoorsFile] | None = field(default=None, repr=False, compare=False)
    """The file with the lines of its values."""

    @override
    @classmethod
    def load(cls, files: NamedFiles) -> Self:
        listed = files.read("doors", lambda path: load_document(read_document(path), DoorsFile))
        return cls() if listed is None else cls(listed.value, listed=listed)

    @override
    def faults(self, robot: RobotFile) -> Iterator[Finding]:
        """Yield a finding for each handle that does not fit between the robot's fingers."""
        if self.listed is not None and robot.gripper is not None:
            yield from gripper_findings(self.listed.document, self.doors, robot.gripper.opening_mm)

    @override
    def names(self) -> Mapping[str, Collection[object]]:
        return {} if self.listed is None else {"doors": self.doors.doors}

    @override
    def fit(self, robot: RobotFile, grid: GridMap, places: Mapping[str, Place]) -> Iterator[Finding]:
        if self.listed is None:
            return
        for name, door in self.doors.doors.items():
            if door.place not in places:
                words = f"unknown place {door.place!r}{suggest(door.place, places)}"
                yield self.listed.finding(("doors", name, "place"), words)

    @override
    def movable_areas(self) -> Iterator[MovableArea]:
        return (door.movable_area() for door in self.doors.doors.values())

    def swept_areas(self) -> list[FloatArray]:
        """Return outlines (n, 2) on the map, in [m], of the areas that the doors sweep.

        An obstacle that the map shows there may be the door itself, at its opening when the map was made.
        """
        return [door.movable_area().outline for door in self.doors.doors.values()]

    def state_of(self, name: str) -> DoorState | None:
        """Return the state in which the robot left a door; None if it has not moved the door."""
        return next((state for state in self.door_states if state.door == name), None)

    def note(self, state: DoorState) -> None:
        """Store the state in which the robot left a door, in place of an earlier state of the same door."""
        others = (door_state for door_state in self.door_states if door_state.door != state.door)
        self.door_states = (*others, state)

    @override
    def noted(self) -> dict[str, Any]:
        return {
            "door_states": [
                [
                    *state[:3],
                    list(state.closed),
                    state.sign,
                    None if state.hinge is None else list(state.hinge),
                ]
                for state in self.door_states
            ]
        }
