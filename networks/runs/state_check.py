"""Check of a real robot after its run broke off: expected state, measured state, and unknowns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from handcart.backends.description.joint_units import JointUnits
from handcart.backends.robot.robot import Robot
from handcart.networks.journal.measured import measured_fields
from handcart.networks.journal.retracing import NeedsOperator
from handcart.networks.journal.waiting import broken_off
from handcart.networks.task.preparing import Prepared
from handcart.primitives.outcomes.residual import ResidualKind, Residuals
from handcart.primitives.restoring.snapshot import Snapshot, residuals, settle, take_snapshot

from .resuming import Past

SETTLING_PERIODS = 40  # at rest, in which a base that was pushed is found again
_BY_SCANS = (
    ResidualKind.BASE_POSITION,
    ResidualKind.BASE_HEADING,
    ResidualKind.BASE_POSITION_UNCERTAINTY,
    ResidualKind.BASE_HEADING_UNCERTAINTY,
)


@dataclass(frozen=True)
class StateCheck:
    """Comparison of a real robot's measured state, before a run is resumed, with the state in the journal."""

    expected: Snapshot | None
    """Expected snapshot; None if the journal has none."""
    measured: Snapshot
    residuals: Residuals
    unknown: tuple[str, ...]
    """Facts in words that no sensor measures."""
    sure: bool
    """True if all expected values could be compared."""
    units: JointUnits
    """Units of the arm's joints."""

    def words(self) -> list[str]:
        """Return lines of text with the robot's expected and measured state, and with facts that no sensor
        measures.
        """
        found = self.residuals.words_with_limits
        lines = [] if self.expected is None else [f"expected: {_stands(self.expected, self.units)}"]
        lines.append(f"measured: {_stands(self.measured, self.units)}; off by {found or 'nothing known'}")
        return [*lines, *(f"unknown: {item}" for item in self.unknown)]

    def fields(self) -> dict[str, Any]:
        """Return the fields of the journal record RECON, by which a check of the robot's state is recorded.

        `situation` is None, because the situation of the run does not change.
        """
        expected = None if self.expected is None else measured_fields(self.expected)
        states = {"expected": expected, "at": measured_fields(self.measured), "residuals": self.residuals}
        return {"situation": None, **states, "unknown": self.unknown}


def standing_as_left(prepared: Prepared, past: Past) -> Prepared:
    """Return the prepared run with a robot whose pose estimate and time are the last ones in the journal."""
    old, at = prepared.robot, past.standing.at
    grid = prepared.model.map if prepared.task.file.knowledge else None
    robot = Robot(prepared.backend, old.spec, old.pose if at is None else at.pose, grid)
    robot.time = past.time_s
    return replace(prepared, robot=robot)


def check_state(robot: Robot, past: Past) -> StateCheck:
    """Wait until the robot rests, read all sensors, and compare its state with that in the journal.

    No motion is commanded.
    """
    for _ in range(SETTLING_PERIODS):
        robot.step()
    for _ in settle(robot):
        robot.step()
    now, expected = take_snapshot(robot, {}), past.standing.at
    unknown = list(past.doubts())
    if expected is None:
        unknown.append("the robot's state: not in the journal")
        return StateCheck(None, now, Residuals(), tuple(unknown), False, robot.spec.joint_units)
    found = residuals(expected, now, robot.spec)
    if robot.localization.dead_reckoned:
        found = Residuals(residual for residual in found.all if residual.kind not in _BY_SCANS)
        unknown.append("the pose of the base: only its wheels measure it, and they were not read meanwhile")
    elif (lost := robot.localization.lost) is not None:
        unknown.append(f"the pose of the base: {lost.why}")
    unknown.append("objects around it that no sensor sees now")
    sure = not robot.localization.dead_reckoned
    return StateCheck(expected, now, found, tuple(unknown), sure, robot.spec.joint_units)


def gone_on(past: Past, check: StateCheck, confirm: int | None) -> Past:
    """Return the past run, ready to be resumed from the measured state of a real robot.

    An action that was broken off counts as failed. The run stays in the situation in which it began, whatever
    `on_fail` names: what the action learned was not kept.

    Args:
        past: the run at the end of its journal.
        check: comparison of the measured state with the journal.
        confirm: number of the journal's last record, given by a person who has looked at the robot; None if
            nobody has.

    Raises:
        NeedsOperator: the measured state differs from the journal's, no sensor measures the effects of the
            action that was broken off, or `confirm` is not the number of the last record.
    """
    doubt = past.standing.in_doubt
    if off := check.residuals.beyond:
        where = "where that action began" if doubt else "where it was left"
        raise NeedsOperator(f"the robot isn't {where}: {off.words}; bring it there, then resume again")
    if doubt is not None and (not check.sure or len(list(past.doubts())) > 1):
        how = f"if all is as it was before that action: handcart ack {past.folder} {doubt['q']}"
        raise NeedsOperator(f"{broken_off(doubt)}, and no sensor measures what it did; {how}")
    if confirm != past.last:
        how = f"handcart resume {past.folder} --confirm {past.last}"
        raise NeedsOperator(f"a real robot moves only after a look at it: {how}")
    closing: list[tuple[str, Mapping[str, Any]]] = [("RECON", check.fields())]
    if doubt is not None:
        fail = {"n": doubt["n"], "outcome": "Fail", "reason": broken_off(doubt), "permanent": False}
        found = {
            "residuals": check.residuals,
            "tolerance": check.residuals.limits,
            "by": "recon",
            "stays": True,
        }
        closing.append(("RESULT", fail | found))
    records = [{"kind": kind, "q": -1, **fields} for kind, fields in closing]
    return replace(past, standing=past.standing.followed(records), closing=tuple(closing))


def _stands(at: Snapshot, units: JointUnits) -> str:
    x, y, heading = at.pose
    words = f"base at ({x:.2f}, {y:.2f}) m, heading {math.degrees(heading):.1f} deg"
    if at.joints.size:
        words += f"; joints {', '.join(units.words(joint, item) for joint, item in enumerate(at.joints))}"
    if at.gripper_width or at.gripper_command:
        held = "something" if at.holding else "nothing"
        words += f"; fingers {1e3 * at.gripper_width:.1f} mm apart, holding {held}"
    return words
