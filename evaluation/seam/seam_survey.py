"""Accuracy of a tracked seam, by the ground truth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.evaluation.judging.at_most import at_most
from handcart.evaluation.judging.survey import Survey, SurveyedRun
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.motions.working_arm import working_arm
from handcart.primitives.outcomes.outcome import Outcome, Success
from handcart.primitives.seam.seam import Seam
from handcart.primitives.seam.track import MOST_OFF, Track
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.tracking.tracking_limits import ArmLoad, LimitUse
from handcart.robotics.numerics.arrays import FloatArray

from .seam_effects import SEAM_EFFECTS

ROUNDING_M = 1e-9
SENSOR_ERROR_M = 0.0015  # [m]: five sigma of positioning and arm, beyond what TRACK allows


class SeamStretch:
    """Record of joints and true tool positions while the primitive TRACK follows a part of a seam."""

    def __init__(self, part: ToolPath) -> None:
        self.part = part
        self.score = 0.0
        """Integral of the score along the part, in [m]."""
        self.times: list[float] = []
        self.joints: list[FloatArray] = []
        self.tips: list[FloatArray] = []

    @cached_property
    def notes(self) -> StretchNotes:
        """Recorded data of this part of the seam, for a checkpoint; only valid after its tracking has
        ended.
        """
        part = {name: np.asarray(value).tolist() for name, value in self.part._asdict().items()}
        joints, tips = np.array(self.joints).tolist(), np.array(self.tips).tolist()
        return StretchNotes(part, self.score, self.times, joints, [(x, y, z) for x, y, z in tips])


@dataclass(frozen=True)
class StretchNotes:
    """Record of joints and tool positions on a part of a seam, in plain types for a checkpoint.

    It holds the data of a `SeamStretch`.
    """

    part: dict[str, Any]
    score: float
    times: list[float]
    joints: list[list[float]]
    tips: list[tuple[float, float, float]]


class SeamSurvey(Survey):
    """Evaluation of seam tracking by the tool's true distance from the seam.

    Only the actions of the primitive TRACK, which moves the tool along the seam, are evaluated.
    """

    name = "seam"
    effects = SEAM_EFFECTS
    noted = list[StretchNotes]
    limits: ClassVar = {"tracking_error_mm_max": 1e3 * (MOST_OFF + SENSOR_ERROR_M)}

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self.tracks: Track | None = None
        """The running TRACK; None outside of such an action."""
        self.stretches: list[SeamStretch] = []
        """Stretches of successful TRACKs."""
        self._now: SeamStretch | None = None
        self._is_due = False  # whether a part of the seam is left for the running TRACK

    @classmethod
    def applies(cls, run: SurveyedRun) -> bool:
        """Return whether a simulated run tracks a seam, or has a seam whose tracked share is reported."""
        return super().applies(run) or (run.scene is not None and run.model.of(Seam).seam is not None)

    @override
    def started(self, number: int, primitive: ActionPrimitive) -> None:
        self.tracks = primitive if isinstance(primitive, Track) else None
        self._now, part = None, self.run.model.of(Seam).seam_work.next
        self._is_due = self.tracks is not None and part is not None and not part.empty

    @override
    def look(self, robot: Robot) -> None:
        part = None if self.tracks is None else self.tracks.tracking
        if part is None:
            return
        if self._now is None:
            self._now = SeamStretch(part)
        self._now.times.append(robot.time)
        self._now.joints.append(robot.arm.command())
        self._now.tips.append(self.run.world.world_T("hand")[:3, 3].copy())

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        """Return what contradicts a Success of TRACK: the tool was off its part, or not on all of it."""
        stretch, wrong = self._now, list[str]()
        if isinstance(outcome, Success) and stretch is not None:
            stretch.score = float(outcome.evidence.get("part_score_m", 0.0))
            self.stretches.append(stretch)
            wrong = _contradictions(stretch)
        elif isinstance(outcome, Success) and self._is_due:
            wrong = ["the tool never was on its part of the seam"]
        self.tracks = self._now = None
        return wrong

    @override
    def notes(self) -> list[StretchNotes]:
        return [stretch.notes for stretch in self.stretches]

    @override
    def go_on(self, noted: list[StretchNotes]) -> None:
        self.stretches = [_again(notes, self.run.robot.arm_model.dof) for notes in noted]

    def errors(self) -> list[tuple[FloatArray, FloatArray]]:
        """Return times (k,) in [s] and the tool's distances (k,) from the seam in [m], for each tracked part.

        Only parts count whose TRACK, the primitive that moves the tool along the seam, ended in Success.
        """
        return [
            (np.array(stretch.times), distances(np.array(stretch.tips), stretch.part.points))
            for stretch in self.stretches
        ]

    def figures(self) -> dict[str, Any]:
        """Return the number of parts, the tracked length and the errors of the tool; empty if no seam is
        known.
        """
        seam = self.run.model.of(Seam).seam
        if seam is None:
            return {}
        tracked = sum(stretch.part.length for stretch in self.stretches)
        found: dict[str, Any] = {"placements": len(self.stretches), "seam_tracked_m": round(tracked, 3)}
        found["score"] = round(sum(stretch.score for stretch in self.stretches) / seam.length, 4)
        if not self.stretches:
            return found
        off = 1e3 * np.concatenate([distance for _, distance in self.errors()])
        return found | {
            "tracking_error_mm_max": round(float(off.max()), 3),
            "tracking_error_mm_rms": round(float(np.sqrt(np.mean(off**2))), 3),
            "joint_limit_violations": self._violations(),
        }

    def faults(self) -> list[str]:
        """Return messages if a part of the seam was not tracked, or if the tool was off the seam by more than
        the limit `tracking_error_mm_max` in `limits`.

        Each message contradicts the Success of the complete run.
        """
        seam = self.run.model.of(Seam).seam
        if seam is None:
            return []
        left = seam.length - sum(stretch.part.length for stretch in self.stretches)
        found = [f"{left:.3f} m of the seam were not tracked"] if left > 1e-6 else []
        off = max((float(distance.max()) for _, distance in self.errors()), default=0.0)
        return found + (
            [f"the tool was {1e3 * off:.1f} mm off the seam"] if off > MOST_OFF + SENSOR_ERROR_M else []
        )

    @override
    def draw(self, folder: Path) -> None:
        from .tracking_plot import draw_tracking_errors

        stretches = [
            (f"part {number}, {item.part.length:.2f} m", times - times[0], off)
            for number, (item, (times, off)) in enumerate(zip(self.stretches, self.errors(), strict=True), 1)
        ]
        if stretches:
            draw_tracking_errors(stretches, folder / "tracked.svg", self.limits["tracking_error_mm_max"])

    def uses(self) -> list[LimitUse]:
        """Return how much of the joints' allowed speeds and torques each tracked part of the seam used.

        Torques include those of the tool's force.
        """
        return [self._use(stretch) for stretch in self.stretches]

    def _violations(self) -> int:
        """Periods and joints with an angle, a speed or a torque beyond its limit."""
        arm = self.run.robot.arm_model
        joints = np.vstack([stretch.joints for stretch in self.stretches])
        beyond = np.abs(np.array([arm.clipped(row) for row in joints]) - joints) > ROUNDING_M
        return sum(use.violations for use in self.uses()) + int(beyond.sum())

    def _use(self, stretch: SeamStretch) -> LimitUse:
        arm, tool = working_arm(self.run.robot.spec), self.run.robot.spec.tool
        load, joints = ArmLoad(arm), np.array(stretch.joints)
        ways = np.gradient(np.array([arm.forward(q)[:3, 3] for q in joints]), axis=0)
        ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), ROUNDING_M)
        force = 0.0 if tool is None else tool.force_n
        push = np.array([load.push(q, force * way) for q, way in zip(joints, ways, strict=True)])
        return load.use(joints, self.run.robot.period, load.torque, push)


def _contradictions(stretch: SeamStretch) -> list[str]:
    """Return what contradicts that the tool was on the whole part, and nowhere else."""
    tips, points, most = np.array(stretch.tips), stretch.part.points, 1e3 * (MOST_OFF + SENSOR_ERROR_M)
    off, left = 1e3 * distances(tips, points).max(), 1e3 * distances(points, tips).max()
    wrong = at_most("the tool was {:.1f} mm off its part of the seam", off, most)
    return wrong + at_most("a point of its part of the seam is {:.1f} mm from where the tool was", left, most)


def _again(noted: StretchNotes, dof: int) -> SeamStretch:
    """Restore a stretch from its notes.

    Raises:
        ValueError: the notes are not a stretch of such an arm.
    """
    part = {name: np.array(value, dtype=np.float64) for name, value in noted.part.items()}
    joints, tips = np.array(noted.joints, dtype=np.float64), np.array(noted.tips, dtype=np.float64)
    found = {name: item.shape for name, item in {**part, "joints": joints, "tips": tips}.items()}
    count, points = len(noted.times), len(part["lengths"]) if "lengths" in part else 0
    shapes = {name: (points, *shape) for name, shape in _PART.items()}
    shapes |= {"joints": (count, dof), "tips": (count, 3)}
    if found != shapes or not count or points < 2:
        raise ValueError(f"arrays {found}, needed: {shapes}")
    stretch = SeamStretch(ToolPath(**part))
    stretch.score, stretch.times = noted.score, noted.times
    stretch.joints, stretch.tips = list(joints), list(tips)
    return stretch


_PART = {"points": (3,), "rotations": (3, 3), "tangents": (3,), "turns": (3,), "lengths": ()}
"""Shapes of the fields of a `ToolPath`, for one of its points."""


def distances(points: FloatArray, path: FloatArray) -> FloatArray:
    """Return the distances (k,) of points from a path, in [m].

    Args:
        points: (k, 3) in the frame of the path, in [m].
        path: (p, 3) points joined by straight lines, at least one, in [m].
    """
    starts, ways = (path[:-1], np.diff(path, axis=0)) if len(path) > 1 else (path, np.zeros((1, 3)))
    to = points[:, None] - starts[None]
    squares = np.maximum(np.einsum("pi,pi->p", ways, ways), np.finfo(float).tiny)
    share = np.clip(np.einsum("kpi,pi->kp", to, ways) / squares, 0.0, 1.0)
    return np.asarray(np.linalg.norm(to - share[..., None] * ways, axis=2).min(axis=1))
