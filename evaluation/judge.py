"""Whether outcomes tell the truth, by the ground truth of a simulated world."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backends.robot import Robot
from backends.robot_file import RobotFile
from networks.events import Ended, Event, Started
from networks.preparing import Prepared
from networks.run_end import RunEnd
from networks.telemetry import Telemetry
from primitives.outcome import Fail, Success
from robotics.geometry.pose2 import Pose2
from robotics.geometry.transform import difference

from .block_survey import BlockSurvey
from .camera_survey import camera_figures
from .field_survey import FieldSurvey
from .laser_survey import LaserSurvey
from .seam_survey import SeamSurvey
from .shelving import Shelving, shelving
from .stop_errors import stop_errors
from .survey_notes import SurveyNotes

SIGMAS = 5.0
BASE_SIGMA_MM, BASE_SIGMA_DEG = 4.0, 0.09  # of a base pose measured by matching scans with the map
JOINT_SIGMA_DEG = 0.01  # encoders and repeatability
CALIBRATE_CAMERA, CALIBRATE_SUSPENSION = "CALIBRATE_CAMERA", "CALIBRATE_SUSPENSION"
NOTES = "judged.jsonl"
NOTED = ("_driven", "_labels", "_frames", "_uncorrected", "_figures", "untrue")
RELEASE, STACK = "RELEASE", "STACK"  # a task without them returns no book, stacks no block
OBJECT_SIGMA_MM = 1.5  # of an object seen by the camera
MOST_OFF_MM = (
    8.0 + SIGMAS * 0.5
)  # of a block that counts as put where it goes: STACK's own limit and its sensor's


@dataclass(frozen=True)
class Truth:
    """The true state of robot and world at one instant."""

    base: Pose2
    joints: NDArray[np.float64]
    held: str | None
    things: Mapping[str, NDArray[np.float64]]
    """world_T_thing of books and blocks by name; of the held one, hand_T_held."""


def truth_of(scene: Any) -> Truth:
    """Read the scene of a simulated backend."""
    held = scene.held.name if scene.held is not None else None
    every = (*scene.books.values(), *scene.blocks.values())
    things = {thing.name: thing.pose.copy() for thing in every}
    if held is not None:
        things[held] = scene.hand_T_held.copy()
    return Truth(scene.base, scene.joints.copy(), held, things)


def broken_promises(before: Truth, after: Truth, robot: RobotFile) -> list[str]:
    """What a Fail claims to have restored and did not: beyond tolerance plus 5 sigma of its sensors."""
    tolerance = robot.tolerance
    far = 1e3 * before.base.distance(after.base)
    turned = math.degrees(before.base.turn(after.base))
    off = math.degrees(float(np.abs(before.joints - after.joints).max())) if before.joints.size else 0.0
    checks = [
        ("base_mm", far, tolerance.base_mm + SIGMAS * BASE_SIGMA_MM),
        ("base_deg", turned, tolerance.base_deg + SIGMAS * BASE_SIGMA_DEG),
        ("joints_deg", off, tolerance.joints_deg + SIGMAS * JOINT_SIGMA_DEG),
    ]
    # What stands on the robot rides on the base, so the base's own tolerance comes on top.
    room = tolerance.object_mm + SIGMAS * OBJECT_SIGMA_MM + tolerance.base_mm + SIGMAS * BASE_SIGMA_MM
    for name, pose in before.things.items():
        moved = 1e3 * difference(pose, after.things[name])[0]
        checks.append((f"{name} mm", moved, room))
    wrong = [f"{name} {size:.1f} (at most {most:.1f})" for name, size, most in checks if size > most]
    if before.held != after.held:
        wrong.append(f"held {before.held}, then {after.held}")
    return wrong


class Judge:
    """An observer of a run that holds its outcomes against the ground truth."""

    def __init__(self, prepared: Prepared, folder: Path | None = None) -> None:
        """Judge a run that hasn't started; where the backend isn't simulated, nothing is claimed.

        In the run's `folder` is noted what a run that breaks off couldn't tell again.
        """
        self._robot = prepared.robot.spec
        self._scene: Any = getattr(prepared.backend, "scene", None)
        self._start: Truth | None = None
        self._at, self._driven = prepared.robot.reckoned, 0.0
        self._labels = 0
        self._figures: dict[str, float] = {}
        self.untrue: list[str] = []
        """Outcomes that the ground truth contradicts, in words."""
        self._survey: BlockSurvey | None = None
        self._uncorrected, self._frames = True, 0
        plan = prepared.model.building
        stacks = any(action.do == STACK for action in prepared.task.network.actions)
        if plan is not None and stacks and self._scene is not None:
            self._survey = BlockSurvey(self._scene, prepared.model, plan)
        self._seed = prepared.seed
        self._lasers: LaserSurvey | None = None
        self.seam: SeamSurvey | None = None
        """What was seen of a seam that is tracked."""
        if self._scene is not None and prepared.model.seam is not None:
            self.seam = SeamSurvey(self._scene, prepared.model, prepared.robot)
        self.field: FieldSurvey | None = None
        """What was seen of sensors that are laid."""
        if self._scene is not None and prepared.model.targets:
            self.field = FieldSurvey(self._scene, prepared.model, prepared.seed, folder)
        self._shelving: Shelving | None = None
        shelves = any(action.do == RELEASE for action in prepared.task.network.actions)
        if shelves and self._scene is not None and self._scene.tray_book() is not None:
            first = self._scene.tray_book().accession
            others = [each.accession for each in self._scene.to_come]
            self._shelving = shelving(self._scene, (first, *others))
        self._notes = None if folder is None or self._scene is None else SurveyNotes(folder, NOTES)
        self._go_on()

    def look(self, robot: Robot) -> None:
        """A period has passed."""
        self._driven += robot.reckoned.distance(self._at)
        self._at = robot.reckoned
        if self._survey is not None:
            self._survey.look()
        if self.seam is not None:
            self.seam.look()
        if self.field is not None:
            self.field.look(robot)
        if self._lasers is not None:
            self._lasers.look(robot)

    def __call__(self, event: Event) -> None:
        """Take the truth down when an action starts, compare when it has ended."""
        if self._scene is None:
            return
        if isinstance(event, Started):
            self._start = truth_of(self._scene)
            if self.seam is not None:
                self.seam.started(event.primitive)
            if event.action.do == CALIBRATE_SUSPENSION:
                self._lasers = LaserSurvey(self._scene)
        elif isinstance(event, Ended):
            if self.seam is not None:
                self.seam.ended(event.outcome)
            self._labels += int(event.primitive.facts.get("labels_read", 0))
            self._frames += int(event.primitive.facts.get("frames", 0))
            if getattr(event.primitive, "onto", "") == "goal":
                self._uncorrected &= getattr(event.primitive, "method", "") == "fix_once"
            if isinstance(event.outcome, Success):
                self._figures |= stop_errors(self._scene, event) | self._calibrated(event)
            if isinstance(event.outcome, Fail) and self._start is not None:
                for wrong in broken_promises(self._start, truth_of(self._scene), self._robot):
                    self.untrue.append(f"{event.number}. {event.action.do} Fail: {wrong}")
            self._note()

    def _note(self) -> None:
        """Note what a run that breaks off after this action couldn't tell again."""
        if self._notes is None:
            return
        parts = {"blocks": self._survey, "seam": self.seam, "books": self._shelving}
        note = {name: part.notes() for name, part in parts.items() if part is not None}
        self._notes.add(self._scene.time, {name: getattr(self, name) for name in NOTED} | note)

    def _go_on(self) -> None:
        """Take up what was noted of the run that this one goes on with."""
        noted = [] if self._notes is None else self._notes.until(self._scene.time)
        if not noted:
            return
        last = noted[-1]
        for name in NOTED:
            setattr(self, name, last[name])
        if self._survey is not None:
            self._survey.go_on(last["blocks"])
        if self.seam is not None:
            self.seam.go_on(last["seam"])
        if "books" in last:
            self._shelving = Shelving.noted(last["books"])

    def _calibrated(self, event: Ended) -> dict[str, float]:
        """What a calibration found, beside the truth, or beside another way of measuring it."""
        found = event.primitive.evidence.calibrated
        figures: dict[str, float] = {}
        if event.action.do == CALIBRATE_CAMERA and self._robot.camera is not None:
            camera, errors = self._robot.camera, self._robot.errors
            figures |= camera_figures(camera, self._robot.arm_model(), errors, self._seed, found)
        if event.action.do == CALIBRATE_SUSPENSION and self._lasers is not None:
            for key, each in found.items():
                if isinstance(each.value, float):
                    figures[key.rpartition(".")[2]] = round(each.value, 4)
            figures |= self._lasers.figures()
            self._lasers = None
        return figures

    def metrics(self, prepared: Prepared, end: RunEnd, telemetry: Telemetry) -> dict[str, Any]:
        """The figures of a run that has ended."""
        figures: dict[str, Any] = {"path_length_m": round(self._driven, 3), **self._figures}
        if self._survey is not None:
            figures |= self._survey.figures(self._uncorrected) | {"frames": self._frames}
            self._judge_blocks(end)
        if self.seam is not None:
            figures |= self.seam.figures()
            self._judge_seam(end, self.seam)
        if self.field is not None:
            figures |= self.field.figures()
        if self._shelving is not None:
            stands = self._shelving.judge(self._scene)
            figures |= stands.figures() | {"labels_read": self._labels}
            if end.outcome == "Success" and not stands.right:
                self.untrue.append(f"Success: {stands}")
        figures["untrue"] = self.untrue
        return figures

    def _judge_seam(self, end: RunEnd, seam: SeamSurvey) -> None:
        """Success claims that all of the seam was tracked, nowhere farther off than TRACK allows."""
        told = seam.faults()
        if end.outcome == "Success" and told:
            self.untrue.append(f"Success: {'; '.join(told)}")

    def _judge_blocks(self, end: RunEnd) -> None:
        """Success claims that every block of the plan stands about where it should."""
        assert self._survey is not None
        goals = len(self._survey.plan.goals)
        errors = self._survey.errors()
        far = [
            f"block {error.number} is {error.size:.1f} mm off" for error in errors if error.size > MOST_OFF_MM
        ]
        missing = goals - len(errors)
        if end.outcome == "Success" and (far or missing):
            told = [
                *far,
                *([f"{missing} of {goals} blocks don't stand where they should"] if missing else []),
            ]
            self.untrue.append(f"Success: {'; '.join(told)}")
