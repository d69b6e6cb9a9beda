"""How exactly a seam was tracked, by ground truth."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handcart.backends.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.contract.outcome import Outcome, Success
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.seam.seam import Seam
from handcart.primitives.seam.seam_room import working_arm
from handcart.primitives.seam.track import MOST_OFF, Track
from handcart.robotics.manipulation.tool_path import ToolPath
from handcart.robotics.manipulation.tracking_limits import ArmLoad, LimitUse

Floats = NDArray[np.float64]

ROUNDING = 1e-9
SENSORS = 0.0015  # [m]: five sigma of positioning and arm, beyond what TRACK allows


class Stretch:
    """What was commanded, and where the tool truly was, period by period, along a part of the seam."""

    def __init__(self, part: ToolPath) -> None:
        self.part = part
        self.score = 0.0
        """Integral along the part, in [m]."""
        self.times: list[float] = []
        self.joints: list[Floats] = []
        self.tips: list[Floats] = []


@dataclass
class SeamSurvey:
    """Looks at a scene once a period while TRACK has the tool on the seam."""

    scene: Any
    """Ground truth."""
    model: WorldModel
    robot: Robot
    tracks: Track | None = None
    """The running one."""
    stretches: list[Stretch] = field(default_factory=list)
    """Of the TRACKs that succeeded."""
    _now: Stretch | None = None

    def started(self, primitive: ActionPrimitive) -> None:
        """An action starts."""
        self.tracks = primitive if isinstance(primitive, Track) else None
        self._now = None

    def look(self) -> None:
        """A period has passed."""
        part = None if self.tracks is None else self.tracks.tracking
        if part is None:
            return
        if self._now is None:
            self._now = Stretch(part)
        self._now.times.append(self.robot.time)
        self._now.joints.append(self.robot.arm.command())
        self._now.tips.append(self.scene.world_T("hand")[:3, 3].copy())

    def ended(self, outcome: Outcome) -> None:
        """The action has ended."""
        if isinstance(outcome, Success) and self._now is not None:
            self._now.score = float(outcome.evidence.get("part_score_m", 0.0))
            self.stretches.append(self._now)
        self.tracks = self._now = None

    def notes(self) -> dict[str, Any]:
        """What couldn't be seen again."""
        return {"stretches": [{**vars(each), "part": each.part._asdict()} for each in self.stretches]}

    def go_on(self, notes: dict[str, Any]) -> None:
        """Take up the notes of the run that this one goes on with."""
        for each in notes["stretches"]:
            stretch = Stretch(ToolPath(**{name: np.array(value) for name, value in each["part"].items()}))
            stretch.score, stretch.times = each["score"], each["times"]
            stretch.joints, stretch.tips = (list(np.array(each[name])) for name in ("joints", "tips"))
            self.stretches.append(stretch)

    def errors(self) -> list[tuple[Floats, Floats]]:
        """For each stretch times (k,) in [s] and distances (k,) of the tool from the seam in [m]."""
        return [
            (np.array(each.times), distances(np.array(each.tips), each.part.points))
            for each in self.stretches
        ]

    def figures(self) -> dict[str, Any]:
        """For a run's metrics."""
        seam = self.model.of(Seam).seam
        assert seam is not None
        tracked = sum(each.part.length for each in self.stretches)
        found: dict[str, Any] = {"placements": len(self.stretches), "seam_tracked_m": round(tracked, 3)}
        found["score"] = round(sum(each.score for each in self.stretches) / seam.length, 4)
        if not self.stretches:
            return found
        off = 1e3 * np.concatenate([distance for _, distance in self.errors()])
        return found | {
            "tracking_error_mm_max": round(float(off.max()), 3),
            "tracking_error_mm_rms": round(float(np.sqrt(np.mean(off**2))), 3),
            "joint_limit_violations": self._violations(),
        }

    def faults(self) -> list[str]:
        """What contradicts that the seam is tracked, in words."""
        seam = self.model.of(Seam).seam
        assert seam is not None
        left = seam.length - sum(each.part.length for each in self.stretches)
        found = [f"{left:.3f} m of the seam were not tracked"] if left > 1e-6 else []
        off = max((float(distance.max()) for _, distance in self.errors()), default=0.0)
        return found + ([f"the tool was {1e3 * off:.1f} mm off the seam"] if off > MOST_OFF + SENSORS else [])

    def uses(self) -> list[LimitUse]:
        """What each stretch took of the joints' speeds and torques, the tool's force included."""
        return [self._use(each) for each in self.stretches]

    def _violations(self) -> int:
        """Periods and joints with an angle, a speed or a torque beyond its limit."""
        arm = self.robot.arm_model
        joints = np.vstack([each.joints for each in self.stretches])
        beyond = (joints < arm.lower - ROUNDING) | (joints > arm.upper + ROUNDING)
        return sum(use.violations for use in self.uses()) + int(beyond.sum())

    def _use(self, stretch: Stretch) -> LimitUse:
        arm, tool = working_arm(self.robot.spec), self.robot.spec.tool
        load, joints = ArmLoad(arm), np.array(stretch.joints)
        ways = np.gradient(np.array([arm.forward(q)[:3, 3] for q in joints]), axis=0)
        ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), ROUNDING)
        force = 0.0 if tool is None else tool.force_n
        push = np.array([load.push(q, force * way) for q, way in zip(joints, ways, strict=True)])
        return load.use(joints, self.robot.period, load.torque, push)


def distances(points: Floats, path: Floats) -> Floats:
    """Distances (k,) of points (k, 3) from the straight lines through the points (p, 3) of a path, in [m]."""
    starts, ways = path[:-1], np.diff(path, axis=0)
    to = points[:, None] - starts[None]
    share = np.clip(np.einsum("kpi,pi->kp", to, ways) / np.einsum("pi,pi->p", ways, ways), 0.0, 1.0)
    return np.asarray(np.linalg.norm(to - share[..., None] * ways, axis=2).min(axis=1))
