"""Free poses of base and arm around a work place, from which planners choose places."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.manipulation.placement.standing_places import OpenFloor, stands_clear
from handcart.robotics.navigation.maps.clearances import Clearances
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.ways import ROOM_AT_GOAL, SENSED_ROOM
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

STAND_MARGIN_M = 0.002  # between the arm and obstacles
AVOIDED_RADIUS_M = 0.15  # from where it couldn't be done
COLLISION_CHECK_STRIDE = 4  # points of a path between looks for contacts
MAX_START_INTRUSION_M = 0.3  # by which the base may be too near to something when it starts


class StandingRoom:
    """Test whether a robot's base and arm touch nothing at poses of the base around a place of work."""

    def __init__(
        self,
        spec: RobotFile,
        arm: ArmModel,
        grid: GridMap,
        sensed: FloatArray,
        here: Pose2,
        boxes: tuple[Box, ...] = (),
        avoided: tuple[Pose2, ...] = (),
    ) -> None:
        """Create the room of a robot at a work place.

        Args:
            spec: file of the robot; it drives with the arm in the posture `home`.
            arm: arm of the robot.
            grid: the map, with the cells in which something was sensed that it does not show.
            sensed: (n, 2) sensed points that are not on the map, in [m].
            here: map_T_base from which the robot sets out.
            boxes: boxes that the arm must not touch, posed on the map.
            avoided: map_T_base of places at which the work can't be done.
        """
        self._arm, self._boxes, self._avoided = arm, boxes, avoided
        self._home = np.array(spec.posture("home"))
        self._grid = grid.with_points(sensed, SENSED_ROOM)
        self._radius = spec.footprint_radius_m + ROOM_AT_GOAL
        self._clearances = Clearances(self._grid, self._grid.blocked, walled=True)
        self._floor = OpenFloor(self._grid, self._radius)
        self._reached = self._way_out(here)

    @property
    def key(self) -> tuple[bytes, ...]:
        """Bytes of all data that `blocked` and `free` depend on for one robot, as key of a cache."""
        posed = [(np.array(item.size), item.pose) for item in self._boxes]
        grid = self._grid
        frame = np.array([grid.resolution, grid.origin_x, grid.origin_y, self._radius])
        known = [
            frame,
            grid.blocked,
            self._reached,
            np.array(self._avoided),
            *(part for box in posed for part in box),
        ]
        return tuple(np.ascontiguousarray(item).tobytes() for item in known)

    def blocked(self, bases: FloatArray) -> BoolArray:
        """Return a mask (b,), True for base poses without room on the map, or to which no route leads.

        Args:
            bases: (b, 3) map_T_base: x, y in [m], heading in [rad].
        """
        no_way = ~self._floor.leads_to(bases, self._reached)
        no_way |= self._clearances.at(bases[:, :2]) < self._radius
        for item in self._avoided:
            no_way |= np.hypot(bases[:, 0] - item.x, bases[:, 1] - item.y) < AVOIDED_RADIUS_M
        return no_way

    def free(self, base: FloatArray, angles: FloatArray) -> bool:
        """Return whether robot and arm touch nothing at a base pose.

        This is checked with the arm in its posture `home`, and while the arm moves along a path.

        Args:
            base: (3,) map_T_base: x, y in [m], heading in [rad].
            angles: (p, n) postures along the arm's path, joint angles in [rad] or positions in [m]; the first
                of every `COLLISION_CHECK_STRIDE` postures is checked, and the last one.
        """
        bodies = self._arm.link_shapes(self._home)
        if not stands_clear(base[None], bodies, self._boxes)[0]:
            return False
        stand = Pose2(*base.tolist()).lift()
        collision = CollisionModel(self._arm, self._boxes, world_T_base=stand, margin=STAND_MARGIN_M)
        tried = np.vstack([angles[::COLLISION_CHECK_STRIDE], angles[-1:]])
        return not any(collision.in_collision(q) for q in tried)

    def _way_out(self, here: Pose2) -> BoolArray:
        """Return a mask (h, w) of the map's cells that routes connect to poses near `here`.

        Poses near it count as well, because the base's actual pose is not exactly the planned one.
        """
        turns = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
        for away in np.linspace(0.0, MAX_START_INTRUSION_M, 7):
            x, y = here.x + away * np.cos(turns), here.y + away * np.sin(turns)
            for spot in zip(x.tolist(), y.tolist(), strict=True):
                reached = self._floor.reached_from(spot)
                if reached.any():
                    return reached
        return self._floor.reached_from((here.x, here.y))
