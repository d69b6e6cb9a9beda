"""What the robot knows: told beforehand, seen and learned."""

from __future__ import annotations

import typing
from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import field as dataclass_field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from handcart.backends.plain_values import attributes, set_attributes
from handcart.files.errors import HandcartError
from handcart.files.suggest import suggest
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.tool_path import ToolPath
from handcart.robotics.navigation.grid_map import GridMap
from handcart.robotics.navigation.speed_limits import SpeedLimits

from .building import Building
from .field import Field
from .knowledge import Book, Catalogue, Place
from .seam_work import SeamWork
from .target import Laid, Target
from .work_piece import WorkPiece


class Declares(Protocol):
    """Says what of the world model it reads and writes, as every primitive does."""

    reads: ClassVar[tuple[str, ...]]
    writes: ClassVar[tuple[str, ...]]

    @classmethod
    def label(cls) -> str:
        """What it is called."""
        ...


class UnknownFact(HandcartError, LookupError):
    """Something that the robot doesn't know (yet)."""


class UndeclaredAccess(HandcartError, AttributeError):
    """A primitive reads or writes an entry of the world model that it didn't declare."""


class Slot(NamedTuple):
    """Where a book belongs on its shelf, in the shelf's frame."""

    shelf: str
    """Name of the place with the shelf."""
    left: float
    """y of the left neighbour's side, in [m]."""
    right: float
    """y of the right neighbour's side, in [m]; less than `left`."""
    sigma: float
    """Of both, in [m]."""
    after: str
    """Call number of the left neighbour; empty at the end of the row."""
    before: str
    """Call number of the right neighbour."""


class Fixed(NamedTuple):
    """Where the base stands, by a landmark."""

    landmark: str
    place: str
    """At which place of the map the base should stand."""
    pose: Pose2
    """map_T_base, with the hand where it was then."""
    sigma: tuple[float, float]
    """Of its position in [m] and its heading in [rad]."""
    reach: tuple[float, float]
    """Where the hand was, in the base frame, in [m]: the base leans after it."""
    attitude: tuple[float, float, float]
    """Roll, pitch and yaw by the inertial sensors then, in [rad]."""
    travel: tuple[float, float]
    """What the wheels had rolled then, in [m]: once they roll on, this pose is over."""
    moved: float
    """Over how long the gyros' rates had been added up then, in [s]: by `Attitude.moved`."""
    swings: int = 0
    """Of the loaded arm since then."""

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(3, 3) of `pose`, of x, y in [m] and heading in [rad]."""
        return np.diag([self.sigma[0], self.sigma[0], self.sigma[1]]) ** 2


class Placed(NamedTuple):
    """A block that was put where it goes."""

    number: int
    pose: Pose2
    """On the map."""
    height: float
    """Of its foot, in [m]."""


class Detour(NamedTuple):
    """A route that was planned around what was sensed."""

    goal: str
    points: NDArray[np.float64]
    """(n, 2) on the map, in [m]."""


@dataclass
class WorldModel:
    """The robot's knowledge. What an element of a repeat learned is forgotten with `clear_element`."""

    # Told beforehand
    map: GridMap
    places: Mapping[str, Place]
    catalogue: Catalogue
    # Learned, kept for the run
    obstacles: NDArray[np.float64]
    """(n, 2) points that were sensed and are not on the map, in [m]."""
    # Learned, kept for one element
    book: Book | None = None
    """The book that is to be returned."""
    book_pose: Pose2 | None = None
    """base_T_book while it stands on the tray: middle of its spine, x along its depth."""
    slot: Slot | None = None
    detour: Detour | None = None
    speed_limits: SpeedLimits | None = None
    """How fast the base may drive where; told beforehand."""
    # For who stacks blocks
    building: Building | None = None
    """The building plan; told beforehand."""
    fixed: Fixed | None = None
    """Where the base stands by the landmark that was seen last; kept for the run."""
    placed: tuple[Placed, ...] = ()
    """The blocks that stand where they go; kept for the run."""
    # For who tracks a seam
    seam: ToolPath | None = None
    """The path of the tool, on the map; told beforehand."""
    work_piece: WorkPiece | None = None
    """What the seam is on; told beforehand."""
    seam_work: SeamWork = dataclass_field(default_factory=SeamWork)
    """How far it is tracked, and from where; kept for the run."""
    # For who works outdoors
    field: Field | None = None
    """What is known to stand there; told beforehand."""
    targets: Mapping[str, Target] = dataclass_field(default_factory=dict)
    """Where sensors go; told beforehand."""
    laid: tuple[Laid, ...] = ()
    """Sensors that were let go; kept for the run."""

    ELEMENT: typing.ClassVar = ("book", "book_pose", "slot", "detour")
    LEARNED: typing.ClassVar = {
        "places": dict[str, Place],
        "obstacles": NDArray[np.float64],
        "fixed": Fixed | None,
        "placed": tuple[Placed, ...],
        "seam_work": SeamWork,
        "laid": tuple[Laid, ...],
        "book": Book | None,
        "book_pose": Pose2 | None,
        "slot": Slot | None,
        "detour": Detour | None,
    }
    """What a checkpoint keeps, with the types."""

    def __post_init__(self) -> None:
        self._told = self._state()

    def clear_element(self) -> None:
        """Forget what belongs to one element of a repeat."""
        for name in self.ELEMENT:
            setattr(self, name, None)

    def view(self, primitive: Declares) -> ModelView:
        """The model as this primitive may use it."""
        return ModelView(self, primitive)

    def lookup(self, path: str) -> Any:
        """A value for a late-bound parameter, such as `book.shelf`.

        Raises:
            UnknownFact: it isn't known yet.
        """
        value: Any = self
        for name in path.split("."):
            value = getattr(value, name, None)
            if value is None:
                raise UnknownFact(f"{path} is not known yet")
        return value

    @classmethod
    def type_of(cls, path: str) -> Any:
        """The type that `lookup` will give.

        Raises:
            UnknownFact: there is no such entry; the message lists what there is.
        """
        kind: Any = cls
        for name in path.split("."):
            known = {key: value for key, value in typing.get_type_hints(kind).items() if key.islower()}
            if name not in known:
                raise UnknownFact(f"the world model has no {path!r}{suggest(name, known)}")
            kind = known[name]
            options = [each for each in typing.get_args(kind) if each is not type(None)]
            kind = options[0] if type(None) in typing.get_args(kind) else kind
        return kind

    def state(self) -> dict[str, Any]:
        """What was learned so far, for a checkpoint, as plain data."""
        return attributes(self, self.LEARNED)

    def set_state(self, state: object) -> None:
        """Take over what `state` gave.

        Raises:
            NotAState: it is something else.
        """
        set_attributes(self, self.LEARNED, state)
        self._told = self._state()

    def taken_changes(self) -> dict[str, Any]:
        """What was learned or forgotten since the last call, ready for JSON."""
        now = self._state()
        changes = {name: value for name, value in now.items() if value != self._told[name]}
        self._told = now
        return changes

    def _state(self) -> dict[str, Any]:
        return {
            "obstacles": len(self.obstacles),
            "book": self.book.accession if self.book else None,
            "book_pose": list(self.book_pose) if self.book_pose else None,
            "slot": list(self.slot) if self.slot else None,
            "detour": self.detour.points.round(4).tolist() if self.detour else None,
            "fixed": list(self.fixed) if self.fixed else None,
            "placed": [list(each) for each in self.placed],
            "seam_tracked": self.seam_work.tracked,
            "seam_rest": [list(each) for each in self.seam_work.rest],
            "sensors_laid": len(self.laid),
            "last_laid": list(self.laid[-1]) if self.laid else None,
        }


class ModelView:
    """The world model through one primitive's eyes: what it didn't declare it can neither read nor write."""

    if TYPE_CHECKING:
        map: GridMap
        places: Mapping[str, Place]
        catalogue: Catalogue
        obstacles: NDArray[np.float64]
        book: Book | None
        book_pose: Pose2 | None
        slot: Slot | None
        detour: Detour | None
        speed_limits: SpeedLimits | None
        building: Building | None
        fixed: Fixed | None
        placed: tuple[Placed, ...]
        seam: ToolPath | None
        work_piece: WorkPiece | None
        seam_work: SeamWork
        field: Field | None
        targets: Mapping[str, Target]
        laid: tuple[Laid, ...]

    def __init__(self, model: WorldModel, primitive: Declares) -> None:
        object.__setattr__(self, "_model", model)
        object.__setattr__(self, "_primitive", primitive)

    def __getattr__(self, name: str) -> Any:
        primitive = self.__dict__["_primitive"]
        if name not in primitive.reads + primitive.writes:
            raise UndeclaredAccess(f"{primitive.label()} reads {name!r} without declaring it in `reads`")
        return getattr(self.__dict__["_model"], name)

    def __setattr__(self, name: str, value: Any) -> None:
        primitive = self.__dict__["_primitive"]
        if name not in primitive.writes:
            raise UndeclaredAccess(f"{primitive.label()} writes {name!r} without declaring it in `writes`")
        setattr(self.__dict__["_model"], name, value)
