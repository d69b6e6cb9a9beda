"""Motion of the base, a disc, among upright boxes, up to a contact."""

from __future__ import annotations

from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.geometry.pose2 import Pose2

from .arm_contact import NO_TOUCH
from .hand import SimulatedHand

_HALVINGS = 8


def move_base(scene: Scene, motion: Pose2, hand: SimulatedHand | None) -> frozenset[tuple[str, str]]:
    """Move the base by `motion` (pose of its end in its start), or up to a contact; return the touching
    pairs.

    The base is a disc of the footprint's radius with the height of its body; `hand` reports whether arm
    and load can be carried along. At a contact the base turns but comes no nearer: its wheels slip.
    """
    start, end = scene.base, scene.base.compose(motion)
    radius = scene.robot.footprint_radius_m
    clearance, other = scene.body_plan.clearance(end.x, end.y, scene.time)
    touches: frozenset[tuple[str, str]] = frozenset()
    if clearance < radius and clearance < scene.body_plan.clearance(start.x, start.y, scene.time)[0]:
        end = _nearest_free(scene, start, end)
        touches = frozenset({("base", other)})
    met = NO_TOUCH if hand is None else hand.met_at(end)
    if met.depth > 0.0:
        return touches | {(met.body, met.other)}
    scene.move_base(end)
    return touches


def _nearest_free(scene: Scene, start: Pose2, end: Pose2) -> Pose2:
    """The last free position on the straight way; the turn is made in full."""
    radius, free, blocked = scene.robot.footprint_radius_m, 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (free + blocked) / 2
        x, y = start.x + middle * (end.x - start.x), start.y + middle * (end.y - start.y)
        if scene.body_plan.clearance(x, y, scene.time)[0] < radius:
            blocked = middle
        else:
            free = middle
    return Pose2(start.x + free * (end.x - start.x), start.y + free * (end.y - start.y), end.theta)
