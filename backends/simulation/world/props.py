"""Objects of one domain in a simulated world."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, ClassVar, Generic, Self, TypeVar, cast

from typing_extensions import override

from handcart.backends.simulation.world.solids import Solid
from handcart.backends.simulation.world.support import put_down, rest_of
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.files.models.model import FileModel
from handcart.robotics.geometry.transform import inverse

from .scene import Scene
from .scene_props import SceneProps

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import RobotFile
    from handcart.files.errors import Finding
    from handcart.files.models.loading import Loaded

FileModelT = TypeVar("FileModelT", bound=FileModel)


class Props(SceneProps, Generic[FileModelT]):
    """Base class for the simulated things of one application domain in a scene.

    A subclass defines how the things are set up, look, are gripped and released, and change; the attribute
    `Domain.props` names it. Methods that are not overridden treat things as passive boxes on tables, on the
    robot and on each other.
    """

    section: ClassVar[type[FileModel]]
    """Keys that it adds to the world's file, all optional."""
    PAINTS_SOLIDS: ClassVar[bool] = False
    """True if `painted` includes its solids; otherwise the camera sees them as plain boxes."""

    def __init__(self, scene: Scene, spec: FileModelT, seed: int) -> None:
        """Connect to a scene whose robot is at its start; `set_up` then creates the things.

        Args:
            scene: true state of the world.
            spec: section of the world's file.
            seed: seed of all that the domain draws.
        """
        self.scene, self.spec, self.seed = scene, spec, seed

    @classmethod
    @override
    def none_in(cls, scene: Scene) -> Self:
        props = cls(scene, cast(FileModelT, cls.section()), 0)
        props.set_up()
        return props

    @classmethod
    def solids(cls, spec: FileModelT) -> Sequence[Solid]:
        """Return the immovable bodies that a domain (a kind of task) adds to the world, with which the robot
        may collide.
        """
        return ()

    @classmethod
    def findings(cls, loaded: Loaded[FileModelT], robot: RobotFile) -> Iterator[Finding]:
        """Yield a finding for each key of this domain (a kind of task) in a world's file whose value does not
        fit the given robot.
        """
        yield from ()

    def set_up(self) -> None:
        """Create the things of a domain (a kind of task) where a person would put them, with errors drawn
        from `self.seed`.
        """

    @override
    def let_go(self, thing: Thing) -> None:
        put_down(self.scene, thing)

    @override
    def rested(self, thing: Thing) -> None:
        thing.rest = rest_of(self.scene, thing)
        if thing.rest is Rest.TRAY:
            thing.base_T_thing = inverse(self.scene.world_T_base) @ thing.pose
