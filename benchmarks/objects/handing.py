"""A robot at home with an object in its hand, and a person whose pulls a world's file says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.world.scene import Scene
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.objects.knowledge.objects import HeldObject, Objects
from handcart.primitives.restoring.snapshot import is_holding
from handcart.robotics.geometry.transform import Transform, inverse

TASK_FOLDER = Path(__file__).resolve().parents[2] / "tasks" / "fetch_and_carry"
OBJECT_NAME = "parcel_1"
GRIP_DEPTH_M = 0.025  # of the object's top between the fingers
GRIP_TIME_S = 5.0


def world_with(folder: Path, pulls: Sequence[Mapping[str, Any]], friction: float = 0.65) -> Path:
    """Write the task's world with a person's pulls into a folder; return the file."""
    import yaml

    data = yaml.safe_load((TASK_FOLDER / "world.yaml").read_text(encoding="utf-8"))
    for object_ in data["objects"]:
        object_["friction"] = friction
    path = folder / "world.yaml"
    path.write_text(yaml.safe_dump({**data, "pulls": [dict(pull) for pull in pulls]}), encoding="utf-8")
    return path


def rig_holding(
    world: Path,
    robot: str = "librarian",
    seed: int = 0,
    backend: str = "kinematic",
    places: Path = TASK_FOLDER / "places.yaml",
    objects: Path = TASK_FOLDER / "objects.yaml",
    known_map: Path = TASK_FOLDER / "map.yaml",
) -> Rig:
    """Return a rig with the robot at home, whose fingers have closed on the object from above."""
    files = RigFiles(world, known_map, places, {"objects": objects}, "home")
    rig = build_rig(files, robot=robot, seed=seed, backend=backend)
    hand_T_object = _from_above(rig)
    rig.robot.gripper.move(0.0)
    end = rig.robot.time + GRIP_TIME_S
    while not is_holding(rig.robot):
        if rig.robot.time > end:
            raise RuntimeError(f"the fingers don't close on {OBJECT_NAME}")
        _hold_up(rig, hand_T_object)
        rig.robot.step()
    rig.model.of(Objects).held_object = HeldObject(OBJECT_NAME, scene_of(rig).hand_T_held)
    rig.model.in_hand = f"object {OBJECT_NAME}"
    for _ in range(10):
        rig.robot.step()
    return rig


def scene_of(rig: Rig) -> Scene:
    """Return the ground truth."""
    scene = rig.backend.scene  # type: ignore[attr-defined]
    assert isinstance(scene, Scene)
    return scene


def _from_above(rig: Rig) -> Transform:
    """Return hand_T_object (4, 4) of the object upright below the hand, or before it, between the fingers."""
    scene = scene_of(rig)
    base_T_hand = inverse(scene.world_T_base) @ scene.world_T("hand")
    kind = rig.model.of(Objects).objects.kind_of(OBJECT_NAME)
    tip = rig.robot.spec.finger_shape.tip
    # The object's z against the way the fingers point, its narrow side across them.
    hand_T_object = np.eye(4)
    hand_T_object[:3, :3] = np.column_stack([(0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0)])
    hand_T_object[0, 3] = tip - GRIP_DEPTH_M + kind.size[2]
    if base_T_hand[2, 0] > -0.5:  # the hand points ahead: upright before it
        up = base_T_hand[:3, :3].T @ (0.0, 0.0, 1.0)
        hand_T_object[:3, :3] = np.column_stack([(0.0, 1.0, 0.0), np.cross(up, (0.0, 1.0, 0.0)), up])
        middle = np.array([tip - GRIP_DEPTH_M + kind.size[1] / 2, 0.0, 0.0])
        hand_T_object[:3, 3] = middle - up * kind.size[2] / 2
    return hand_T_object


def _hold_up(rig: Rig, hand_T_object: Transform) -> None:
    """Keep the object where the fingers close on it."""
    scene = scene_of(rig)
    thing = scene.thing_named(f"object {OBJECT_NAME}")
    assert thing is not None
    pose = scene.world_T("hand") @ hand_T_object
    if isinstance(rig.backend, PhysicsBackend):
        world, engine = rig.backend._world, rig.backend._engine
        engine.set_pose(world.bodies[thing.name], pose @ thing.thing_T_middle)
    elif scene.held is None:
        thing.pose = pose
        scene.changes += 1
