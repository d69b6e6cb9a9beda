"""CALIBRATE_CAMERA: find out how the camera on the hand sees, and where on the hand it sits."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from pydantic import Field
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.robot.mounted_camera import mount_of, stated_camera
from handcart.backends.robot.robot import Robot
from handcart.files.suggest import suggest
from handcart.primitives.blocks.building import BoardPlan
from handcart.primitives.blocks.building_site import building, standing, surroundings
from handcart.primitives.calibration import calibration_causes
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import move_to_pose
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.calibrated import Calibrated, as_facts
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.preconditions.hand_use import NEEDS_EMPTY
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.transform import Transform, difference, inverse
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.perception.cameras.calibration_board import CalibrationBoard
from handcart.robotics.perception.cameras.camera_calibration import CameraCalibration, calibrate_camera
from handcart.robotics.perception.cameras.hand_eye_calibration import (
    HandEyeCalibration,
    HandEyeView,
    calibrate_hand_eye,
)
from handcart.robotics.perception.drawing.overlay import draw_overlay

from .board_views import board_views

POSTURES_PER_VIEW = 2  # times as many postures are tried as views are wanted: the arm doesn't reach all
MIN_CORNER_SHARE = 0.5  # of the board's: fewer in a picture don't count
USUAL_WIDTH = 0.18  # [m] of the board that `board_views` looks at


class CalibrationResult(NamedTuple):
    """Result of a calibration: intrinsics of the camera and its pose on the hand, with their accuracy."""

    camera: CameraCalibration
    hand_eye: HandEyeCalibration


class CalibrateCamera(ActionPrimitive):
    """Look at a calibration board from all sides; find the camera's intrinsics and its pose on the hand.

    The intrinsics are computed by the method of Zhang (2000), the camera's pose by `cv2.calibrateHandEye` and
    a refinement. The base tilts as the arm moves; the tilt that the suspension's model predicts is corrected.
    The result is a proposal for the robot's file.
    """

    board: Annotated[str, Field(min_length=1)]
    """Name of the board in the building plan."""
    views: Annotated[int, Field(ge=10, le=100)] = 36
    """Number of pictures."""

    needs: ClassVar = (Arm, Camera)
    reads: ClassVar = ("building", "placed", "fixed", "taken")
    hand: ClassVar = NEEDS_EMPTY

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        plan = _board_of(model, self.board)
        base_T_board = inverse(standing(robot, model).lift()) @ plan.pose
        views = yield from self._look(robot, model, plan, base_T_board)
        if len(views) < self.views:
            few = Measured("Camera", "views of the board", len(views), self.views)
            raise Discrepancy(
                "the board can't be seen from enough sides", measured=few, cause=causes.OUT_OF_REACH
            )
        try:
            found = yield from robot.compute(_calibrated, robot, views)
        except ValueError as error:
            raise Discrepancy(
                f"the views don't calibrate the camera: {error}", cause=calibration_causes.NOT_OBSERVABLE
            ) from None
        self._tell(robot, found)

    def _look(
        self, robot: Robot, model: ModelView, plan: BoardPlan, base_T_board: Transform
    ) -> Generator[None, None, list[HandEyeView]]:
        """Take pictures from as many postures as `views` asks for, if the arm reaches so many."""
        board, around = plan.board(plan.square_mm), surroundings(robot, model)
        camera_T_hand = inverse(robot.camera.hand_T_camera)
        views: list[HandEyeView] = []
        for base_T_camera in board_views(
            base_T_board, POSTURES_PER_VIEW * self.views, max(board.size) / USUAL_WIDTH
        ):
            if len(views) == self.views:
                break
            try:
                yield from move_to_pose(robot, base_T_camera @ camera_T_hand, around=around)
            except Discrepancy as error:
                if error.measured is not None:
                    raise
                continue  # out of reach
            yield from settle(robot)
            yield
            view = self._picture(robot, board)
            if view is not None:
                views.append(view)
        return views

    def _picture(self, robot: Robot, board: CalibrationBoard) -> HandEyeView | None:
        image = robot.picture()
        seen = board.find(image)
        if seen is None or len(seen.points) < MIN_CORNER_SHARE * board.corners:
            return None
        self.evidence.pictures["board"] = draw_overlay(image, points=seen.pixels)
        return HandEyeView(robot.base_T("hand"), seen)

    def _tell(self, robot: Robot, found: CalibrationResult) -> None:
        spec = robot.spec.hand_camera
        assert spec is not None
        camera, sigmas = found.camera.camera, found.camera.sigmas
        mount = stated_camera(spec, mount_of(robot.spec, spec, robot.arm_model)).hand_T_camera
        off = inverse(mount) @ found.hand_eye.hand_T_camera
        turn = np.degrees(pin.rpy.matrixToRpy(off[:3, :3]))
        of_mount = found.hand_eye.sigmas
        start = ".".join((*robot.spec.key_of(robot.spec.name_of(spec)), "calibrated"))
        self.evidence.calibrated.update(
            {
                f"{start}.focal_px": Calibrated(float(camera.K[1, 1]), float(sigmas[1])),
                f"{start}.cx_px": Calibrated(float(camera.K[0, 2]), float(sigmas[2])),
                f"{start}.cy_px": Calibrated(float(camera.K[1, 2]), float(sigmas[3])),
                **_lens(start, found.camera),
                f"{start}.xyz_mm": Calibrated(
                    tuple((1e3 * off[:3, 3]).tolist()), tuple((1e3 * of_mount[:3]).tolist())
                ),
                f"{start}.rpy_deg": Calibrated(
                    tuple(turn.tolist()), tuple(np.degrees(of_mount[3:]).tolist())
                ),
            }
        )
        far, turned = difference(robot.camera.hand_T_camera, found.hand_eye.hand_T_camera)
        self.found(**as_facts(self.evidence.calibrated))
        self.found(
            fit_px=round(found.camera.rms, 3),
            mount_off_mm=round(1e3 * far, 2),
            mount_off_mrad=round(1e3 * turned, 2),
            arm_error_mm=round(1e3 * found.hand_eye.arm_error, 2),
            frames=len(found.camera.rms_of_views),
        )


def _lens(start: str, found: CameraCalibration) -> dict[str, Calibrated]:
    """Return the lens coefficients that the pictures determine; the others stay 0."""
    values, sigmas = found.camera.distortion, found.sigmas[4:]
    return {
        f"{start}.{name}": Calibrated(float(value), float(sigma))
        for name, value, sigma in zip(("k1", "k2", "p1", "p2", "k3"), values, sigmas, strict=True)
        if sigma > 0.0
    }


def _board_of(model: ModelView, name: str) -> BoardPlan:
    boards = building(model).boards
    if name not in boards:
        raise Discrepancy(
            f"the building plan has no board {name!r}{suggest(name, boards)}",
            permanent=True,
            cause=causes.NOT_KNOWN,
        )
    return boards[name]


def _calibrated(robot: Robot, views: Sequence[HandEyeView]) -> CalibrationResult:
    """Return the calibration by the views; raise ValueError if they do not determine it."""
    known = robot.camera.model
    boards = [view.board for view in views]
    camera = calibrate_camera(boards, known.width, known.height, square_pixels=True)
    suspension, reference = robot.spec.suspension.model, views[0].base_T_hand
    leaning = [
        view._replace(base_T_hand=suspension.displaced(view.base_T_hand, reference, 0.0)) for view in views
    ]
    return CalibrationResult(camera, calibrate_hand_eye(leaning, camera.camera))
