"""Places of laid sensors, measured by the total station: the errors of Ohki et al. (2012), section VI."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.gps import Gps
from handcart.backends.description.ground_spec import OUTDOOR_LOCALIZERS
from handcart.backends.robot.robot import Robot
from handcart.backends.simulation.field.field_props import FieldProps
from handcart.evaluation.judging.survey import Survey, SurveyedRun
from handcart.evaluation.judging.survey_notes import SurveyNotes
from handcart.networks.task.preparing import Prepared
from handcart.primitives.field.field_work import FieldWork
from handcart.primitives.field.target import Laid
from handcart.robotics.navigation.outdoors.placement_errors import aligned_spread, nees
from handcart.robotics.numerics.arrays import FloatArray

from .as_laid_report import AsLaid
from .field_effects import FIELD_EFFECTS
from .laid_placement import Place, Placement
from .total_station import Sight, TotalStation

LOOKS_BACK = 1.0  # [s] before a sensor is released, in which the hand is above it
TRACK_PERIOD_S = 0.5  # [s] between points of the tracks that are drawn
NOTES_FILE = "survey.jsonl"
TRACK_NAMES = ("fixes", "particles", "odometry", "estimate", "truth")
CLOUD_EVERY = 10.0  # [m] of the way between two clouds of particles that are drawn
DRAWN_PARTICLES = 64  # of their particles
MAX_NOTE_PERIOD_S = 5.0  # [s] at most between two notes


@dataclass(frozen=True)
class FieldNote:
    """Observations of a `FieldSurvey` since its last saved note; a resumed run continues with the saved
    notes.
    """

    laid: dict[str, tuple[str, Place | None]]
    """Name of the simulated body and measured position of each sensor laid since then, by the sensor's
    name.
    """
    tracks: dict[str, list[Place]]
    sights: list[tuple[float, float, float, float]]
    """Time in [s] and x, y, z in the field's frame in [m] of each reading of the total station."""


class FieldSurvey(Survey):
    """Evaluation of a run that lays out seismic sensors, by their true and measured positions."""

    name = "field"
    effects = FIELD_EFFECTS

    def __init__(self, run: SurveyedRun) -> None:
        """Prepare to observe a run; raises `NotAState` if the notes in the run's folder make no sense."""
        super().__init__(run)
        self._model = run.model
        self._scene: Any = run.scene
        spec = None if run.scene is None else run.scene.of(FieldProps).total_station
        self.station = TotalStation(spec, run.world, run.seed) if spec is not None else None
        self._blocks: dict[str, str] = {}
        self._seen: dict[str, Place | None] = {}
        self.tracks: dict[str, list[Place]] = {name: [] for name in TRACK_NAMES}
        """Points (x, y) in [m] for plots."""
        self._as_laid: list[AsLaid] = []
        """Report of a run that has ended."""
        self._next = 0.0
        self._cloud_at: Place | None = None
        """Position of the robot at the last recorded cloud of particles."""
        self._held = ""
        simulated = run.folder is not None and run.scene is not None
        self._notes = SurveyNotes(run.folder, NOTES_FILE) if run.folder is not None and simulated else None
        if run.scene is not None:
            self._go_on()
            self._noted, self._noted_lengths = run.world.time, self._lengths()

    @classmethod
    def applies(cls, run: SurveyedRun) -> bool:
        """Return whether the run lays sensors, or has target positions for sensors to report on."""
        return bool(run.does & cls.effects.keys() or run.model.of(FieldWork).targets)

    @override
    def look(self, robot: Robot) -> None:
        if self._scene is None:
            return
        if self.station is not None:
            self.station.look()
        self._follow(robot)
        laid = self._model.of(FieldWork).laid[len(self._blocks) :]
        for item in laid:
            self._blocks[item.name] = self._held
            self._seen[item.name] = self._measured()
        if laid or self._scene.time >= self._noted + MAX_NOTE_PERIOD_S:
            self._note([item.name for item in laid])
        held = self._scene.held
        self._held = "" if held is None else held.spec.name

    def _go_on(self) -> None:
        """Restore the notes of the run that this one resumes."""
        if self._notes is not None:
            for note in self._notes.until(self._scene.time):
                self._take_up(self._notes.checked(note, FieldNote))
        for laid in self._model.of(FieldWork).laid:
            if laid.name not in self._blocks:  # nothing was recorded
                self._blocks[laid.name], self._seen[laid.name] = self._nearest(laid), None

    def _take_up(self, note: FieldNote) -> None:
        for name in TRACK_NAMES:
            self.tracks[name] += note.tracks.get(name, [])
        for name, (block, place) in note.laid.items():
            self._blocks[name], self._seen[name] = block, place
        if self.station is not None:
            self.station.sights += [Sight(time, np.array(place)) for time, *place in note.sights]

    def _lengths(self) -> dict[str, int]:
        """Return the number of points of each kind."""
        sights = len(self.station.sights) if self.station is not None else 0
        return {"sights": sights, **{name: len(points) for name, points in self.tracks.items()}}

    def _note(self, laid: list[str]) -> None:
        """Write a note on the sensors named in `laid`, and on new points of tracks and readings of the total
        station.
        """
        if self._notes is None:
            return
        sights = self.station.sights[self._noted_lengths["sights"] :] if self.station is not None else []
        note = FieldNote(
            {name: (self._blocks[name], self._seen[name]) for name in laid},
            {
                name: [(round(x, 3), round(y, 3)) for x, y in points[self._noted_lengths[name] :]]
                for name, points in self.tracks.items()
            },
            [(sight.time, *sight.place.round(4).tolist()) for sight in sights],
        )
        self._notes.add(self._scene.time, vars(note))
        self._noted, self._noted_lengths = self._scene.time, self._lengths()

    def placements(self) -> list[Placement]:
        """Return target, estimated, measured and true position of each released sensor."""
        work = self._model.of(FieldWork)
        found = []
        for laid in work.laid:
            block = self._scene.of(FieldProps).sensors.get(self._blocks.get(laid.name, ""))
            target = work.targets[laid.name]
            if block is not None:
                lies = (float(block.pose[0, 3]), float(block.pose[1, 3]))
                seen = self._seen.get(laid.name)
                found.append(Placement(laid.name, (target.x, target.y), laid, seen, lies))
        return found

    @override
    def figures(self) -> dict[str, Any]:
        if self._scene is None or not self._model.of(FieldWork).targets:
            return {}
        every = self.placements()
        seen = [placement for placement in every if placement.error_mm is not None]
        result: dict[str, Any] = {"placed": len(every), "out_of_sight": len(every) - len(seen)}
        if seen:
            errors = np.array([placement.error_mm for placement in seen])
            sizes = np.hypot(*errors.T)
            result["error_mm_rms"] = round(float(np.sqrt(np.mean(sizes**2))), 1)
            result["error_mm_max"] = round(float(sizes.max()), 1)
            result["nees_mean"] = round(float(np.mean(self._nees(seen))), 3)
        if len(seen) > 2:
            spread = 1e3 * aligned_spread(errors / 1e3, np.array([placement.target for placement in seen]))
            result["aligned_sd_x_mm"], result["aligned_sd_y_mm"] = (round(float(row), 1) for row in spread)
        result["placements"] = [_row(placement) for placement in every]
        return result

    def report(self, prepared: Prepared, folder: Path) -> None:
        """Write the report of the laid sensors' estimated positions into a folder, if any sensor was laid."""
        if not prepared.model.of(FieldWork).laid:
            return
        from .as_laid_report import write_as_laid

        self._as_laid = write_as_laid(prepared, folder)

    def draw(self, folder: Path) -> None:
        """Draw plots of how far laid sensors are from where the robot believes them, into a run's folder.

        Nothing is drawn for a run without a simulated world, or if no sensor was laid.
        """
        if self._as_laid and self._scene is not None:
            from .as_laid_plots import draw_as_laid

            draw_as_laid(folder, self, self._as_laid)

    def _nearest(self, laid: Laid) -> str:
        """Return the block that lies nearest to where the robot believed to lay it."""
        away = {
            block.spec.name: math.dist(block.pose[:2, 3], (laid.x, laid.y))
            for block in self._scene.of(FieldProps).sensors.values()
        }
        return min(away, key=lambda name: away[name], default="")

    def _nees(self, seen: list[Placement]) -> FloatArray:
        own = 0.0 if self.station is None else self.station.sigma**2
        believed = np.array([(placement.believed.x, placement.believed.y) for placement in seen])
        off = np.array([placement.measured for placement in seen], dtype=np.float64) - believed
        return nees(off, np.array([placement.believed.spread + own * np.eye(2) for placement in seen]))

    def _measured(self) -> Place | None:
        """Return the mean of the readings of the last second; None without a reading."""
        sights = self.station.sights if self.station is not None else []
        last = [sight.place for sight in sights[-10:] if sight.time > self._scene.time - LOOKS_BACK]
        if not last:
            return None
        x, y = np.mean(last, axis=0)[:2].tolist()
        return x, y

    def _follow(self, robot: Robot) -> None:
        if robot.spec.localizer not in OUTDOOR_LOCALIZERS:
            return
        gps = robot.backend.get(Gps)  # type: ignore[type-abstract]
        fix = gps.fix() if gps is not None else None
        if fix is not None:
            self.tracks["fixes"].append((float(fix.position[0]), float(fix.position[1])))
        if self._scene.time >= self._next:
            self._next = self._scene.time + TRACK_PERIOD_S
            poses = {
                "odometry": robot.localization.odometry_pose,
                "estimate": robot.pose,
                "truth": self._scene.base,
            }
            for name, pose in poses.items():
                self.tracks[name].append((pose.x, pose.y))
            self._follow_particles(robot)

    def _follow_particles(self, robot: Robot) -> None:
        """Record how the cloud of particles contracts, as in figure 3 of the paper."""
        here, cloud = (self._scene.base.x, self._scene.base.y), robot.localization.particles
        if cloud is None or (self._cloud_at is not None and math.dist(here, self._cloud_at) < CLOUD_EVERY):
            return
        self._cloud_at = here
        every = 1 + cloud.shape[1] // DRAWN_PARTICLES
        self.tracks["particles"] += [(x, y) for x, y in cloud[:2, ::every].T.tolist()]


def _row(each: Placement) -> dict[str, Any]:
    """Return a row of the summary."""
    error = each.error_mm
    true = [1e3 * (lies - goal) for lies, goal in zip(each.lies, each.target, strict=True)]
    xx, _, yy = each.believed.covariance
    return {
        "name": each.name,
        "x_mm": None if error is None else round(error[0], 1),
        "y_mm": None if error is None else round(error[1], 1),
        "true_x_mm": round(true[0], 1),
        "true_y_mm": round(true[1], 1),
        "sigma_x_mm": round(1e3 * math.sqrt(xx), 1),
        "sigma_y_mm": round(1e3 * math.sqrt(yy), 1),
        "time_s": round(each.believed.time, 2),
    }
