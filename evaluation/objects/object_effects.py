"""Effects that a Success of primitives for objects promises."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.evaluation.judging.at_most import at_most
from handcart.evaluation.judging.sensor_sigmas import LIMIT_SIGMAS
from handcart.evaluation.judging.survey import Claim, Effect, Survey
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.objects.knowledge.object_names import name_in_world
from handcart.primitives.objects.knowledge.objects import Objects, ObjectSighting
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import apply, inverse

SEEN_MM, SEEN_DEG = 25.0, 3.0  # fixed limits of where PLACE sees an object; LOOK_FOR states its own
LOOK_TOLERANCE_MM, LOOK_TOLERANCE_DEG = 3.0, 0.3  # beside the claimed uncertainty
SPOT_MM = 30.0  # fixed limit of an object from its spot: PLACE's own limit, and the base's pose
HEIGHT_MM = 6.0  # of a foot over the surface
UPRIGHT_DEG = 3.0
POSTURE_DEG, POSTURE_MM = 1.0, 5.0  # of a joint from its posture
OUTLINE_MM = 10.0  # that the hand may be outside of the robot's outline


def thing_of(survey: Survey, name: str) -> Thing | None:
    """Return an object of the world in the run that `survey` evaluates; None if the name is unknown."""
    wanted = name_in_world(name)
    return next((thing for thing in survey.run.world.things() if thing.name == wanted), None)


def true_surface(survey: Survey, name: str) -> ObjectSurface:
    """Return a surface, with its named places for objects, at its true pose in the simulated world.

    The true pose is that of the simulated solid with the name and size of the surface. If the world has no
    such solid, the pose in the file of objects is used. `survey` gives access to the run and its world.
    """
    surface = survey.run.model.of(Objects).objects.surfaces[name]
    for solid in survey.run.world.solids:
        box = solid.box
        if box.name == name and np.allclose(box.size[:2], surface.size_m, atol=1e-3):
            heading = math.atan2(box.pose[1, 0], box.pose[0, 0])
            return surface.moved_to(Pose2(float(box.pose[0, 3]), float(box.pose[1, 3]), heading))
    return surface


def sighting_errors(thing: Thing, seen: ObjectSighting) -> tuple[float, float]:
    """Return the distance in [mm] and angle in [deg] between an object's sighted and true pose."""
    x, y = thing.pose[:2, 3].tolist()
    yaw = math.atan2(thing.pose[1, 0], thing.pose[0, 0])
    turned = abs(math.remainder(seen.pose.theta - yaw, 2.0 * math.pi))
    return 1e3 * math.hypot(seen.pose.x - x, seen.pose.y - y), math.degrees(turned)


def _false_sighting(
    survey: Survey, name: str, most_mm: float = SEEN_MM, most_deg: float = SEEN_DEG
) -> list[str]:
    """Return how a sighting is off by more than is claimed, or by more than the fixed limits."""
    thing, seen = thing_of(survey, name), survey.run.model.of(Objects).seen(name)
    if thing is None or seen is None:
        return [f"{name} is nowhere" if thing is None else f"it isn't known where {name} is"]
    off, turned = sighting_errors(thing, seen)
    covariance = np.array(seen.covariance)
    sigma = 1e3 * math.sqrt(max(np.linalg.eigvalsh(covariance[:2, :2]).max(), 0.0))
    heading = math.degrees(math.sqrt(max(covariance[2, 2], 0.0)))
    turned = _apart(turned, survey, name)
    return [
        *at_most(
            "it is {:.1f} mm from where it was seen", off, LOOK_TOLERANCE_MM + LIMIT_SIGMAS * sigma, most_mm
        ),
        *at_most(
            "it is turned {:.2f} deg against how it was seen",
            turned,
            LOOK_TOLERANCE_DEG + LIMIT_SIGMAS * heading,
            most_deg,
        ),
    ]


def _apart(turned: float, survey: Survey, name: str) -> float:
    """Return an error of a heading in [deg], reduced by turns after which the object looks the same.

    Args:
        turned: the error, in [deg].
        survey: survey that knows the file of objects.
        name: name of the object.
    """
    file = survey.run.model.of(Objects).objects
    kind = file.kind_of(name)
    if kind.is_round:
        return 0.0
    if file.tags_of(name):
        return turned
    step = 90.0 if kind.size_mm[0] == kind.size_mm[1] else 180.0
    return abs(math.remainder(turned, step))


def _found(survey: Survey, claim: Claim) -> list[str]:
    asked = claim.primitive
    return _false_sighting(survey, asked.object, asked.tolerance_mm, asked.tolerance_deg)


def _picked(survey: Survey, claim: Claim) -> list[str]:
    held, wanted = survey.run.world.held, name_in_world(claim.primitive.object)
    name = held.name if held else None
    return [] if name == wanted else [f"the hand holds {name}, not {wanted}"]


def _placed(survey: Survey, claim: Claim) -> list[str]:
    """Check that the object is on its surface, upright, near its spot, where it was seen.

    A spot is where the true surface has it: the file may be wrong about where a table is.
    """
    name = claim.primitive.thing(survey.run.model.view(claim.primitive)).removeprefix(name_in_world(""))
    thing, surface = thing_of(survey, name), true_surface(survey, claim.primitive.surface)
    if thing is None or thing.rest is not Rest.TABLE:
        return [f"{name or 'the object'} doesn't stand on anything"]
    x, y, z = thing.pose[:3, 3].tolist()
    wrong = _false_sighting(survey, name)
    if surface.margin(x, y) < 0.0:
        wrong.append(f"{name} doesn't stand on {claim.primitive.surface}")
    wrong += at_most(
        "its foot is {:.1f} mm off the surface", 1e3 * abs(z - surface.height_m), HEIGHT_MM, HEIGHT_MM
    )
    wrong += at_most("it is tilted by {:.1f} deg", math.degrees(thing.tilt()), UPRIGHT_DEG, UPRIGHT_DEG)
    if claim.primitive.spot is not None:
        spot = surface.spots[claim.primitive.spot]
        away = 1e3 * math.hypot(x - spot.x_m, y - spot.y_m)
        wrong += at_most("it is {:.1f} mm from its spot", away, SPOT_MM, SPOT_MM)
    return wrong


def _stowed(survey: Survey, _: Claim) -> list[str]:
    scene = survey.run.world
    hand = apply(inverse(scene.world_T_base), scene.world_T("hand")[None, :3, 3])
    away = 1e3 * float(scene.robot.footprint_shape.distances(hand[:, :2])[0])
    return at_most("the hand is {:.1f} mm outside of the robot's outline", away, OUTLINE_MM, OUTLINE_MM)


def _in_posture(survey: Survey, claim: Claim) -> list[str]:
    """Check that the true joints are those of the posture."""
    scene = survey.run.world
    off = np.abs(scene.joints - np.array(scene.robot.posture(claim.primitive.posture)))
    slides = np.array(scene.robot.joint_units.slides, dtype=np.bool_)
    turned = math.degrees(float(off[~slides].max(initial=0.0)))
    slid = 1e3 * float(off[slides].max(initial=0.0))
    return [
        *at_most("a joint is {:.1f} deg from the posture", turned, POSTURE_DEG, POSTURE_DEG),
        *at_most("a sliding joint is {:.1f} mm from the posture", slid, POSTURE_MM, POSTURE_MM),
    ]


def _handed_over(survey: Survey, claim: Claim) -> list[str]:
    """Check that a person has the object."""
    name = claim.primitive.thing(survey.run.model.view(claim.primitive)).removeprefix(name_in_world(""))
    thing = thing_of(survey, name)
    if thing is None:
        return [f"{name or 'the object'} is nowhere"]
    return [] if thing.rest is Rest.PERSON else [f"no person has {name}, the {thing.carrier} has it"]


OBJECT_EFFECTS: Mapping[str, Effect] = {
    "LOOK_FOR": _found,
    "PICK": _picked,
    "PLACE": _placed,
    "STOW": _stowed,
    "MOVE_ARM": _in_posture,
    "HAND_OVER": _handed_over,
}
"""Effects by the primitive's name."""
