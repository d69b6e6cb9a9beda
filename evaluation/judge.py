"""Whether outcomes tell the truth, by the ground truth of a simulated world."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handcart.backends.robot import Robot
from handcart.networks.coordination.events import Ended, Event, Started
from handcart.networks.coordination.run_end import RunEnd
from handcart.networks.runs.telemetry import Telemetry
from handcart.networks.task.preparing import Prepared
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.contract.outcome import Fail, Success
from handcart.primitives.field.field_work import FieldWork
from handcart.primitives.seam.seam import Seam

from .block_survey import BlockSurvey
from .calibration_claims import camera_faults, suspension_faults
from .camera_survey import camera_figures
from .contact_survey import ContactSurvey
from .effects import STACKED_MM, arrival, false_effect
from .field_survey import FieldSurvey
from .ground_truth import GroundTruth, ground_truth, not_restored
from .laser_survey import LaserSurvey
from .localisation_survey import LocalisationSurvey
from .seam_survey import SeamSurvey
from .shelving import Shelving, shelving
from .stop_errors import stop_errors
from .survey_notes import SurveyNotes

CALIBRATE_CAMERA, CALIBRATE_SUSPENSION = "CALIBRATE_CAMERA", "CALIBRATE_SUSPENSION"
NOTES = "judged.jsonl"
NOTED = ("_driven", "_labels", "_frames", "_uncorrected", "_figures", "untrue")
MOVE_TO = "MOVE_TO"
RELEASE, STACK = "RELEASE", "STACK"  # a task without them returns no book, stacks no block


class Judge:
    """An observer of a run that holds its outcomes against the ground truth."""

    def __init__(self, prepared: Prepared, folder: Path | None = None) -> None:
        """Judge a run that hasn't started; where the backend isn't simulated, nothing is claimed.

        In the run's `folder` is noted what a run that breaks off couldn't tell again.
        """
        self._prepared, self._robot = prepared, prepared.robot.spec
        self._scene: Any = getattr(prepared.backend, "scene", None)
        self._start: GroundTruth | None = None
        self._at, self._driven = prepared.robot.reckoned, 0.0
        self._labels = 0
        self._figures: dict[str, float] = {}
        self.untrue: list[str] = []
        """Outcomes that the ground truth contradicts, in words."""
        self._survey: BlockSurvey | None = None
        self._uncorrected, self._frames = True, 0
        plan = prepared.model.of(Blocks).building
        stacks = any(action.do == STACK for action in prepared.task.network.actions)
        if plan is not None and stacks and self._scene is not None:
            self._survey = BlockSurvey(self._scene, prepared.model, plan)
        self._seed = prepared.seed
        self._lasers: LaserSurvey | None = None
        self.seam: SeamSurvey | None = None
        """What was seen of a seam that is tracked."""
        if self._scene is not None and prepared.model.of(Seam).seam is not None:
            self.seam = SeamSurvey(self._scene, prepared.model, prepared.robot)
        self.field: FieldSurvey | None = None
        """What was seen of sensors that are laid."""
        if self._scene is not None and prepared.model.of(FieldWork).targets:
            self.field = FieldSurvey(self._scene, prepared.model, prepared.seed, folder)
        self._contacts: ContactSurvey | None = None
        self._localisation: LocalisationSurvey | None = None
        if self._scene is not None:
            self._contacts = ContactSurvey(self._scene, prepared.model)
            self._localisation = LocalisationSurvey(self._scene)
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
        if self._contacts is not None:
            self._contacts.look(robot)
        if self._localisation is not None:
            self._localisation.look(robot)
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
        if self._scene is None or self._contacts is None:
            return
        if isinstance(event, Started):
            self._start = ground_truth(self._prepared.backend)
            self._contacts.started(event.number, event.primitive)
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
            wrong = self._wrong(event)
            if isinstance(event.outcome, Success):
                self._figures |= stop_errors(self._scene, event)
                wrong += self._take_calibrated(event)
                self._take_arrival(event)
            word = type(event.outcome).__name__
            self.untrue += [f"{event.number}. {event.action.do} {word}: {each}" for each in wrong]
            self._note()

    def _wrong(self, event: Ended) -> list[str]:
        """What the outcome of an action claims and isn't so, in words."""
        assert self._contacts is not None
        touched = self._contacts.ended()
        after = ground_truth(self._prepared.backend)
        if self._start is None or after is None:
            return []
        if isinstance(event.outcome, Fail):
            return not_restored(self._start, after, self._robot)
        if not isinstance(event.outcome, Success):
            return []
        model = self._prepared.model
        false = false_effect(event.primitive, self._prepared.robot, model, self._start)
        return false + [str(each) for each in touched]

    def _take_arrival(self, event: Ended) -> None:
        """How far from its places the base came to stand: the worst of the run."""
        if event.action.do != MOVE_TO:
            return
        place = str(getattr(event.primitive, "place", ""))
        off, turned = arrival(self._prepared.robot, place, self._prepared.model)
        for name, size in (("arrival_mm_max", round(off, 2)), ("arrival_deg_max", round(turned, 3))):
            self._figures[name] = max(size, self._figures.get(name, 0.0))

    def _note(self) -> None:
        """Note what a run that breaks off after this action couldn't tell again."""
        if self._notes is None:
            return
        parts = {
            "blocks": self._survey,
            "seam": self.seam,
            "books": self._shelving,
            "contacts": self._contacts,
            "localisation": self._localisation,
        }
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
        if self._contacts is not None:
            self._contacts.go_on(last["contacts"])
        if self._localisation is not None:
            self._localisation.go_on(last["localisation"])
        if "books" in last:
            self._shelving = Shelving.noted(last["books"])

    def _take_calibrated(self, event: Ended) -> list[str]:
        """What a calibration found, beside the truth or another way of measuring it; gives what isn't so."""
        found = event.primitive.evidence.calibrated
        if event.action.do == CALIBRATE_CAMERA and self._robot.camera is not None:
            camera, errors = self._robot.camera, self._robot.errors
            self._figures |= camera_figures(camera, self._robot.arm_model(), errors, self._seed, found)
            return camera_faults(self._robot, self._seed, found)
        if event.action.do == CALIBRATE_SUSPENSION and self._lasers is not None:
            for key, each in found.items():
                if isinstance(each.value, float):
                    self._figures[key.rpartition(".")[2]] = round(each.value, 4)
            spots, self._lasers = self._lasers.figures(), None
            self._figures |= spots
            return suspension_faults(spots, found)
        return []

    def metrics(self, prepared: Prepared, end: RunEnd, telemetry: Telemetry) -> dict[str, Any]:
        """The figures of a run that has ended."""
        figures: dict[str, Any] = {"path_length_m": round(self._driven, 3), **self._figures}
        if self._localisation is not None:
            figures |= self._localisation.figures()
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
        if self._contacts is not None:
            figures |= self._contacts.figures()
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
            f"block {error.number} is {error.size:.1f} mm off" for error in errors if error.size > STACKED_MM
        ]
        missing = goals - len(errors)
        if end.outcome == "Success" and (far or missing):
            told = [
                *far,
                *([f"{missing} of {goals} blocks don't stand where they should"] if missing else []),
            ]
            self.untrue.append(f"Success: {'; '.join(told)}")
