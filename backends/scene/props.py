"""What of one domain stands in a simulated world."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

import numpy as np

from handcart.backends.plain_values import Kinds
from handcart.files.model import FileModel
from handcart.robotics.geometry.transform import Transform, inverse

from .grasp import Pads, fits, hand_T_gripped, thickness
from .painting import Painted, paint_thing
from .sheet import Sheet
from .solids import Solid
from .support import put_down, rest_of
from .thing import Rest, Thing

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from handcart.backends.robot_file import RobotFile
    from handcart.files.errors import Finding
    from handcart.files.loading import Loaded
    from handcart.robotics.kinematics.arm_model import ArmModel

    from .hand_rule import HandRule
    from .scene import Scene

S = TypeVar("S", bound=FileModel)


class Props(Generic[S]):
    """Things of a domain in a scene: how they are set up, look, are gripped and let go, and what they do.

    One subclass a domain, named by `Domain.props`. All that isn't overridden is as for boxes that stand on
    tables, on the robot and on each other, and do nothing of themselves.
    """

    section: ClassVar[type[FileModel]]
    """The keys that it adds to the world's file, all of which may be left out."""
    STATE: ClassVar[Kinds] = {}
    """Attributes that a checkpoint keeps, with their types: its things, and what else changes."""
    PAINTS_SOLIDS: ClassVar[bool] = False
    """Whether `painted` has its solids as well; else the camera sees them as plain boxes."""
    BODIES: ClassVar[Mapping[str, str]] = {}
    """Import path "module:name" of what acts for it in a backend's physics, by the backend's name."""

    def __init__(self, scene: Scene, spec: S, seed: int) -> None:
        """In a scene whose robot stands at its start; `spec` has what the world's file says."""
        self.scene, self.spec, self.seed = scene, spec, seed

    # What the world's file says

    @classmethod
    def solids(cls, spec: S) -> Sequence[Solid]:
        """What nothing moves, and the robot may run into."""
        return ()

    @classmethod
    def findings(cls, loaded: Loaded[S], robot: RobotFile) -> Iterator[Finding]:
        """What is wrong between the world's file and the robot that is put into it."""
        yield from ()

    def set_up(self) -> None:
        """A person sets everything up. Draws from `keyed` with `self.seed` alone."""

    # What is there

    def things(self) -> Iterable[Thing]:
        """What hands can carry, in an order that stays."""
        return ()

    def sheets(self) -> Sequence[Sheet]:
        """What lies printed on level surfaces."""
        return ()

    def painted(self, rests: frozenset[Rest]) -> Iterable[Painted]:
        """What the camera sees of things that rest so."""
        for thing in self.things():
            if thing.rest in rests:
                yield paint_thing(thing)

    # What happens

    def taken(self, thing: Thing) -> None:
        """The hand has a thing: nothing else carries it."""
        thing.rest = Rest.HAND

    def step(self) -> None:
        """A period begins: let happen what happens of itself."""

    def hand_force(self) -> NDArray[np.float64]:
        """What it adds to the force (3,) in [N] that the hand feels, in the hand's frame."""
        return np.zeros(3)

    # In a hand without physics

    def hand_rule(self, arm: ArmModel) -> HandRule | None:
        """What decides in place of rigid geometry where the hand meets its things; asked once."""
        return None

    def thickness(self, thing: Thing, pads: Pads) -> float:
        """Of a thing between the pads, in [m]."""
        return thickness(thing, pads)

    def fits(self, thing: Thing, pads: Pads) -> bool:
        """Whether closing pads meet a thing so that they can hold it."""
        return fits(thing, pads)

    def gripped(self, thing: Thing, pads: Pads) -> Transform:
        """hand_T_thing (4, 4) once the pads have closed about it."""
        return hand_T_gripped(thing, pads)

    def let_go(self, thing: Thing) -> None:
        """The fingers let go: set its pose and what carries it."""
        put_down(self.scene, thing)

    # In physics

    def awake(self, hand: NDArray[np.float64]) -> Iterable[Thing]:
        """Things that physics may have moved in this period; the hand is at (3,) in [m] in the world."""
        return self.things()

    def rested(self, thing: Thing) -> None:
        """Physics has put a thing, which isn't held, where its pose is: set what carries it."""
        thing.rest = rest_of(self.scene, thing)
        if thing.rest is Rest.TRAY:
            thing.base_T_thing = inverse(self.scene.world_T_base) @ thing.pose
