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
    clearance, other = _clearance(scene, end.x, end.y)
    touches: frozenset[tuple[str, str]] = frozenset()
    if clearance < radius and clearance < _clearance(scene, start.x, start.y)[0]:
        end = _nearest_free(scene, start, end)
        touches = frozenset({("base", other)})
    met = NO_TOUCH if hand is None else hand.met_at(end)
    if met.depth > 0.0:
        return touches | {(met.body, met.other)}
    scene.move_base(end)
    return touches


def touching_passers(scene: Scene) -> frozenset[tuple[str, str]]:
    """Return the touching pairs of the base and those who have walked into it, or it into them."""
    if not scene.passers:
        return frozenset()
    radius = scene.robot.footprint_radius_m
    return frozenset(("base", name) for name in scene.passers.touched(scene.base.x, scene.base.y, radius))


def _clearance(scene: Scene, x: float, y: float) -> tuple[float, str]:
    """Return the distance of a point to the nearest body in [m], and that one's name."""
    found = scene.body_plan.clearance(x, y, scene.time)
    return min(found, scene.passers.clearance(x, y)) if scene.passers else found


def _nearest_free(scene: Scene, start: Pose2, end: Pose2) -> Pose2:
    """Return the last free position on the straight way; the turn is made in full."""
    radius, free, blocked = scene.robot.footprint_radius_m, 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (free + blocked) / 2
        x, y = start.x + middle * (end.x - start.x), start.y + middle * (end.y - start.y)
        if _clearance(scene, x, y)[0] < radius:
            blocked = middle
        else:
            free = middle
    return Pose2(start.x + free * (end.x - start.x), start.y + free * (end.y - start.y), end.theta)
