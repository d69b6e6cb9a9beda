"""CALIBRATE_SUSPENSION: find out how the base turns and leans when the arm moves a load."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from pydantic import Field
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.building import LandmarkName, LandmarkPlan
from handcart.primitives.blocks.building_site import building, standing, surroundings
from handcart.primitives.blocks.fixate import landmark_of
from handcart.primitives.blocks.pick_up_block import unlike_block
from handcart.primitives.calibration import calibration_causes
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import move_straight, move_to_pose
from handcart.primitives.motions.from_above import gripped
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.calibrated import Calibrated, as_facts
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.preconditions.hand_use import CARRIES_OBJECT
from handcart.robotics.geometry.transform import Transform, apply, inverse, raised
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.suspension.suspension_identification import (
    Sighting,
    SuspensionFit,
    Swing,
    fit_sightings,
)
from handcart.robotics.manipulation.suspension.swing_yaw import SwingYaw, fit_swing_yaw
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.landmarks.landmark import square_corners

from .sightings import above, creep, see

VIEW_HEIGHTS_M = (0.26, 0.32)  # of the camera above the landmarks
MIN_SWING_RATIO = 1.2  # times what counts as a swing: so far the hand must swing at least
LOOKS_PER_SWING = 2  # between swings; the hand is raised and lowered between them, so that its error varies
RAISE_HEIGHT_M = 0.03

Names = Annotated[tuple[LandmarkName, ...], Field(min_length=3)]


class HandSurroundings(NamedTuple):
    """Landmarks that the hand's camera shall see, the object in the hand, and obstacles for the arm, all
    posed in the base frame.
    """

    marks: list[LandmarkPlan]
    base_T_marks: list[Transform]
    held: Box
    around: tuple[Box, ...]


class CalibrateSuspension(ActionPrimitive):
    """Measure how far the base tilts and turns when the arm swings a load, by views of landmarks.

    Landmarks near and far are viewed before and after the held load was swung out and back.

    The base tilts towards the hand, so that landmarks in views from near and far, high and low, appear
    shifted and nearer. The base also turns with each swing of the loaded arm, so that the same landmark then
    appears turned. Between the landmarks the hand moves in short steps, which do not turn the base. The
    result is a proposal for the robot's file (Hatano et al. 2000, section 4).
    """

    landmarks: Names
    """Names of the landmarks in the building plan: on one table, near and far, to both sides. The hand is
    over the first one between the swings.
    """
    rounds: Annotated[int, Field(ge=1, le=20)] = 6
    """Number of views of each landmark from each height."""
    swings: Annotated[int, Field(ge=4, le=200)] = 20
    """Number of swings of the hand, out and back."""

    needs: ClassVar = (Arm, Gripper, Camera)
    reads: ClassVar = ("building", "placed", "fixed", "taken")
    hand: ClassVar = CARRIES_OBJECT

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the hand does not hold a block of the building plan, which is needed as a load;
        empty if it does.
        """
        return unlike_block(robot, model)

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        scene = self._scene(robot, model)
        first = above(robot, scene.base_T_marks[0], VIEW_HEIGHTS_M[0])
        yield from move_to_pose(robot, first, scene.held, scene.around)
        sightings = yield from self._look_around(robot, scene)
        headings, between = yield from self._swing(robot, scene)
        try:
            yaw = fit_swing_yaw(headings, between)
            fit = yield from robot.compute(_fitted, robot, scene, sightings, yaw.yaw_per_swing)
        except ValueError as error:
            raise Discrepancy(
                f"suspension parameters aren't observable from these views: {error}",
                cause=calibration_causes.NOT_OBSERVABLE,
            ) from None
        self._tell(yaw, fit, len(sightings) + headings.size)

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Raise a Discrepancy if the block slips out of the hand."""
        if not robot.gripper.closed_on_something():
            width = Measured("Gripper", "opening", 1e3 * robot.gripper.width(), unit="mm")
            raise Discrepancy("the block slipped out of the hand", measured=width, cause=causes.SLIPPED)

    def _scene(self, robot: Robot, model: ModelView) -> HandSurroundings:
        marks = [landmark_of(model, name) for name in self.landmarks]
        base_T_map = inverse(standing(robot, model).lift())
        held = gripped(robot, building(model).block)
        return HandSurroundings(
            marks, [base_T_map @ mark.pose for mark in marks], held, surroundings(robot, model)
        )

    def _look_around(self, robot: Robot, scene: HandSurroundings) -> Generator[None, None, list[Sighting]]:
        """Look at each landmark from each height, repeatedly."""
        reference = robot.base_T("hand")
        sheet_T_map = inverse(scene.marks[0].pose)
        sightings, swings = [], 0
        for n in range(self.rounds * len(VIEW_HEIGHTS_M)):
            for mark, base_T_mark in zip(scene.marks, scene.base_T_marks, strict=True):
                place = above(robot, base_T_mark, VIEW_HEIGHTS_M[n % len(VIEW_HEIGHTS_M)])
                swings += yield from creep(robot, place, scene.held, scene.around)
                seen = yield from see(robot, mark, base_T_mark, self.evidence)
                printed = apply(sheet_T_map @ mark.pose, square_corners(mark.side_mm / 1e3))
                swing = Swing(seen.base_T_hand, reference, swings)
                sightings.append(Sighting(swing, printed, seen.landmark.rays))
        return sightings

    def _swing(self, robot: Robot, scene: HandSurroundings) -> Generator[None, None, tuple[FloatArray, int]]:
        """Swing the load out and back; return the base's headings over the first landmark, and the swings
        between rows.

        The headings (swings + 1, views) are in [rad], positive to the left, relative to the landmark's
        heading. Each row is measured at rest after one more motion out and back, which counts as two swings.
        """
        mark, base_T_mark = scene.marks[0], scene.base_T_marks[0]
        here = above(robot, base_T_mark, VIEW_HEIGHTS_M[0])
        out = _farthest(robot, scene, here)
        yield from creep(robot, here, scene.held, scene.around)
        rows = []
        for n in range(self.swings + 1):
            if n > 0:
                yield from move_straight(robot, out, scene.held, scene.around)
                yield
                yield from move_straight(robot, here, scene.held, scene.around)
            row = []
            for look in range(LOOKS_PER_SWING):
                if look > 0:
                    yield from move_straight(robot, raised(here, RAISE_HEIGHT_M), scene.held, scene.around)
                    yield
                    yield from move_straight(robot, here, scene.held, scene.around)
                seen = yield from see(robot, mark, base_T_mark, self.evidence)
                row.append(-seen.base_T_landmark.theta)
            rows.append(row)
        return np.array(rows), 2

    def _tell(self, yaw: SwingYaw, fit: SuspensionFit, frames: int) -> None:
        model, sigmas = fit.model, fit.sigmas
        found = {
            "yaw_mrad_per_swing": Calibrated(1e3 * yaw.yaw_per_swing, 1e3 * yaw.sigma),
            "yaw_sigma_mrad": Calibrated(1e3 * yaw.spread, 1e3 * yaw.spread_sigma),
            "roll_mrad_per_m": Calibrated(1e3 * model.roll_per_m, 1e3 * sigmas.roll_per_m),
            "pitch_mrad_per_m": Calibrated(1e3 * model.pitch_per_m, 1e3 * sigmas.pitch_per_m),
            "pivot_m": Calibrated(model.pivot, sigmas.pivot),
        }
        self.evidence.calibrated.update({f"suspension.{key}": value for key, value in found.items()})
        self.found(**as_facts(found))
        self.found(heading_noise_mrad=round(1e3 * yaw.noise, 3), frames=frames)


def _farthest(robot: Robot, scene: HandSurroundings, here: Transform) -> Transform:
    """Return base_T_hand (4, 4) over the landmark farthest from `here`; at least the length of a swing
    away.
    """
    views = [above(robot, mark, VIEW_HEIGHTS_M[0]) for mark in scene.base_T_marks]
    far = [float(np.linalg.norm(view[:2, 3] - here[:2, 3])) for view in views]
    least = MIN_SWING_RATIO * robot.spec.suspension.swing_from_mm / 1e3
    if max(far) < least:
        near = Measured("Arm", "way of a swing", max(far), least, "m")
        raise Discrepancy(
            "the landmarks are too near for a swing",
            permanent=True,
            measured=near,
            cause=calibration_causes.NOT_OBSERVABLE,
        )
    return views[int(np.argmax(far))]


def _fitted(
    robot: Robot, scene: HandSurroundings, sightings: Sequence[Sighting], yaw: float
) -> SuspensionFit:
    """Return the fitted tilt of the base; raise ValueError if the sightings do not determine it."""
    known = {"yaw_per_swing": yaw}
    assert robot.spec.arm is not None
    off = robot.spec.arm.accuracy_mm / 1e3
    return fit_sightings(sightings, robot.camera.hand_T_camera, scene.base_T_marks[0], known, off)
