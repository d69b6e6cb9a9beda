"""Motion of the base among upright boxes, up to a contact."""

from __future__ import annotations

from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.geometry.pose2 import Pose2, wrap

from .arm_contact import NO_TOUCH
from .hand import SimulatedHand

_HALVINGS = 8


def move_base(scene: Scene, motion: Pose2, hand: SimulatedHand | None) -> frozenset[tuple[str, str]]:
    """Move the base, and stop it at the first contact.

    The base has the outline of its footprint and the height of its body. At a contact a base with a round
    footprint still turns, while its wheels slip; a base with a polygon as its footprint stops completely.

    Args:
        scene: true state of world and robot.
        motion: 2D pose of the base after the motion, in the base frame before the motion.
        hand: hand, to check arm and load for contacts; None without an arm.

    Returns:
        Pairs of bodies that touch: the name of a part of the robot, and the name of the other body.
    """
    start, end = scene.base, scene.base.compose(motion)
    gap, other = base_gap(scene, end)
    touches: frozenset[tuple[str, str]] = frozenset()
    if gap < 0.0 and gap < base_gap(scene, start)[0]:
        end = _nearest_free(scene, start, end)
        touches = frozenset({("base", other)})
    met = NO_TOUCH if hand is None else hand.met_at(end)
    if met.depth > 0.0:
        return touches | {(met.body, met.other)}
    scene.move_base(end)
    return touches


def touching_passers(scene: Scene) -> frozenset[tuple[str, str]]:
    """Return a pair ("base", name) for each passer (a person or cart that walks by) that touches the base."""
    if not scene.passers:
        return frozenset()
    touched = scene.passers.touched(scene.base, scene.robot.footprint_shape)
    return frozenset(("base", name) for name in touched)


def base_gap(scene: Scene, base: Pose2) -> tuple[float, str]:
    """Return the distance between the footprint and the nearest body in [m], and the name of this body.

    The distance is negative if they overlap, and infinite if there are no bodies.

    Args:
        scene: true state of the world.
        base: pose world_T_base of the footprint.
    """
    shape = scene.robot.footprint_shape
    own = scene.body_plan.gap(base, shape, scene.time)
    found = min([own, *(props.base_gap(base) for props in scene.props.values())])
    return min(found, scene.passers.gap(base, shape)) if scene.passers else found


def _nearest_free(scene: Scene, start: Pose2, end: Pose2) -> Pose2:
    """Return the last free pose world_T_base of the motion; a disc makes the turn in full."""
    is_disc, free, blocked = scene.robot.footprint_shape.is_disc, 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (free + blocked) / 2
        if base_gap(scene, _between(start, end, middle, is_disc))[0] < 0.0:
            blocked = middle
        else:
            free = middle
    return _between(start, end, free, is_disc)


def _between(start: Pose2, end: Pose2, share: float, turned: bool) -> Pose2:
    """Return the pose after a share of the straight line, 0 to 1, with all of the turn if `turned`, otherwise
    that share of it.
    """
    x, y = start.x + share * (end.x - start.x), start.y + share * (end.y - start.y)
    turn = 1.0 if turned else share
    return Pose2(x, y, wrap(start.theta + turn * wrap(end.theta - start.theta)))
