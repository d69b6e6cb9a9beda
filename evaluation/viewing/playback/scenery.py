"""Constant data of a recorded run: the robot's shape, its surroundings and its map."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Literal, Protocol

import cv2
import numpy as np
from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray

from .seven import Seven, seven, sevens

if TYPE_CHECKING:
    from handcart.backends.simulation.world.scene import Scene
    from handcart.backends.simulation.world.solids import Solid
    from handcart.networks.task.preparing import Prepared
    from handcart.robotics.navigation.maps.grid_map import GridMap

Size = tuple[float, float, float]
Grey = Annotated[int, Field(ge=0, le=255)]
UNKNOWN, OCCUPIED, FREE = 128, 0, 255  # in the picture of a map


class SolidShape(FileModel):
    """Fixed box of a recorded world, which may appear and disappear during the run."""

    name: str
    pose: Seven
    """world_T_centre of the box."""
    size_m: Size
    grey: Grey | None = None
    """Grey value; None: the colour of furniture."""
    appears_s: float = 0.0
    """Time of appearing on the world's clock, which advances while a run is paused."""
    leaves_s: float | None = None


class ThingShape(FileModel):
    """Size and colour of a recorded box that moves, such as an object that a hand can carry."""

    name: str
    size_m: Size
    middle: Seven
    """thing_T_centre: pose of the box in the thing's frame."""
    grey: Grey


class MapShape(FileModel):
    """Occupancy grid of the robot in a recorded run, as a picture."""

    resolution_m: float
    origin_m: tuple[float, float]
    """x and y of the picture's lower left corner on the map."""
    png: str
    """PNG in base64, with the highest y first: 0 occupied, 255 free, 128 unknown."""

    def picture(self) -> ByteArray:
        """Return the map's picture (h, w), grey from 0 to 255, the row of the highest y first.

        Raises:
            ValueError: the stored bytes are not a picture.
        """
        raw = np.frombuffer(base64.b64decode(self.png), np.uint8)
        found = cv2.imdecode(raw, cv2.IMREAD_GRAYSCALE) if len(raw) else None
        if found is None:
            raise ValueError("the map in it is not a picture")
        return found.astype(np.uint8, copy=False)


class RobotShape(FileModel):
    """Description of a recorded run's robot, with URDF, footprint and lidar, for drawing it."""

    name: str
    urdf: str
    """Text of the URDF; meshes are named by absolute paths on the machine that ran it."""
    joints: tuple[str, ...] = ()
    """Names of the arm's joints, in the order of all its readings."""
    slides: tuple[bool, ...] = ()
    """True for each prismatic joint, in the order of `joints`."""
    footprint_m: float
    """Radius of the footprint."""
    angles_rad: tuple[float, ...] = ()
    """Directions of the lidar's beams, in its frame."""
    base_t_sensor: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Pose of the lidar on the base: x, y in [m], heading in [rad]."""


class Scenery(FileModel):
    """Data that do not change during a recorded run, such as robot, fixed solids, map and places.

    Map and places are in the map's frame, everything else is in the world's frame.
    """

    format: Literal["handcart-playback/1"] = "handcart-playback/1"
    robot: RobotShape
    simulated: bool
    """True if the solids and all true poses are known."""
    outdoors: bool = False
    solids: tuple[SolidShape, ...] = ()
    map: MapShape | None = None
    places: dict[str, tuple[float, float, float]] = Field(default_factory=dict)
    """Places by name: x, y in [m], heading in [rad]."""
    world_t_map: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Pose of the map's frame in the world: x, y in [m], heading in [rad]. Not zero only without a map."""


def scenery_of(prepared: Prepared, scene: Scene | None) -> Scenery:
    """Return the constant data for a view of a run: robot, solid bodies, map and places.

    Args:
        prepared: the robot, its model of the world and its task, before the run.
        scene: simulated world of the run; None for a real robot.
    """
    places = {name: place.pose for name, place in prepared.model.places.items()}
    frame = Pose2(0.0, 0.0, 0.0) if scene is None else scene.world_T_map(prepared.robot.own_start)
    return Scenery(
        robot=_robot(prepared),
        simulated=scene is not None,
        outdoors=scene is not None and scene.open_ground,
        solids=() if scene is None else tuple(map(_solid, _without_ground(scene.solids))),
        map=_map(prepared.model.map),
        places={name: (pose.x, pose.y, pose.theta) for name, pose in places.items()},
        world_t_map=(frame.x, frame.y, frame.theta),
    )


class PosedBox(Protocol):
    """Interface of bodies that move and are drawn as a box, such as carried things and walking people."""

    @property
    def name(self) -> str:
        """Unique name of the box."""

    @property
    def size(self) -> Size:
        """Length, width and height along x, y and z of the box's frame, in [m]."""

    @property
    def grey(self) -> int:
        """Grey of the box's sides, 0 to 255."""

    @property
    def pose(self) -> Transform:
        """Pose world_T_thing (4, 4) of the box's frame in the world."""

    @property
    def thing_T_middle(self) -> Transform:
        """Pose thing_T_middle (4, 4) of the box's middle in the frame that `pose` locates in the world."""


def thing_shapes(things: Sequence[PosedBox]) -> list[ThingShape]:
    """Return the sizes and colours of moving boxes, as they are stored in a recording."""
    middles = sevens(np.array([thing.thing_T_middle for thing in things]).reshape(-1, 4, 4)).tolist()
    return [
        ThingShape(name=thing.name, size_m=thing.size, middle=middle, grey=thing.grey)
        for thing, middle in zip(things, middles, strict=True)
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

    return (solid for solid in solids if solid is not THE_GROUND)


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
