"""Effects that a Success of seam primitives promises."""

from __future__ import annotations

import math
from collections.abc import Mapping

from handcart.evaluation.judging.at_most import at_most
from handcart.evaluation.judging.survey import Claim, Effect, Survey
from handcart.primitives.seam.seam import Seam

TRACKED_MM = 45.0  # of the base from a place of the division, which its arm makes good


def _divided(survey: Survey, _: Claim) -> list[str]:
    next_place = survey.run.model.of(Seam).seam_work.next
    return [] if next_place is not None else ["no place is known to track the seam from"]


def _tracked(survey: Survey, _: Claim) -> list[str]:
    model, base = survey.run.model, survey.run.base_on_map
    stood = [place.pose for name, place in model.places.items() if name.startswith("place_")]
    far = min((base.distance(pose) for pose in stood), default=math.inf)
    wrong = [] if model.of(Seam).seam_work.tracked > 0 else ["no part of the seam counts as tracked"]
    return wrong + at_most("the base is {:.1f} mm from any place of the division", 1e3 * far, TRACKED_MM)


SEAM_EFFECTS: Mapping[str, Effect] = {"DIVIDE": _divided, "TRACK": _tracked}
"""Effects by the primitive's name."""
