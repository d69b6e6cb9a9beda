"""The ground truth of a scene at one instant."""

from __future__ import annotations

import numpy as np

from handcart.backends.ground_truth import Body, GroundTruth
from handcart.backends.simulation.world.thing import Thing
from handcart.robotics.geometry.transform import inverse

from .scene import Scene


def true_state(scene: Scene) -> GroundTruth:
    """A copy: what happens in the scene later doesn't change it."""
    bodies = {each.name: _body(scene, each) for each in scene.things()}
    slides = np.array(scene.robot.joint_units.slides[: scene.joints.size], dtype=np.bool_)
    bumps = sum(contact.body == "base" for contact in scene.contacts)
    return GroundTruth(scene.base, scene.joints.copy(), slides, float(scene.width), bodies, bumps)


def _body(scene: Scene, thing: Thing) -> Body:
    if scene.held is thing:
        return Body("hand", inverse(scene.world_T("hand")) @ thing.pose)
    if thing.rest.value == "tray":
        return Body("tray", inverse(scene.world_T_base) @ thing.pose)
    return Body(thing.carrier, thing.pose.copy())
