"""Effects that a Success of field primitives promises."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from handcart.backends.simulation.field.field_props import FieldProps
from handcart.evaluation.judging.at_most import at_most
from handcart.evaluation.judging.sensor_sigmas import LIMIT_SIGMAS
from handcart.evaluation.judging.survey import Claim, Effect, Survey
from handcart.primitives.field.field_work import FieldWork

LAID_MM = 30.0  # by which a sensor shifts while it is let go, on uneven ground
DEPLOY_NAME = "DEPLOY"


def _deployed(survey: Survey, claim: Claim) -> list[str]:
    """Compare the sensor's true place with the estimate and with the target.

    The fixed limit uses the sigma that DEPLOY had to wait for (`sure_mm`), not the claimed one.
    """
    model, name = survey.run.model, claim.primitive.target
    work = model.of(FieldWork)
    laid = next((item for item in work.laid if item.name == name), None)
    if laid is None:
        return ["no sensor counts as laid there"]
    block = survey.run.world.of(FieldProps).sensors.get(str(1 + work.laid.index(laid)))
    if block is None or block.rest.value != "table":
        return ["the sensor doesn't stand on the ground"]
    target, lies = work.targets[name], block.pose[:2, 3]
    most = LAID_MM + LIMIT_SIGMAS * 1e3 * math.sqrt(float(np.linalg.eigvalsh(laid.spread)[-1]))
    fixed = LAID_MM + LIMIT_SIGMAS * claim.primitive.sure_mm
    from_belief = 1e3 * math.dist(lies, (laid.x, laid.y))
    from_target = 1e3 * math.dist(lies, (target.x, target.y))
    return [
        *at_most("the sensor is {:.0f} mm from where it is believed to be", from_belief, most, fixed),
        *at_most("the sensor is {:.0f} mm from its target", from_target, most, fixed),
    ]


FIELD_EFFECTS: Mapping[str, Effect] = {DEPLOY_NAME: _deployed}
"""Effects by the primitive's name."""
