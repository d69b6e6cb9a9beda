"""Effects that a Success of primitives for doors promises."""

from __future__ import annotations

from collections.abc import Mapping

from handcart.evaluation.judging.at_most import at_most
from handcart.evaluation.judging.sensor_sigmas import LIMIT_SIGMAS
from handcart.evaluation.judging.survey import Claim, Effect, Survey
from handcart.primitives.doors.doors import Doors

from .door_truth import door_of, hinge_errors, true_opening

OPENED_MM = 10.0  # of the handle from the noted opening, along its path
CLOSED_MM = 12.0  # of the handle from its closed place
HINGE_TOLERANCE_MM, HINGE_MM = 3.0, 80.0  # beside the claimed uncertainty, and fixed


def _opened(survey: Survey, claim: Claim) -> list[str]:
    """Check that the door is as open as was noted and at least as open as asked, and check its hinge.

    What was asked is only compared where the file says rightly whether the door is hinged or sliding.
    """
    name = claim.primitive.door
    part, state = door_of(survey, name), survey.run.model.of(Doors).state_of(name)
    if part is None or state is None:
        return [f"{name} is no door" if part is None else f"it isn't known how open {name} is"]
    joint, opened = part.spec.true_joint(), true_opening(survey, name)
    kind = "sliding" if joint.hinge is None else "hinged"
    if state.motion not in (kind, "undetermined"):
        return [f"{name} is {kind}, not {state.motion}"]
    wrong = []
    if state.motion == kind:
        off = 1e3 * abs(joint.travel(opened - state.opened))
        wrong += at_most("its handle is {:.1f} mm from where it was left", off, OPENED_MM, OPENED_MM)
    if survey.run.model.of(Doors).doors.doors[name].motion == kind:
        short = 1e3 * (joint.travel(claim.primitive.wanted(joint)) - joint.travel(opened))
        wrong += at_most("its handle is {:.1f} mm short of what was asked", short, OPENED_MM, OPENED_MM)
    errors = hinge_errors(survey, claim.primitive, joint)
    if errors is not None:
        sigma = float(claim.primitive.facts["hinge_sigma_mm"])
        wrong += at_most(
            "its hinge is {:.1f} mm from where it was found",
            errors.place_mm,
            HINGE_TOLERANCE_MM + LIMIT_SIGMAS * sigma,
            HINGE_MM,
        )
    return wrong


def _closed(survey: Survey, claim: Claim) -> list[str]:
    name = claim.primitive.door
    part = door_of(survey, name)
    if part is None:
        return [f"{name} is no door"]
    left = 1e3 * abs(part.spec.true_joint().travel(true_opening(survey, name)))
    return at_most("its handle is {:.1f} mm from its closed place", left, CLOSED_MM, CLOSED_MM)


DOOR_EFFECTS: Mapping[str, Effect] = {"OPEN": _opened, "CLOSE": _closed}
"""Effects by the primitive's name."""
