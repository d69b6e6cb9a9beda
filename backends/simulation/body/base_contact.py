"""Motion of the base among upright boxes, up to a contact."""

from __future__ import annotations

from handcart.backends.simulation.world.scene import Scene
from handcart.robotics.geometry.pose2 import Pose2, wrap

from .arm_contact import NO_TOUCH
from .hand import SimulatedHand

_HALVINGS = 8


def move_base(scene: Scene, motion: Pose2, hand: SimulatedHand | None) -> frozenset[tuple[str, str]]:
    """Move the base, or up to a contact; return the touching pairs: names of the robot's body and the other
    one.

    The base has the outline of its footprint and the height of its body. At a contact a disc turns but comes
    no nearer, because its wheels slip; a polygon does neither.

    Args:
        scene: true state of world and robot.
        motion: 2D pose of the base after the motion in the base frame before it.
        hand: reports whether arm and load can be carried along; None without an arm.
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
    """Return the touching pairs of the base and of passers that walked into it, or that it drove into."""
    if not scene.passers:
        return frozenset()
    touched = scene.passers.touched(scene.base, scene.robot.footprint_shape)
    return frozenset(("base", name) for name in touched)


def base_gap(scene: Scene, base: Pose2) -> tuple[float, str]:
    """Return the distance of the footprint to the nearest body in [m], and the name of that body.

    Below 0 they overlap; infinity without bodies.

    Args:
        scene: true state of the world.
        base: world_T_base at which the footprint is compared.
    """
    shape = scene.robot.footprint_shape
    found = scene.body_plan.gap(base, shape, scene.time)
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
