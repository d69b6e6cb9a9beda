"""The world at first."""

from __future__ import annotations

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.world.solids import THE_GROUND, room_of
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.backends.simulation.world.world_model import kinds_of_props
from handcart.robotics.geometry.pose2 import Pose2

from .keyed_noise import keyed
from .scene import Scene


def build_scene(robot: RobotFile, world: WorldFile, seed: int) -> Scene:
    """The world at first: a person has put the robot there, and set up what the file has of domains."""
    assert world.map is None, "load_world puts what the map shows among the furniture"
    kinds = {
        name: kind
        for name, kind in kinds_of_props().items()
        if world.model_fields_set & kind.section.model_fields.keys()
    }
    room = [*room_of(world), *([THE_GROUND] if world.ground is not None else [])]
    solids = {name: kind.solids(world) for name, kind in kinds.items()}
    boxes = (each for name, kind in kinds.items() if not kind.PAINTS_SOLIDS for each in solids[name])
    arm = None if robot.arm is None else robot.arm_model()
    joints = np.zeros(0) if robot.arm is None else np.array(robot.posture("home"))
    width = 0.0 if robot.gripper is None else robot.gripper.opening_mm / 1e3
    every = (*room, *(solid for each in solids.values() for solid in each))
    scene = Scene(robot, arm, every, _start(robot, world, seed), joints, width, (*room, *boxes))
    scene.open_ground = world.ground is not None
    for name, kind in kinds.items():
        props = scene.props[name] = kind(scene, world, seed)
        props.set_up()
    return scene


def _start(robot: RobotFile, world: WorldFile, seed: int) -> Pose2:
    dx, dy, turn = keyed(seed, "start").standard_normal(3)
    error = robot.errors.start_mm / 1e3
    heading = np.radians(world.start.heading_deg + robot.errors.start_deg * turn)
    x, y = world.start.x_m + error * dx, world.start.y_m + error * dy
    return Pose2(float(x), float(y), float(heading))
