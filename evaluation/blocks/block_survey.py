"""Final places of blocks by the ground truth: the errors of Hatano et al. (2000), section 5."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.backends.simulation.blocks.block_props import BlockProps
from handcart.backends.simulation.world.suspension import leaning
from handcart.backends.simulation.world.thing import Rest
from handcart.evaluation.judging.survey import Survey, SurveyedRun
from handcart.primitives.blocks.blocks import Blocks, Fixed
from handcart.primitives.blocks.building import BlockPlace
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.outcomes.outcome import Outcome
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse, transform
from handcart.robotics.numerics.arrays import FloatArray

from .block_effects import BLOCK_EFFECTS, STACK_NAME, STACKED_MM
from .block_error import BlockError

SCALE_MM = 0.5  # of the paper's readings
FALLEN_MM = 30.0  # further away from its goal a block counts as not placed


class BaseAttitude(NamedTuple):
    """True heading and tilt of the base in a simulated world, in [rad]."""

    heading: float
    lean: tuple[float, float]


@dataclass(frozen=True)
class BlockNotes:
    """Observations of a `BlockSurvey` that a checkpoint stores, because a resumed run could not repeat
    them.
    """

    reference: tuple[float, tuple[float, float]] | None
    """Heading and tilt of the base at the fixation, as `BaseAttitude`; None before the first one."""
    gripped: dict[str, tuple[float, float, float]]
    released: dict[str, tuple[float, float, float]]
    moved: dict[str, tuple[float, float]]
    frames: int
    uncorrected: bool


class BlockSurvey(Survey):
    """Observer that evaluates the position errors of placed blocks, and the base's true attitude at each grip
    and release.
    """

    name = "blocks"
    effects = BLOCK_EFFECTS
    noted = BlockNotes
    limits: ClassVar = {"raw_error_mm_max": STACKED_MM}

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self.scene, self.model = run.world, run.model
        self._props = run.world.of(BlockProps)
        self.plan = run.model.of(Blocks).building if STACK_NAME in run.does else None
        """Building plan; None if no blocks are stacked."""
        self._frames, self._uncorrected = 0, True
        self._fixed: Fixed | None = None
        self._reference: BaseAttitude | None = None
        self._held: Any = None
        self._rested: dict[str, Rest] = {}
        self._gripped: dict[str, FloatArray] = {}
        """Shift (3,) of each block when it was gripped off a table, in the base frame, in [m]."""
        self._released: dict[str, FloatArray] = {}
        self._moved: dict[str, tuple[float, float]] = {}
        """Turn and lean of the base about x from the fixation to the release of each block, in [rad]."""

    @override
    def look(self, robot: Robot) -> None:
        blocks = self.model.of(Blocks)
        if blocks.fixed is not None and not _same_fix(blocks.fixed, self._fixed):
            self._reference = self._attitude()
        self._fixed = blocks.fixed
        held = self.scene.held
        if held is not self._held:
            if held is not None and self._rested.get(held.name) is Rest.TABLE:
                self._gripped[held.name] = self._shift(held)
            if self._held is not None and self._held.rest.value == "table":
                self._released[self._held.name] = self._shift(self._held)
                self._moved[self._held.name] = self._moved_since()
            self._held = held
        self._rested = {block.name: block.rest for block in self._props.blocks.values()}

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        self._frames += int(primitive.facts.get("frames", 0))
        if getattr(primitive, "onto", "") == "goal":
            self._uncorrected &= getattr(primitive, "method", "") == "fix_once"
        return []

    @override
    def notes(self) -> BlockNotes:
        gripped, released = (
            {name: tuple(shift.tolist()) for name, shift in item.items()}
            for item in (self._gripped, self._released)
        )
        reference = None if self._reference is None else (self._reference.heading, self._reference.lean)
        return BlockNotes(reference, gripped, released, self._moved, self._frames, self._uncorrected)

    @override
    def go_on(self, noted: BlockNotes) -> None:
        if noted.reference is not None:
            self._reference, self._fixed = BaseAttitude(*noted.reference), self.model.of(Blocks).fixed
        self._gripped = {name: np.array(shift) for name, shift in noted.gripped.items()}
        self._released = {name: np.array(shift) for name, shift in noted.released.items()}
        self._moved = dict(noted.moved)
        self._frames, self._uncorrected = noted.frames, noted.uncorrected

    def errors(self) -> list[BlockError]:
        """Return the position errors of all blocks that are on a table and within `FALLEN_MM` of their
        goals.
        """
        found = []
        for number, goal in enumerate(self.plan.goals if self.plan else (), start=1):
            block = self._props.blocks.get(str(number))
            if block is not None and block.rest.value == "table":
                error = self._error(number, goal, block)
                if error.size < FALLEN_MM:
                    found.append(error)
        return found

    def figures(self) -> dict[str, Any]:
        """Return metrics of the placed blocks' position errors, by name with unit; empty if no block is to be
        stacked.
        """
        if self.plan is None:
            return {}
        errors = self.errors()
        sizes = [error.size for error in errors]
        result: dict[str, Any] = {"blocks_placed": len(errors), "frames": self._frames}
        if errors:
            result["raw_error_mm_mean"] = round(float(np.mean(sizes)), 3)
            result["raw_error_mm_max"] = round(max(sizes), 3)
            if self._uncorrected:  # the method leaves the base's motion uncorrected
                result["processed_error_mm_max"] = round(max(error.processed for error in errors), 3)
        result["blocks"] = [
            {name: round(float(value), 3) for name, value in error._asdict().items()} for error in errors
        ]
        return result

    def faults(self) -> list[str]:
        """Return a message for each block that is more than `STACKED_MM` from its goal, and one with the
        number of missing blocks.

        Each message contradicts the Success of a complete run.
        """
        goals, errors = len(self.plan.goals) if self.plan else 0, self.errors()
        far = [
            f"block {error.number} is {error.size:.1f} mm off" for error in errors if error.size > STACKED_MM
        ]
        missing = goals - len(errors)
        return far + ([f"{missing} of {goals} blocks don't stand where they should"] if missing else [])

    @override
    def draw(self, folder: Path) -> None:
        errors = self.errors()
        if errors:
            from .stacking_plot import draw_stacking_errors

            draw_stacking_errors(errors, folder / "stacked.svg", STACKED_MM, self._uncorrected)

    def _attitude(self) -> BaseAttitude:
        return BaseAttitude(self.scene.base.theta, (self.scene.lean[0], self.scene.lean[1]))

    def _moved_since(self) -> tuple[float, float]:
        if self._reference is None:
            return 0.0, 0.0
        now = self._attitude()
        return now.heading - self._reference.heading, now.lean[0] - self._reference.lean[0]

    def _shift(self, block: Any) -> FloatArray:
        """Return the shift (3,) of a block's place by the base's turn and tilt since the fixation, in the
        base frame in [m].
        """
        if self._reference is None:
            return np.zeros(3)
        now, pivot = self._attitude(), self.scene.robot.errors.lean_pivot_m
        before = leaning(self._reference.lean, pivot)
        turned = transform(rpy=(0.0, 0.0, now.heading - self._reference.heading))
        after = turned @ leaning(now.lean, pivot)
        place = inverse(self.scene.world_T_base) @ block.pose[:, 3]
        return np.asarray(((after - before) @ place)[:3])

    def _error(self, number: int, goal: BlockPlace, block: Any) -> BlockError:
        actual = inverse(goal.pose) @ block.pose
        x, y, z = (-1e3 * float(value) for value in actual[:3, 3])
        turn = math.atan2(actual[1, 0], actual[0, 0])
        turn = (turn + math.pi / 2) % math.pi - math.pi / 2
        # The planned base heading is that of its place: shifts are small, so it serves for both.
        heading = self.scene.base.theta
        shift = self._released.get(block.name, np.zeros(3)).copy()
        # Along the closing axis the fingers centred the block, so only the other component was carried here.
        shift[1] -= self._gripped.get(block.name, np.zeros(3))[1]
        in_goal = Pose2(0.0, 0.0, heading - goal.floor.theta).apply(shift[None, :2])[0] * 1e3
        return BlockError(
            number,
            x,
            y,
            z,
            1e3 * turn,
            x + float(in_goal[0]),
            y + float(in_goal[1]),
            _on_scale(x),
            _on_scale(y),
            *(1e3 * item for item in self._moved.get(block.name, (0.0, 0.0))),
        )


def _same_fix(fixed: Fixed, other: Fixed | None) -> bool:
    return fixed is other or (other is not None and fixed._replace(swings=0) == other._replace(swings=0))


def _on_scale(value: float) -> float:
    return SCALE_MM * round(value / SCALE_MM)
