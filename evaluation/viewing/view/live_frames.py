"""Frames of a live run."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.backends.simulation.world.scene import Scene
from handcart.evaluation.viewing.playback.playback import PlaybackMoment
from handcart.evaluation.viewing.playback.recorder import jpeg_of
from handcart.evaluation.viewing.playback.scenery import PosedBox, Scenery, ThingShape, thing_shapes
from handcart.evaluation.viewing.playback.seven import sevens
from handcart.robotics.navigation.tracking.people import People
from handcart.robotics.numerics.arrays import FloatArray

from .frame import Frame
from .rays import height_of, rays_of
from .recorded_frames import PATH_STEP_M


class LiveFrames:
    """Source of frames that show the current state of robot and world.

    Some frames are never drawn. Each frame therefore contains the poses of all things, and the shapes of all
    things that have appeared since the run began.
    """

    def __init__(self, robot: Robot, scene: Scene | None, scenery: Scenery, known: set[str]) -> None:
        """Read the state of a robot and its simulated scene; `known` holds the names of the things already
        drawn.
        """
        self._robot, self._scene, self._scenery, self._known = robot, scene, scenery, known
        backend = robot.backend
        self._arm, self._gripper = backend.get(Arm), backend.get(Gripper)  # type: ignore[type-abstract]
        self._range = robot.lidar
        self._height = height_of(scenery.robot.urdf)
        self._new: list[ThingShape] = []
        self._way: list[FloatArray] = []
        self._back: list[bool] = []
        self._joints, self._width = np.zeros(len(scenery.robot.joints)), 0.0
        self._ranges: FloatArray | None = None

    @property
    def time(self) -> float:
        """Present time on the robot's clock, in [s]."""
        return self._robot.time

    def now(self, situation: str, action: int, restoring: bool, planned: FloatArray | None) -> Frame:
        """Return the state of the run in this period, to be drawn on the page.

        Args:
            situation: name of the current situation.
            action: number of the action.
            restoring: True while the action is being undone.
            planned: (n, 2) path on the map that the action plans to drive, in [m]; None without a path.
        """
        robot, scene = self._robot, self._scene
        with suppress(Exception):  # reported by primitives that need the reading
            self._sense()
        truth = None if scene is None else sevens(scene.world_T_base[None])[0]
        world_time = robot.time if scene is None else scene.time
        pose = np.array(robot.pose)
        covariance = np.array(robot.localization.covariance)
        moment = PlaybackMoment(
            robot.time, world_time, pose, truth, self._joints, self._width, covariance, action, restoring
        )
        rays = None
        if self._ranges is not None:
            rays = rays_of(self._scenery.robot, self._ranges, moment.base, self._height)
        self._go_on(moment.base[:2], restoring)
        cloud, seen = robot.localization.particles, robot.seen
        return Frame(
            moment,
            situation,
            self._things(),
            tuple(self._new),
            rays,
            None if cloud is None else cloud.T,
            None if seen is None else jpeg_of(seen),
            np.empty((0, 2)) if planned is None else np.asarray(planned),
            robot.base.felt,
            np.array(self._way),
            np.array(self._back, dtype=np.bool_),
            People.of(robot.people.now(robot.time)).rows,
        )

    def _sense(self) -> None:
        if self._arm is not None:
            self._joints = self._arm.joints().copy()
        if self._gripper is not None:
            self._width = self._gripper.width()
        if self._range is not None:
            self._ranges = self._range.scan().ranges

    def _go_on(self, here: FloatArray, restoring: bool) -> None:
        if not self._way or float(np.linalg.norm(here - self._way[-1])) >= PATH_STEP_M:
            self._way.append(here.copy())
            self._back.append(restoring)

    def _things(self) -> dict[str, FloatArray | None]:
        things: list[PosedBox] = []
        if self._scene is not None:
            things = [*self._scene.things(), *self._scene.passers.shapes()]
        for thing in things:
            if thing.name not in self._known:
                self._known.add(thing.name)
                self._new += thing_shapes([thing])
        poses = sevens(np.array([thing.pose for thing in things]).reshape(-1, 4, 4))
        return {thing.name: pose for thing, pose in zip(things, poses, strict=True)}
