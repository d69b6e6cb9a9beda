"""Effects that a Success of block primitives promises."""

from __future__ import annotations

import math
from collections.abc import Mapping

from handcart.backends.simulation.blocks.block_props import BlockProps
from handcart.evaluation.judging.at_most import at_most
from handcart.evaluation.judging.sensor_sigmas import LIMIT_SIGMAS
from handcart.evaluation.judging.survey import Claim, Effect, Survey
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.stack import MOST_OFF, MOST_TURNED_RAD
from handcart.robotics.geometry.transform import inverse

LEANS_MM, LEANS_DEG = 2.5, 0.1  # tilt of the base while a landmark is observed, besides its sigma
FIXED_MM, FIXED_DEG = 6.0, 0.3  # fixed limits of where FIXATE finds the base
STACKED_MM = 1e3 * MOST_OFF + LIMIT_SIGMAS * 0.5  # STACK's own limit and its sensor's
STACKED_DEG = math.degrees(MOST_TURNED_RAD) + LIMIT_SIGMAS * 0.1
HEIGHT_MM, UPRIGHT_DEG = 5.0, 1.0  # of the foot from its goal; the base leans under the blocks on the robot
STACK_NAME = "STACK"


def _fixated(survey: Survey, _: Claim) -> list[str]:
    fixed, base = survey.run.model.of(Blocks).fixed, survey.run.base_on_map
    if fixed is None:
        return ["it isn't known where the base stands"]
    off, turned = fixed.pose.distance(base), math.degrees(fixed.pose.turn(base))
    far, askew = 1e3 * LIMIT_SIGMAS * fixed.sigma[0], math.degrees(LIMIT_SIGMAS * fixed.sigma[1])
    return [
        *at_most("the base is {:.1f} mm from where it was found", 1e3 * off, LEANS_MM + far, FIXED_MM),
        *at_most(
            "the base is turned {:.2f} deg against how it was found", turned, LEANS_DEG + askew, FIXED_DEG
        ),
    ]


def _picked_up(survey: Survey, claim: Claim) -> list[str]:
    held = survey.run.world.held
    name, wanted = held.name if held else None, f"block {claim.primitive.number}"
    return [] if name == wanted else [f"the hand holds {name}, not {wanted}"]


def _stacked(survey: Survey, claim: Claim) -> list[str]:
    scene, plan, number = survey.run.world, survey.run.model.of(Blocks).building, claim.primitive.number
    block = scene.of(BlockProps).blocks.get(str(number))
    if plan is None or block is None or block.rest.value not in ("table", "tray"):
        return [f"block {number} doesn't stand anywhere"]
    if claim.primitive.onto == "robot":
        off = inverse(plan.seat(number).pose) @ inverse(scene.world_T_base) @ block.pose
    else:
        off = inverse(plan.goals[number - 1].pose) @ block.pose
    tilt, turned = math.acos(min(1.0, off[2, 2])), math.atan2(off[1, 0], off[0, 0])
    turned = math.remainder(turned, math.pi)  # its two ends look the same
    return [
        *at_most("the block is {:.1f} mm from its goal", 1e3 * math.hypot(*off[:2, 3]), STACKED_MM),
        *at_most("the block is {:.1f} mm above or below its goal", 1e3 * abs(off[2, 3]), HEIGHT_MM),
        *at_most("the block is tilted by {:.1f} deg", math.degrees(tilt), UPRIGHT_DEG),
        *at_most("the block is turned by {:.1f} deg", math.degrees(abs(turned)), STACKED_DEG),
    ]


BLOCK_EFFECTS: Mapping[str, Effect] = {"FIXATE": _fixated, "PICK_UP_BLOCK": _picked_up, STACK_NAME: _stacked}
"""Effects by the primitive's name."""
