"""Checks of what a primitive requires before anything moves, and of what it has to keep."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Measured, NeedsPerson
from handcart.primitives.preconditions.hand_use import Hand
from handcart.primitives.restoring.snapshot import is_holding

MAX_EMPTY_PERIODS = 20
"""Periods at rest without a held thing until it counts as lost; readings may miss for some."""
_BASE = ActionPrimitive
"""Class whose methods require nothing by themselves."""


def find_unmet(primitive: ActionPrimitive, robot: Robot, model: WorldModel) -> str:
    """Return a message about an unmet precondition of a primitive; empty if all are met.

    The declared preconditions are checked before the primitive's own. No command is sent.

    Args:
        primitive: instance with all its parameters.
        robot: the robot, at rest.
        model: world model.
    """
    kind = type(primitive)
    if unmet := _unmet_by_pose(primitive, robot):
        return unmet
    if not (kind.hand_use is _BASE.hand_use and kind.usual_hand_use().before is Hand.ANY):
        unmet = _unmet_by_hand(primitive, robot, model)
    if not (unmet or (kind.needs_arm_inside is _BASE.needs_arm_inside and not kind.arm_inside)):
        unmet = _unmet_by_arm(primitive, robot)
    if unmet or kind.unmet_precondition is _BASE.unmet_precondition:
        return unmet
    return primitive.unmet_precondition(robot, model.view(primitive))


def note_hand(primitive: ActionPrimitive, model: WorldModel) -> None:
    """Set the model's `in_hand` to what the hand holds after a primitive's Success.

    `in_hand` is unchanged if the primitive does not change the content of the hand. It is set to an empty
    text if the hand is empty after the primitive, or its content unknown.
    """
    after = primitive.hand_use().after
    if after is not Hand.SAME:
        model.in_hand = primitive.thing(model.view(primitive)) if after is Hand.FULL else ""


def check_hand(
    primitive: ActionPrimitive, robot: Robot, model: WorldModel, was_holding: bool
) -> Generator[None, None, None]:
    """Check at the end that the hand still holds what the primitive keeps, and note what it holds.

    Args:
        primitive: the primitive, at rest after its motion.
        robot: the robot.
        model: world model, whose `in_hand` is set (`note_hand`).
        was_holding: True if the hand held something at the start.

    Raises:
        NeedsPerson: the hand has held nothing for `MAX_EMPTY_PERIODS` periods.
    """
    missed = 0
    while was_holding and primitive.hand_use().after is Hand.SAME and not is_holding(robot):
        if missed == MAX_EMPTY_PERIODS:
            opening = Measured("Gripper", "opening", 1e3 * robot.gripper.width(), unit="mm")
            raise NeedsPerson("what the hand held slipped out under way", opening, cause=causes.SLIPPED)
        missed += 1
        yield
    note_hand(primitive, model)


def _unmet_by_pose(primitive: ActionPrimitive, robot: Robot) -> str:
    """Return a message if the pose of the base is not known, and the primitive needs it."""
    where = robot.localization
    if not primitive.needs_pose or (where.is_located and where.lifted is None):
        return ""
    why = "" if where.lifted is None else f": {where.lifted.why}"
    return (
        f"{primitive.label()} needs the pose of the base on the map, which is not known{why}; LOCATE finds it"
    )


def _unmet_by_hand(primitive: ActionPrimitive, robot: Robot, model: WorldModel) -> str:
    needed = primitive.hand_use().before
    if needed is Hand.ANY or robot.backend.get(Gripper) is None:  # type: ignore[type-abstract]
        return ""
    thing = primitive.thing(model.view(primitive))
    holding = is_holding(robot)
    if needed is Hand.EMPTY:
        return f"the hand is not empty: it holds {model.in_hand or 'something'}" if holding else ""
    if not holding:
        return f"the hand is empty; it must hold {thing or 'something'}"
    if thing and model.in_hand and thing != model.in_hand:
        return f"the hand holds {model.in_hand}, not {thing}"
    return ""


def _unmet_by_arm(primitive: ActionPrimitive, robot: Robot) -> str:
    """Return a message if the base would drive with the hand outside the footprint, where the arm is
    unprotected.
    """
    if not primitive.needs_arm_inside() or robot.spec.arm is None:
        return ""
    hand, shape = robot.base_T("hand"), robot.spec.footprint_shape
    spots = [hand[:2, 3]]
    if is_holding(robot):  # a held object reaches at least to the finger tips
        ahead = np.array([robot.spec.finger_shape.tip, 0.0, 0.0, 1.0])
        spots.append((hand @ ahead)[:2])
    away = shape.distances(np.array(spots))
    if away.max() <= 0.0:
        return ""
    if not shape.is_disc:
        return (
            f"the hand is {away.max():.2f} m outside the robot's footprint: the arm goes home before the "
            "base drives"
        )
    out, radius = float(away.max()) + shape.radius, shape.radius
    return (
        f"the hand stands out beyond the robot's footprint, {out:.2f} m from its middle where {radius:.2f} m "
        "are allowed: the arm goes home before the base drives"
    )
