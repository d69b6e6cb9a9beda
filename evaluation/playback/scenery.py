"""What stays the same in a run: the robot as it is built, what stands around it, what it knows of that."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.robotics.geometry.pose2 import Pose2

from .seven import Seven, seven, sevens

if TYPE_CHECKING:
    from handcart.backends.simulation.scene import Scene
    from handcart.backends.simulation.world.solids import Solid
    from handcart.backends.simulation.world.thing import Thing
    from handcart.networks.task.preparing import Prepared
    from handcart.robotics.navigation.maps.grid_map import GridMap

Size = tuple[float, float, float]
Grey = Annotated[int, Field(ge=0, le=255)]
UNKNOWN, OCCUPIED, FREE = 128, 0, 255  # in the picture of a map


class SolidShape(FileModel):
    """A box that nothing moves, though it may come and go."""

    name: str
    pose: Seven
    """world_T_middle."""
    size_m: Size
    grey: Grey | None = None
    """None: as of furniture."""
    appears_s: float = 0.0
    """In the world's time, which goes on while a run is paused."""
    leaves_s: float | None = None


class ThingShape(FileModel):
    """A box that hands can carry."""

    name: str
    size_m: Size
    middle: Seven
    """thing_T_middle: where the box is in the thing's own frame."""
    grey: Grey


class MapShape(FileModel):
    """The occupancy grid that the robot has."""

    resolution_m: float
    origin_m: tuple[float, float]
    """Of the lower left corner of the picture."""
    png: str
    """The picture in base64, the highest y first: 0 occupied, 255 free, 128 unknown."""

    def picture(self) -> NDArray[np.uint8]:
        """(h, w), the highest y first.

        Raises:
            ValueError: it is no picture.
        """
        raw = np.frombuffer(base64.b64decode(self.png), np.uint8)
        found = cv2.imdecode(raw, cv2.IMREAD_GRAYSCALE) if len(raw) else None
        if found is None:
            raise ValueError("the map in it is no picture")
        return found.astype(np.uint8, copy=False)


class RobotShape(FileModel):
    """The robot as it is built."""

    name: str
    urdf: str
    """Its text; meshes named by absolute paths on the machine that ran it."""
    joints: tuple[str, ...] = ()
    """Of the arm, in the order of all its readings."""
    slides: tuple[bool, ...] = ()
    """Which of them slide."""
    footprint_m: float
    """Radius."""
    angles_rad: tuple[float, ...] = ()
    """Of the range sensor's beams, in its frame."""
    base_t_sensor: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """x, y in [m] and heading in [rad] of the range sensor on the base."""


class Scenery(FileModel):
    """All of it. Frames: the world's, which is the map's where there is one."""

    format: Literal["handcart-playback/1"] = "handcart-playback/1"
    robot: RobotShape
    simulated: bool
    """Whether the solids, and everything's true pose, are known."""
    outdoors: bool = False
    solids: tuple[SolidShape, ...] = ()
    map: MapShape | None = None
    places: dict[str, tuple[float, float, float]] = Field(default_factory=dict)
    """By name: x, y in [m], heading in [rad]."""


def scenery_of(prepared: Prepared, scene: Scene | None) -> Scenery:
    """Of a run that could start; `scene` is its simulated world, None where it is a real one."""
    places = {name: place.pose for name, place in prepared.model.places.items()}
    return Scenery(
        robot=_robot(prepared),
        simulated=scene is not None,
        outdoors=scene is not None and scene.open_ground,
        solids=() if scene is None else tuple(map(_solid, _without_ground(scene.solids))),
        map=_map(prepared.model.map),
        places={name: (pose.x, pose.y, pose.theta) for name, pose in places.items()},
    )


def thing_shapes(things: Sequence[Thing]) -> list[ThingShape]:
    """How things are drawn."""
    middles = sevens(np.array([each.thing_T_middle for each in things]).reshape(-1, 4, 4)).tolist()
    return [
        ThingShape(name=each.name, size_m=each.size, middle=middle, grey=each.grey)
        for each, middle in zip(things, middles, strict=True)
    ]


def _robot(prepared: Prepared) -> RobotShape:
    robot = prepared.robot
    spec, sensor = robot.spec, robot.lidar
    scan = None if sensor is None else sensor.scan()
    stands = Pose2(0.0, 0.0, 0.0) if scan is None else scan.base_T_sensor
    joints = () if spec.arm is None else spec.arm.joints
    return RobotShape(
        name=prepared.task.robot,
        urdf=spec.urdf_text(),
        joints=joints,
        slides=tuple(spec.joint_units.slides[: len(joints)]) if joints else (),
        footprint_m=spec.footprint_radius_m,
        angles_rad=() if scan is None else tuple(scan.angles.tolist()),
        base_t_sensor=(stands.x, stands.y, stands.theta),
    )


def _without_ground(solids: Iterable[Solid]) -> Iterable[Solid]:
    from handcart.backends.simulation.world.solids import THE_GROUND

    return (each for each in solids if each is not THE_GROUND)


def _solid(solid: Solid) -> SolidShape:
    return SolidShape(
        name=solid.box.name,
        pose=seven(solid.box.pose),
        size_m=solid.box.size,
        grey=solid.grey,
        appears_s=solid.appears,
        leaves_s=solid.leaves if np.isfinite(solid.leaves) else None,
    )


def _map(grid: GridMap | None) -> MapShape | None:
    if grid is None:
        return None
    shade = np.where(grid.occupied, OCCUPIED, np.where(grid.unknown, UNKNOWN, FREE)).astype(np.uint8)
    _, png = cv2.imencode(".png", shade[::-1])
    return MapShape(
        resolution_m=grid.resolution,
        origin_m=(grid.origin_x, grid.origin_y),
        png=base64.b64encode(png.tobytes()).decode(),
    )
