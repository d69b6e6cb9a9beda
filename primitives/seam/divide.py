"""DIVIDE: choose from where the rest of a seam is tracked."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.discrepancy import Discrepancy
from handcart.primitives.driving.standing_room import StandingRoom
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.seam.seam import Seam
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.placement.placer import Placements, Placer
from handcart.robotics.manipulation.placement.untrackable import Untrackable
from handcart.robotics.manipulation.tracking.tool_path import ToolPath

from .seam_placer import placer_of
from .seam_work import SeamPart, SeamWork


class Divide(ActionPrimitive):
    """Divide the rest of the seam among places that the base gets to, each part where the arm does it best.

    Only knowledge changes: the places get names, `place_1` and so on. A division whose next place can still
    be reached stays as it is. Where something was sensed on the way, or the arm couldn't do its part, the
    rest is divided anew.
    """

    placements: Annotated[int, Field(ge=1, le=50)]
    """Among how many places at most."""
    move_m: Annotated[float, Field(ge=0.0, le=100.0)] = 0.5
    """What one more place has to gain, in metres of seam tracked at the best instead of only just."""

    needs: ClassVar = (Arm,)
    reads: ClassVar = ("map", "seam", "work_piece", "obstacles")
    writes: ClassVar = ("places", "seam_work", "detour")
    only_knowledge: ClassVar = True

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        known = model.of(Seam)
        seam, work = seam_of(model), known.seam_work
        boxes = tuple(each.box for each in known.work_piece.boxes) if known.work_piece else ()
        room = StandingRoom(
            robot.spec, robot.arm_model, model.map, model.obstacles, robot.pose, boxes, work.avoided
        )
        if work.tracked == len(seam.points) - 1 or self._stays(work, room):
            self.found(kept=len(work.rest))
            return
        placer = placer_of(robot.spec)
        rest = seam.part(work.tracked, len(seam.points) - 1)
        found = yield from robot.compute(self._divided, placer, rest, room, work.tracked, takes=2.0)
        parts = _named(found, work, seam)
        model.places = {**model.places, **{part.place: _place(part) for part in parts}}
        known.seam_work = SeamWork(work.tracked, parts[0], parts[1:], work.named + len(parts), work.avoided)
        model.detour = None
        self.found(placements=len(parts), score=round(found.score / rest.length, 4))

    def _stays(self, work: SeamWork, room: StandingRoom) -> bool:
        """Whether the next place of a division can still be stood at."""
        return work.next is not None and not room.blocked(np.array([work.next.pose]))[0]

    def _divided(self, placer: Placer, rest: ToolPath, room: StandingRoom, tracked: int) -> Placements:
        try:
            return placer.place(rest, room.blocked, self.placements, room.free, self.move_m)
        except Untrackable as error:
            line = error.index + tracked + 2
            nearest = (
                "" if error.nearest is None else f"; the nearest that can be reached: {_words(error.nearest)}"
            )
            raise Discrepancy(f"line {line} of the seam {error.why}{nearest}", permanent=True) from None


def seam_of(model: ModelView) -> ToolPath:
    """The seam; raises `Discrepancy` where the task tells none."""
    work = model.of(Seam)
    if work.seam is None:
        raise Discrepancy("the task tells no seam", permanent=True)
    return work.seam


def _named(found: Placements, work: SeamWork, seam: ToolPath) -> tuple[SeamPart, ...]:
    parts = []
    for number, (segment, score) in enumerate(zip(found.segments, found.scores, strict=True), start=1):
        pose = Pose2(*found.bases[segment.placement].tolist())
        first, last = (work.tracked + point for point in (segment.first, segment.last))
        parts.append(SeamPart(f"place_{work.named + number}", pose, first, last, score))
    return tuple(parts)


def _place(part: SeamPart) -> Place:
    return Place(x_m=part.pose.x, y_m=part.pose.y, heading_deg=math.degrees(part.pose.theta))


def _words(point: object) -> str:
    return "(" + ", ".join(f"{value:.3f}" for value in np.asarray(point)) + ") m"
