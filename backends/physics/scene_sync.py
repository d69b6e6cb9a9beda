"""Copy the engine's state into the scene: the ground truth that evaluation reads."""

from __future__ import annotations

import numpy as np

from handcart.backends.physics.body.robot_body import RobotBody
from handcart.backends.physics.world.world_bodies import WorldBodies
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.scene_props import SceneProps
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse


class SceneSync:
    """Copier of the true poses from the physics engine into the scene (ground truth), after each period."""

    def __init__(self, scene: Scene, body: RobotBody, world: WorldBodies) -> None:
        self._scene, self._body, self._world = scene, body, world
        self._old = set[int]()
        """Bodies of things that have moved since their pose was last written."""

    def base(self) -> None:
        """Copy the true pose and tilt of the base from the physics engine into the simulated scene."""
        scene = self._scene
        standing = self._body.standing_pose()
        scene.tilted_base = self._body.link_pose("base") if self._body.sprung else standing
        heading = float(np.arctan2(standing[1, 0], standing[0, 0]))
        scene.base = Pose2(float(standing[0, 3]), float(standing[1, 3]), heading)

    def things(self, held: Thing | None) -> None:
        """Copy the poses of the things that may have moved from the engine into the scene.

        The scene's records of what each of these things rests on, and of which thing the hand holds, are
        updated too.

        Args:
            held: thing that the hand holds; None without one.
        """
        scene = self._scene
        world_T_hand = self._body.link_pose("hand") if "hand" in self._body.link_index else np.eye(4)
        bodies, moved = self._world.bodies, self._world.moved()
        self._old.update(bodies.values() if moved is None else moved)
        self._old.update(bodies[item.name] for item in (scene.held, held) if item is not None)
        for props in scene.props.values():
            for thing in props.awake(world_T_hand[:3, 3]) if self._old else ():
                if bodies.get(thing.name) in self._old:
                    self._place(props, thing, held)
                    self._old.remove(bodies[thing.name])
        scene.held = held
        if held is not None:
            scene.hand_T_held = inverse(world_T_hand) @ held.pose

    def _place(self, props: SceneProps, thing: Thing, held: Thing | None) -> None:
        """Copy the pose of a thing into the scene; the support of one that has not moved stays as it was."""
        pose = self._world.pose(thing)
        stays = bool((pose == thing.pose).all())
        if not stays:
            thing.pose = pose
            self._scene.changes += thing is not held
        if thing is held:
            props.taken(thing)
        elif not stays or thing.rest is Rest.HAND:
            props.rested(thing)
