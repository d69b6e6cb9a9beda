from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.transform import Transform, apply, difference, inverse, transform
from handcart.robotics.perception.cameras.board_pose import pose_board
from handcart.robotics.perception.cameras.calibration_board import BoardView
from handcart.robotics.perception.cameras.camera_calibration import calibrate_camera
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.cameras.chessboard import Chessboard
from handcart.robotics.perception.cameras.hand_eye_calibration import HandEyeView, calibrate_hand_eye
from handcart.robotics.perception.cameras.hand_eye_closed_form import HAND_EYE_METHODS, closed_form
from handcart.robotics.perception.landmarks.charuco_board import CharucoBoard
from handcart.robotics.perception.landmarks.landmark_pose import facing

from ..conftest import Tabletop

HAND_T_CAMERA = transform((0.03, 0.06, 0.04), (0.02, -0.03, 1.6))
BASE_T_BOARD = transform((0.5, 0.1, 0.02), (0.01, -0.02, 0.4))
POINTS = np.array([(x, y, 0.0) for y in np.linspace(-0.04, 0.04, 5) for x in np.linspace(-0.07, 0.07, 8)])


def looking(rng: np.random.Generator, tilt: float, shift: float = 0.05, height: float = 0.3) -> Transform:
    """camera_T_board of a camera above the board, tilted to any side."""
    tilted = transform(rpy=[*rng.uniform(-tilt, tilt, 2), float(rng.uniform(-0.8, 0.8))])
    return facing(height) @ tilted @ transform([*rng.uniform(-shift, shift, 2), 0.0])


def view_of(
    camera: CameraModel, camera_T_board: Transform, rng: np.random.Generator, noise: float
) -> BoardView:
    """The corners that are in the image, each off by `noise` in [px]."""
    pixels = camera.project(apply(camera_T_board, POINTS))
    inside = ((pixels > 2) & (pixels < (camera.width - 3, camera.height - 3))).all(axis=1)
    return BoardView(POINTS[inside], pixels[inside] + rng.normal(0.0, noise, (inside.sum(), 2)))


def worst_ray(camera: CameraModel, other: CameraModel) -> float:
    """Return the distance between two models' rays of the image's pixels, in [px], after the best turn of the
    camera.
    """
    grid = np.stack(np.meshgrid(np.linspace(0, 639, 17), np.linspace(0, 479, 13)), axis=-1).reshape(-1, 2)
    rays = []
    for item in (camera, other):
        both = np.column_stack([item.undistort(grid), np.ones(len(grid))])
        rays.append(both / np.linalg.norm(both, axis=1, keepdims=True))
    turn, _ = Rotation.align_vectors(rays[0], rays[1])
    return 800.0 * float(np.linalg.norm(rays[0] - turn.apply(rays[1]), axis=1).max())


def hand_eye_views(
    camera: CameraModel, seed: int, count: int, arm_error: float, noise: float = 0.05
) -> list[HandEyeView]:
    rng = np.random.default_rng(seed)
    views = []
    for _ in range(count):
        camera_T_board = looking(rng, 0.4, 0.03)
        hand = BASE_T_BOARD @ inverse(camera_T_board) @ inverse(HAND_T_CAMERA)
        turn = Rotation.from_rotvec(rng.normal(0.0, arm_error / 0.5, 3)).as_matrix()
        hand[:3, :3] = hand[:3, :3] @ turn
        hand[:3, 3] += rng.normal(0.0, arm_error, 3)
        views.append(HandEyeView(hand, view_of(camera, camera_T_board, rng, noise)))
    return views


BOARDS = (
    CharucoBoard(),
    CharucoBoard(7, 5, 0.024, 0.016, "apriltag_36h11"),
    CharucoBoard(8, 7, 0.02, 0.014, "4x4_50"),
    Chessboard(9, 6, 0.02),
    Chessboard(6, 5, 0.024),
)


@pytest.mark.parametrize("board", BOARDS, ids=lambda item: type(item).__name__)
def test_corners_of_a_board_in_an_image(tabletop: Tabletop, board: CharucoBoard | Chessboard) -> None:
    rng = np.random.default_rng(1)
    table = tabletop.table()
    tabletop.put(table, board.draw(), 0.0, 0.0)
    for seed in range(3):
        camera_T_board = looking(rng, 0.4, 0.01)
        view = board.find(tabletop.photograph(table, camera_T_board, seed))
        assert view is not None and len(view.points) >= 0.85 * board.corners
        expected = tabletop.camera.project(apply(camera_T_board, view.points))
        assert np.linalg.norm(view.pixels - expected, axis=1).mean() < 0.1
        distance, turn = difference(pose_board(view, tabletop.camera).camera_T_board, camera_T_board)
        assert distance < 2e-4
        assert turn < 2e-3
    assert board.find(tabletop.photograph(tabletop.table(), facing(0.3), 1)) is None


def test_a_chessboard_is_told_upside_down(tabletop: Tabletop) -> None:
    """Its black corner says which side is up, however the camera is turned."""
    board, table = Chessboard(7, 6, 0.02), tabletop.table()
    tabletop.put(table, board.draw(), 0.0, 0.0)
    for turn in np.linspace(0.0, 2 * np.pi, 8, endpoint=False):
        camera_T_board = facing(0.3) @ transform(rpy=(0.1, -0.1, float(turn)))
        view = board.find(tabletop.photograph(table, camera_T_board, 1))
        assert view is not None
        _, off = difference(pose_board(view, tabletop.camera).camera_T_board, camera_T_board)
        assert off < 5e-3


def test_boards_that_no_tags_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="a tag of 25 mm doesn't fit a square of 20 mm"):
        CharucoBoard(tag=0.025)
    with pytest.raises(ValueError, match="needs 100 tags, the family 4x4_50 has 50"):
        CharucoBoard(20, 10, family="4x4_50")


def test_camera_from_images(tabletop: Tabletop) -> None:
    board, rng = CharucoBoard(), np.random.default_rng(2)
    table = tabletop.table()
    tabletop.put(table, board.draw(), 0.0, 0.0)
    images = [tabletop.photograph(table, looking(rng, 0.45, 0.05, 0.26), seed) for seed in range(14)]
    views = [view for view in map(board.find, images) if view is not None]
    found = calibrate_camera(views, 640, 480)
    assert found.rms < 0.15
    assert found.camera.K[0, 0] == pytest.approx(800.0, abs=1.5)
    assert found.camera.distortion == pytest.approx(tabletop.camera.distortion, abs=0.02)
    assert worst_ray(found.camera, tabletop.camera) < 0.5


LENSES = ((-0.28, 0.09, 0.0, 0.0, 0.0), (-0.28, 0.09, 0.001, -0.002, 0.0), (-0.28, 0.09, 0.001, -0.002, 0.4))


@pytest.mark.parametrize("lens", LENSES)
def test_camera_from_noisy_corners(tabletop: Tabletop, lens: tuple[float, ...]) -> None:
    """As much of the lens is found as there is."""
    rng, distortion = np.random.default_rng(3), np.array(lens)
    camera = tabletop.camera._replace(distortion=distortion)
    views = [view_of(camera, looking(rng, 0.45, 0.06), rng, 0.05) for _ in range(20)]
    found = calibrate_camera(views, 640, 480)
    assert found.rms == pytest.approx(0.05 * np.sqrt(2.0), rel=0.1)
    assert found.rms_of_views.shape == (20,)
    assert worst_ray(found.camera, camera) < (0.3 if lens[4] else 0.15)
    true = np.array([800.0, 800.0, 319.5, 239.5, *distortion])
    measured = np.array([*found.camera.K[[0, 1, 0, 1], [0, 1, 2, 2]], *found.camera.distortion])
    known = found.sigmas > 0.0
    assert np.count_nonzero(known[4:]) == np.count_nonzero(lens)
    assert (np.abs(measured - true)[known] / found.sigmas[known]).max() < 4.0


def test_views_that_tell_too_little_of_a_camera(tabletop: Tabletop) -> None:
    camera, rng = tabletop.camera, np.random.default_rng(4)
    views = [view_of(camera, looking(rng, 0.4, 0.06), rng, 0.05) for _ in range(12)]
    with pytest.raises(ValueError, match="7 views of the board; at least 8"):
        calibrate_camera(views[:7], 640, 480)
    straight = [view_of(camera, looking(rng, 0.02, 0.06), rng, 0.05) for _ in range(12)]
    with pytest.raises(ValueError, match="directions that differ by"):
        calibrate_camera(straight, 640, 480)
    middle = [view_of(camera, looking(rng, 0.4, 0.0, 0.6), rng, 0.05) for _ in range(12)]
    with pytest.raises(ValueError, match="of the image only"):
        calibrate_camera(middle, 640, 480)
    bent = [
        view._replace(points=view.points * (1.0 + 2.0 * view.points[:, :1])) for view in views
    ]  # printed askew
    with pytest.raises(ValueError, match=r"px \(rms\) from where the model"):
        calibrate_camera(bent, 640, 480)


@pytest.mark.parametrize("method", HAND_EYE_METHODS)
def test_each_closed_form_on_exact_poses(method: str) -> None:
    rng = np.random.default_rng(5)
    boards = [looking(rng, 0.4) for _ in range(10)]
    hands = [BASE_T_BOARD @ inverse(board) @ inverse(HAND_T_CAMERA) for board in boards]
    found = closed_form(hands, boards, method)
    assert found is not None
    distance, turn = difference(found, HAND_T_CAMERA)
    assert distance < 1e-6
    assert turn < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arm_error", "position", "angle"), [(0.0, 1e-4, 4e-4), (6e-5, 3e-4, 1e-3), (3e-4, 1e-3, 3e-3)]
)
def test_hand_eye_from_noisy_views(
    tabletop: Tabletop, arm_error: float, position: float, angle: float
) -> None:
    z = []
    for seed in range(6):
        found = calibrate_hand_eye(hand_eye_views(tabletop.camera, seed, 15, arm_error), tabletop.camera)
        distance, turn = difference(found.hand_T_camera, HAND_T_CAMERA)
        assert distance < position
        assert turn < angle
        assert difference(found.base_T_board, BASE_T_BOARD)[0] < 2 * position
        off = inverse(found.hand_T_camera) @ HAND_T_CAMERA
        z.append(np.concatenate([off[:3, 3], Rotation.from_matrix(off[:3, :3]).as_rotvec()]) / found.sigmas)
        assert arm_error == 0.0 or found.arm_error == pytest.approx(arm_error, rel=0.6)
    assert 0.4 < np.sqrt(np.mean(np.square(z))) < 2.0


@pytest.mark.slow
def test_refined_beats_the_closed_forms_with_a_good_arm(tabletop: Tabletop) -> None:
    refined, closed = [], []
    for seed in range(6):
        views = hand_eye_views(tabletop.camera, seed, 12, 0.0)
        found = calibrate_hand_eye(views, tabletop.camera)
        refined.append(difference(found.hand_T_camera, HAND_T_CAMERA)[0])
        boards = [pose_board(view.board, tabletop.camera).camera_T_board for view in views]
        starts = [
            closed_form([view.base_T_hand for view in views], boards, method) for method in HAND_EYE_METHODS
        ]
        closed.append(min(difference(start, HAND_T_CAMERA)[0] for start in starts if start is not None))
    assert np.mean(refined) < 0.6 * np.mean(closed)


def test_views_that_tell_too_little_of_the_hand(tabletop: Tabletop) -> None:
    camera, rng = tabletop.camera, np.random.default_rng(6)
    views = hand_eye_views(camera, 1, 12, 0.0)
    with pytest.raises(ValueError, match="7 views of the board; at least 8"):
        calibrate_hand_eye(views[:7], camera)
    one_axis = []
    for turn in np.linspace(-0.8, 0.8, 12):
        camera_T_board = facing(0.3) @ transform(rpy=(0.0, 0.0, float(turn)))
        hand = BASE_T_BOARD @ inverse(camera_T_board) @ inverse(HAND_T_CAMERA)
        one_axis.append(HandEyeView(hand, view_of(camera, camera_T_board, rng, 0.05)))
    with pytest.raises(ValueError, match="second axis"):
        calibrate_hand_eye(one_axis, camera)


def test_a_board_that_was_pushed_is_noticed(tabletop: Tabletop) -> None:
    views = hand_eye_views(tabletop.camera, 2, 12, 0.0)
    pushed = views[7].base_T_hand.copy()
    pushed[:3, 3] += (0.0, 0.02, 0.0)
    views[7] = views[7]._replace(base_T_hand=pushed)
    with pytest.raises(ValueError, match="view 7 puts the board"):
        calibrate_hand_eye(views, tabletop.camera)
