"""FIXATE: measure the pose of the base at a landmark."""

from __future__ import annotations

from collections.abc import Generator
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.robot.robot import Robot
from handcart.files.suggest import suggest
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.building import LandmarkName
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.from_above import gripped
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.restoring.snapshot import is_holding

from .base_turn import turn_by_gyros
from .building import LandmarkPlan
from .building_site import building, surroundings
from .fixating import Rule, fixate, fixed_by, planned_view, sought, upright, upright_sigma

MOST_TURNED = 0.002  # [rad] that the base may turn once it was found


class Fixate(ActionPrimitive):
    """Bring a landmark to the middle of the hand camera's picture, and compute the base's pose error by it.

    The method is that of Hatano et al. (2000), section 2.2, with corrected equations. The middle of the
    picture has the least distortion of the lens, and a closed loop tolerates errors of the arm. A landmark
    out of view is searched for. All landmarks look alike; a visible one is identified by its neighbours, the
    building plan and the estimated pose of the base. If a visible landmark may be either of two, the camera
    views the surroundings of both until only one of the two is possible.
    """

    landmark: LandmarkName
    """Name of the landmark in the building plan."""
    place: PlaceName | None = None
    """Target place of the base (default: the place from which the plan views the landmark)."""
    rule: Rule = "residual"
    """Stop rule of the hand; `residual` stops within 0.5 mm and 3.5 mrad and includes the remaining error
    in the result; `paper` stops within 0.5 mm and 0.2 rad, and ignores it.
    """
    looks: Annotated[int, Field(ge=1, le=10)] = 4
    """Minimum number of views over the landmark; the error is their mean."""
    search: bool = True
    """Search for a landmark that is out of view."""

    needs: ClassVar = (Arm, Camera)
    reads: ClassVar = ("places", "building", "placed", "taken")
    writes: ClassVar = ("fixed",)

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        blocks = model.of(Blocks)
        mark = landmark_of(model, self.landmark)
        place = self.place or mark.place
        planned = model.places[place].pose
        view = planned_view(robot, mark, planned)
        around = surroundings(robot, model)
        marks = building(model).landmarks
        wanted = sought(self.landmark, marks, planned, robot.pose, robot.localization.covariance)
        held = gripped(robot, building(model).block) if is_holding(robot) else None
        found = yield from fixate(
            robot, view, wanted, self.rule, self.evidence, held, around, self.search, self.looks
        )
        x, y, turn = found.planned_T_base
        self.found(
            error_x_mm=round(1e3 * x, 2),
            error_y_mm=round(1e3 * y, 2),
            error_mrad=round(1e3 * turn, 2),
            frames=found.frames,
            moves=found.moves,
        )
        blocks.fixed = fixed_by(robot, self.landmark, place, planned, found)
        pose = upright(blocks.fixed, robot.spec.suspension.model, mark.height_m, np.eye(4))
        robot.localization.found_at(pose, upright_sigma(blocks.fixed, pose))

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the base has kept its pose since the fixation.

        A robot with gyros must have measured no turn since then; without gyros, True is returned.
        """
        blocks = model.of(Blocks)
        fixed, feels = blocks.fixed, robot.spec.imu is not None
        if fixed is not None and feels and abs(turn_by_gyros(robot, fixed).yaw) >= MOST_TURNED:
            blocks.fixed = None  # no longer so
        return blocks.fixed is not None
        yield


def landmark_of(model: ModelView, name: str) -> LandmarkPlan:
    """Return a landmark of the building plan; raises `Discrepancy` if the plan has none of that name."""
    marks = building(model).landmarks
    if name not in marks:
        raise Discrepancy(
            f"the building plan has no landmark {name!r}{suggest(name, marks)}",
            permanent=True,
            cause=causes.NOT_KNOWN,
        )
    return marks[name]
