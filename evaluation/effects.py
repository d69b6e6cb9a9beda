"""Whether what a primitive claims to have done is done, by the ground truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from handcart.backends.robot import Robot
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.stack import MOST_OFF
from handcart.primitives.books.books import Books
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.driving.move_to import ARRIVED, DOCKED
from handcart.primitives.field.field_work import FieldWork
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.seam.seam import Seam
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.navigation.pose_regulator import PoseTolerance
from handcart.robotics.perception.call_number import parse

from .ground_truth import GroundTruth, disturbed, ground_truth, scene_of
from .sensor_sigmas import SIGMAS
from .shelving import MOST_PUSHED_MM, Shelving, longest_rising

SEEN_MM = 8.0  # that a book may be seen away from where it stands
SLOT_MM = 15.0  # the same of a slot's middle, along the shelf
EDGE_MM = 8.0  # that a leading edge may be beside the middle of its slot: further out it jams
FIXED_MM, FIXED_DEG = 6.0, 0.3  # that a landmark may tell wrongly of the base: it leans meanwhile
STACKED_MM = 1e3 * MOST_OFF + SIGMAS * 0.5  # STACK's own limit and its sensor's
STOOD_MM, STOOD_DEG = 5.0, 0.3  # that a base creeps which stands
TRACKED_MM = 45.0  # of the base from a place of the division, which its arm makes good
LAID_MM = 30.0  # by which a sensor shifts while it is let go, on uneven ground
CAR_ARRIVED = PoseTolerance(position=0.25, heading=0.15)
"""What a car's MOVE_TO means by arrived: nothing is regulated at the end, it can't move sideways."""

Effect = Callable[[Any, Any, WorldModel], list[str]]


def false_effect(
    primitive: ActionPrimitive, robot: Robot, model: WorldModel, before: GroundTruth
) -> list[str]:
    """What of a Success isn't so; of primitives that aren't known here, only what they disturbed."""
    after = ground_truth(robot.backend)
    if after is None:
        return []
    wrong = [
        f"it moved {each} mm (at most {MOST_PUSHED_MM:.0f})"
        for each in disturbed(before, after, MOST_PUSHED_MM, _own(primitive, model, before, after))
    ]
    own_word = getattr(primitive, "false_effect", None)
    if own_word is not None:
        return wrong + list(own_word(scene_of(robot.backend), before))
    if primitive.label() == "MOVE_TO":
        return wrong + _move_to(robot, primitive, model)
    if primitive.label() == "STAND":
        return wrong + _stand(before, after)
    promised = EFFECTS.get(primitive.label())
    return wrong + (promised(scene_of(robot.backend), primitive, model) if promised else [])


def _own(primitive: ActionPrimitive, model: WorldModel, before: GroundTruth, after: GroundTruth) -> set[str]:
    """What a primitive may move: what the hand holds before or after, or is to touch."""
    held = {name for each in (before, after) for name, body in each.bodies.items() if body.support == "hand"}
    meant = [each for each in primitive.meant_contacts(model) if each.part == "hand"]
    return held | {name for name in before.bodies if any(each.covers("hand", name) for each in meant)}


def arrival(robot: Robot, place: str, model: WorldModel) -> tuple[float, float]:
    """How far the base truly is from a place, in [mm] and in [deg]."""
    goal, base = model.places[place].pose, scene_of(robot.backend).base
    return 1e3 * goal.distance(base), math.degrees(goal.turn(base))


def _move_to(robot: Robot, primitive: Any, model: WorldModel) -> list[str]:
    """What was claimed is within a tolerance by what measured it."""
    off, turned = arrival(robot, primitive.place, model)
    sigma, heading_sigma = robot.pose_sigma
    if not math.isfinite(sigma):
        return ["it isn't known where the base is"]
    claimed = _claimed(robot, primitive.place, model)
    far = 1e3 * (claimed.position + SIGMAS * sigma)
    askew = math.degrees(claimed.heading + SIGMAS * heading_sigma)
    return [
        *_most("the base is {:.1f} mm from its place", off, far),
        *_most("the base is {:.2f} deg off", turned, askew),
    ]


def _claimed(robot: Robot, place: str, model: WorldModel) -> PoseTolerance:
    if robot.spec.drive.kind == "ackermann":
        return CAR_ARRIVED
    return ARRIVED if model.places[place].shelf is None else DOCKED


def _stand(before: GroundTruth, after: GroundTruth) -> list[str]:
    return [
        *_most("the base moved by {:.1f} mm", 1e3 * before.base.distance(after.base), STOOD_MM),
        *_most("the base turned by {:.2f} deg", math.degrees(before.base.turn(after.base)), STOOD_DEG),
    ]


def _recognize(scene: Any, _: Any, model: WorldModel) -> list[str]:
    books = model.of(Books)
    book = scene.tray_book()
    if book is None or books.book is None or books.book_pose is None:
        return ["no book stands on the tray, or none is known"]
    if book.accession != books.book.accession:
        return [f"book {book.accession} stands on the tray, not {books.book.accession}"]
    place = (inverse(scene.world_T_base) @ book.pose)[:2, 3]
    off = 1e3 * math.dist(place, books.book_pose[:2])
    return _most("the book is {:.1f} mm from where it was seen", off, SEEN_MM)


def _pick_up(scene: Any, _: Any, model: WorldModel) -> list[str]:
    books = model.of(Books)
    held = scene.held.accession if scene.held else None
    wanted = books.book.accession if books.book else None
    return [] if held is not None and held == wanted else [f"the hand holds {held}, not {wanted}"]


def _search(scene: Any, primitive: Any, model: WorldModel) -> list[str]:
    books = model.of(Books)
    slot = books.slot
    if slot is None or books.book is None:
        return ["no slot is known"]
    row = scene.shelf_books(slot.shelf)
    middle = 0.5 * (slot.left + slot.right)
    sides = _gap_at(scene, slot.shelf, middle)
    wrong = _most("the slot's middle is {:.1f} mm off", 1e3 * abs(middle - 0.5 * sum(sides)), SLOT_MM)
    at = sum(each.lateral > middle for each in row)
    calls = [each.book.spec.call for each in row]
    fits = _in_order(calls[:at], calls[at:], books.book.call)
    return wrong if fits else [*wrong, "the slot is not where the book belongs"]


def _approach(scene: Any, primitive: Any, model: WorldModel) -> list[str]:
    if scene.held is None:
        return ["the hand holds nothing"]
    pose = inverse(scene.shelves[primitive.shelf].pose) @ scene.held.pose
    edge = float(pose[1, 3] + pose[1, 0] * scene.held.depth)
    middle = 0.5 * sum(_gap_at(scene, primitive.shelf, edge))
    return _most("the leading edge is {:.1f} mm beside its slot's middle", 1e3 * abs(edge - middle), EDGE_MM)


def _insert(scene: Any, primitive: Any, model: WorldModel) -> list[str]:
    if scene.held is None:
        return ["the hand holds nothing"]
    pose = inverse(scene.shelves[primitive.shelf].pose) @ scene.held.pose
    left, right = _gap_at(scene, primitive.shelf, float(pose[1, 3]))
    half = scene.held.thickness / 2
    inside = right - 1e-3 <= pose[1, 3] - half and pose[1, 3] + half <= left + 1e-3
    wrong = [] if inside else ["the book isn't between the sides of a slot"]
    return wrong + _most("the spine stands {:.1f} mm before the shelf", -1e3 * float(pose[0, 3]), 60.0)


def _release(scene: Any, _: Any, model: WorldModel) -> list[str]:
    books = model.of(Books)
    stands = Shelving((books.book.accession,) if books.book else (), {}).judge(scene)
    return [] if stands.right else [f"the book doesn't stand in its place: {stands}"]


def _modify(_: Any, primitive: Any, model: WorldModel) -> list[str]:
    known = model.detour is not None and model.detour.goal == primitive.place
    return [] if known else ["no other way is known"]


def _fixate(scene: Any, _: Any, model: WorldModel) -> list[str]:
    blocks = model.of(Blocks)
    if blocks.fixed is None:
        return ["it isn't known where the base stands"]
    off, turned = blocks.fixed.pose.distance(scene.base), blocks.fixed.pose.turn(scene.base)
    return [
        *_most("the base is {:.1f} mm from where it was found", 1e3 * off, FIXED_MM),
        *_most("the base is turned {:.2f} deg against how it was found", math.degrees(turned), FIXED_DEG),
    ]


def _pick_up_block(scene: Any, primitive: Any, _: WorldModel) -> list[str]:
    held, wanted = scene.held.name if scene.held else None, f"block {primitive.number}"
    return [] if held == wanted else [f"the hand holds {held}, not {wanted}"]


def _stack(scene: Any, primitive: Any, model: WorldModel) -> list[str]:
    blocks = model.of(Blocks)
    block = scene.blocks.get(str(primitive.number))
    if blocks.building is None or block is None or block.rest.value not in ("table", "tray"):
        return [f"block {primitive.number} doesn't stand anywhere"]
    if primitive.onto == "robot":
        seat = blocks.building.seat(primitive.number).pose
        off = inverse(seat) @ inverse(scene.world_T_base) @ block.pose
    else:
        off = inverse(blocks.building.goals[primitive.number - 1].pose) @ block.pose
    return _most("the block is {:.1f} mm from its goal", 1e3 * math.hypot(*off[:2, 3]), STACKED_MM)


def _divide(_: Any, __: Any, model: WorldModel) -> list[str]:
    return [] if model.of(Seam).seam_work.next is not None else ["no place is known to track the seam from"]


def _track(scene: Any, primitive: Any, model: WorldModel) -> list[str]:
    stood = [place.pose for name, place in model.places.items() if name.startswith("place_")]
    far = min((scene.base.distance(pose) for pose in stood), default=math.inf)
    wrong = [] if model.of(Seam).seam_work.tracked > 0 else ["no part of the seam counts as tracked"]
    return wrong + _most("the base is {:.1f} mm from any place of the division", 1e3 * far, TRACKED_MM)


def _deploy(scene: Any, primitive: Any, model: WorldModel) -> list[str]:
    """The sensor stands on the ground, where it is believed to and should, as far as that is known."""
    work = model.of(FieldWork)
    laid = next((each for each in work.laid if each.name == primitive.target), None)
    if laid is None:
        return ["no sensor counts as laid there"]
    block = scene.sensors.get(str(1 + work.laid.index(laid)))
    if block is None or block.rest.value != "table":
        return ["the sensor doesn't stand on the ground"]
    target, lies = work.targets[primitive.target], block.pose[:2, 3]
    sigma = 1e3 * math.sqrt(float(np.linalg.eigvalsh(laid.spread)[-1]))
    from_belief = 1e3 * math.dist(lies, (laid.x, laid.y))
    from_target = 1e3 * math.dist(lies, (target.x, target.y))
    return [
        *_most(
            "the sensor is {:.0f} mm from where it is believed to be", from_belief, LAID_MM + SIGMAS * sigma
        ),
        *_most("the sensor is {:.0f} mm from its target", from_target, LAID_MM + SIGMAS * sigma),
    ]


def _in_order(left: list[str], right: list[str], own: str) -> bool:
    """Whether a call number fits between those left and those right of it that stand in order themselves."""
    numbers = [(parse(call), at < len(left)) for at, call in enumerate(left + right)]
    known = [(number, is_left) for number, is_left in numbers if number is not None]
    row = [known[i] for i in longest_rising([number for number, _ in known])]
    wanted = parse(own)
    return wanted is not None and all((number < wanted) == is_left for number, is_left in row)


def _gap_at(scene: Any, shelf: str, y: float) -> tuple[float, float]:
    """Left and right side, y in S in [m], of the gap between the books' middles about `y`."""
    half = scene.shelves[shelf].half_width
    sides = [(right, left) for right, left, _ in scene.shelves[shelf].fixed_intervals()]
    row = [each for each in scene.shelf_books(shelf) if each.book is not scene.held]
    half_books = [(each.lateral, each.book.thickness / 2) for each in row]
    sides += [(middle - half, middle + half) for middle, half in half_books]
    left = min((right for right, left in sides if 0.5 * (right + left) > y), default=half)
    right = max((left for right, left in sides if 0.5 * (right + left) <= y), default=-half)
    return left, right


def _most(words: str, size: float, most: float) -> list[str]:
    return [] if size <= most else [f"{words.format(size)} (at most {most:.1f})"]


EFFECTS: Mapping[str, Effect] = {
    "RECOGNIZE": _recognize,
    "PICK_UP": _pick_up,
    "MODIFY": _modify,
    "SEARCH": _search,
    "APPROACH": _approach,
    "INSERT": _insert,
    "RELEASE": _release,
    "FIXATE": _fixate,
    "PICK_UP_BLOCK": _pick_up_block,
    "STACK": _stack,
    "DIVIDE": _divide,
    "TRACK": _track,
    "DEPLOY": _deploy,
}
"""By the primitive's name. Somebody else's primitive may have a method `false_effect(scene, before)` instead,
which says in words what its Success promises and isn't so."""
