"""The robot in a physics engine: its links and joints by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import ClassVar

from handcart.backends.physics.engine.surface import ContactSurface
from handcart.backends.physics.urdf.sound_urdf import casters
from handcart.backends.physics.urdf.sprung import CHASSIS_LINK
from handcart.backends.physics.urdf.urdf_repairs import Repair
from handcart.backends.urdf.driven_wheels import DrivenWheels
from handcart.files.errors import InputError
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

from .joint_group import JointGroup


class NoPlanarDrive(InputError):
    """Error: a physics engine cannot move a base that drives in any direction."""


class PlanarDrive(ABC):
    """Drive of a physics engine that pushes and turns a base in the floor's plane; no wheels are
    simulated.
    """

    @abstractmethod
    def limit(self, force: float, torque: float) -> None:
        """Limit the drive's force ahead and to the left, in [N] each, and its torque about the vertical axis,
        in [Nm].
        """

    @abstractmethod
    def drive(self, twist: FloatArray) -> None:
        """Command the base's velocity (3,): speed ahead and speed to the left in [m/s], turn rate to the left
        in [rad/s].
        """


class RobotBody(ABC):
    """Links and joints of a robot in a physics engine, built from its URDF.

    If the robot's file lets the base tilt under load, a suspension connects the base to a chassis with the
    wheels; see `sprung`.
    """

    COUPLES_MIMICS: ClassVar[bool] = False
    """True if the engine couples joints with those that they mimic; otherwise their own drives do."""
    id: int
    """The engine's number of the robot."""
    sprung: bool
    """True if it has a suspension."""
    wheels: DrivenWheels
    effort: dict[str, float]
    """Maximum effort of joints, in [Nm] or [N], by name."""
    link_index: dict[str, int]
    link_names: dict[int, str]
    repairs: Sequence[Repair]
    """Differences of the robot's masses and inertia from its URDF."""

    @abstractmethod
    def put(self, base: Pose2, height: float = 0.0) -> None:
        """Put the base at another pose world_T_base, on the floor or at a `height` above it in [m]."""

    @abstractmethod
    def standing_pose(self) -> Transform:
        """Return world_T_base (4, 4) as it would be without the tilt of the base on its suspension."""

    def base_pose(self) -> Transform:
        """Return the true world_T_base (4, 4)."""
        return self.link_pose("base") if self.sprung else self.standing_pose()

    @abstractmethod
    def link_pose(self, link: str) -> Transform:
        """Return world_T_link (4, 4), the true pose of a link's frame."""

    @abstractmethod
    def middle_of_mass(self, link: str) -> Transform:
        """Return the true pose (4, 4) of a link's centre of mass in the world, with the axes of the engine's
        inertial frame.
        """

    @abstractmethod
    def mass(self, link: str) -> float:
        """Return the mass of a link, in [kg]."""

    @abstractmethod
    def joints(self, names: Sequence[str]) -> JointGroup:
        """Return the group of the joints with these names, to read and to drive."""

    @abstractmethod
    def reset(self, joint: str, position: float) -> None:
        """Put a joint to a position in [rad] or [m], at rest."""

    @abstractmethod
    def cover(self, links: Iterable[str], surface: ContactSurface) -> None:
        """Set friction and stiffness of the surface of some of the robot's links.

        Args:
            links: names of the links.
            surface: contact properties of these links.
        """

    @abstractmethod
    def mirror(self, joints: tuple[str, str]) -> None:
        """Couple two joints, so that their positions stay equal."""

    @abstractmethod
    def links_behind(self, joint: str) -> set[int]:
        """Return the physics engine's numbers of all links that a joint of the robot moves."""

    def planar_drive(self) -> PlanarDrive:
        """Return the drive that pushes a holonomic base in the floor's plane; called only for such a base."""
        raise NoPlanarDrive("this engine drives no holonomic base; allowed: the backends kinematic, mujoco")

    def sprung_masses(self) -> dict[str, float]:
        """Return the masses in [kg], by name, of all links that rest on the suspension: all but wheels,
        casters and chassis.
        """
        wheels = (CHASSIS_LINK, *self.wheels.all, *self.casters)
        return {name: self.mass(name) for name in self.link_index if name not in wheels}

    @property
    def rolling(self) -> list[str]:
        """Names of the links that are wheels, with or without a drive."""
        return [name for name in self.link_index if name.endswith("wheel")]

    @property
    def casters(self) -> list[str]:
        """Names of the links that slide on the floor instead of rolling (casters)."""
        return casters(self.link_index)
