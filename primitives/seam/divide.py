"""DIVIDE: choose from where the rest of a seam is tracked."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.driving.driving import map_with_cells
from handcart.primitives.driving.standing_room import StandingRoom
from handcart.primitives.knowledge.bumps import avoided_points
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.seam import seam_causes
from handcart.primitives.seam.seam import Seam
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.alongside import level_with, place_alongside
from handcart.robotics.manipulation.placement.placements import Placements
from handcart.robotics.manipulation.placement.placer import Placer
from handcart.robotics.numerics.arrays import FloatArray

from .kept_divisions import KeptDivisions
from .seam_placer import placer_of
from .seam_work import DrivesTo, SeamPart, SeamWork

_KEPT = KeptDivisions()
WAY_CHECK_SPACING_M = 0.2  # of a way between looks at whether it is free


class Divide(ActionPrimitive):
    """Divide the untracked rest of the seam into parts, each tracked from one reachable place of the base.

    The robot does not move; only the model changes, in which the places get the names `place_1` and so on. A
    division is kept while the base can reach the next of its places. The untracked rest is divided again if
    an obstacle was sensed on the way to that place, or if the arm could not track its part of the seam from
    there.
    """

    placements: Annotated[int, Field(ge=1, le=50)]
    """Maximum number of places."""
    move_m: Annotated[float, Field(ge=0.0, le=100.0)] = 0.5
    """Required gain of one more place, in metres of seam tracked at the best instead of only just; only if
    the base is at rest.
    """
    base: Literal["stands", "drives"] = "stands"
    """Motion of the base while the tool is on the seam; `drives`: straight on from its place, level with the
    tool.
    """

    needs: ClassVar = (Arm,)
    reads: ClassVar = ("map", "seam", "work_piece", "obstacles", "sensed_cells", "bumps", "arm_bumps")
    writes: ClassVar = ("places", "seam_work", "detour")
    only_knowledge: ClassVar = True

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        known = model.of(Seam)
        seam, work = seam_of(model), known.seam_work
        boxes = tuple(box.box for box in known.work_piece.boxes) if known.work_piece else ()
        avoided = avoided_points(robot, model)
        grid = map_with_cells(model)
        room = StandingRoom(robot.spec, robot.arm_model, grid, avoided, robot.pose, boxes, work.avoided)
        if work.tracked == len(seam.points) - 1 or self._stays(work, room):
            self.found(kept=len(work.rest))
            return
        rest = seam.part(work.tracked, len(seam.points) - 1)
        found = yield from robot.compute(self._divided, robot, rest, room, work.tracked, takes=2.0)
        parts = _named(found, work, rest if self.base == "drives" else None)
        ends = {part.end.place: _place(part.end.pose) for part in parts if part.end is not None}
        model.places = {**model.places, **{part.place: _place(part.pose) for part in parts}, **ends}
        known.seam_work = work._replace(next=parts[0], after=parts[1:], named=work.named + len(parts))
        model.detour = None
        self.found(placements=len(parts), score=round(found.score / rest.length, 4))

    def _stays(self, work: SeamWork, room: StandingRoom) -> bool:
        """Return whether the next place of a division, and the straight way from it, are still free for the
        base.
        """
        return work.next is not None and not room.blocked(_way(work.next)).any()

    def divided(self, placer: Placer, rest: ToolPath, room: StandingRoom) -> Placements:
        """Return a division of the rest of a seam into parts, each with the base pose from which it is
        tracked.

        Args:
            placer: planner of base poses for the robot.
            rest: part of the seam that is not tracked yet, on the map.
            room: free poses of the base.

        Raises:
            Untrackable: a point of the seam cannot be tracked from any place.
        """
        if self.base == "drives":
            return place_alongside(placer, rest, room.blocked, self.placements, room.free)
        return placer.place(rest, room.blocked, self.placements, room.free, self.move_m)

    def _divided(self, robot: Robot, rest: ToolPath, room: StandingRoom, tracked: int) -> Placements:
        spec, how = robot.spec, f"{self.placements} {self.move_m} {self.base}"
        given = [item.encode() for item in (how, spec.model_dump_json(), spec.urdf_text())]
        path = [np.ascontiguousarray(item).tobytes() for item in rest]
        try:
            return _KEPT.division(
                (*given, *path, *room.key), lambda: self.divided(placer_of(spec), rest, room)
            )
        except Untrackable as error:
            line = error.index + tracked + 2
            nearest = (
                "" if error.nearest is None else f"; the nearest that can be reached: {_words(error.nearest)}"
            )
            raise Discrepancy(
                f"line {line} of the seam {error.why}{nearest}", permanent=True, cause=seam_causes.UNTRACKABLE
            ) from None


def seam_of(model: ModelView) -> ToolPath:
    """Return the task's seam, as a path of the tool; raise `Discrepancy` if the task has no seam."""
    work = model.of(Seam)
    if work.seam is None:
        raise Discrepancy("the task has no `seam` file", permanent=True, cause=causes.NOT_KNOWN)
    return work.seam


def _named(found: Placements, work: SeamWork, driven: ToolPath | None) -> tuple[SeamPart, ...]:
    """Return the parts of a division with named places; `driven`: the seam's rest, if the base drives."""
    parts = []
    for number, (segment, score) in enumerate(zip(found.segments, found.scores, strict=True), start=1):
        pose, name = Pose2(*found.bases[segment.placement].tolist()), f"place_{work.named + number}"
        first, last = (work.tracked + point for point in (segment.first, segment.last))
        part = SeamPart(name, pose, first, last, score)
        if driven is not None:
            way = level_with(pose, driven.points[segment.first : segment.last + 1])
            part = part._replace(end=DrivesTo(f"{name}_end", Pose2(*way[-1].tolist())))
        parts.append(part)
    return tuple(parts)


def _way(part: SeamPart) -> FloatArray:
    """Return map_T_base (k, 3) on the way of a part, both ends included: x, y in [m], heading in [rad]."""
    end = part.pose if part.end is None else part.end.pose
    count = 2 + int(part.pose.distance(end) / WAY_CHECK_SPACING_M)
    return np.linspace(part.pose, end, count) if part.end is not None else np.array([part.pose])


def _place(pose: Pose2) -> Place:
    return Place(x_m=pose.x, y_m=pose.y, heading_deg=math.degrees(pose.theta))


def _words(point: object) -> str:
    return "(" + ", ".join(f"{value:.3f}" for value in np.asarray(point)) + ") m"
