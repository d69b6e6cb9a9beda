"""LOOK_FOR, PICK and PLACE with a camera on a head: it looks where the hand works, past the arm."""

from __future__ import annotations

from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest

from handcart.backends.capabilities.missing_capability import MissingCapability
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.mounted_camera import known_camera, mount_of
from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.rig import Rig
from handcart.files.errors import FileError
from handcart.networks.task.task_file import load_task
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.objects.knowledge import aimed_view
from handcart.primitives.objects.knowledge.aimed_view import aimed_joints
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.pick import Pick
from handcart.primitives.objects.place_object import PlaceObject
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.transform import apply, inverse, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

from .fetching import TASK, rig_with, scene_of
from .head_robot import head_robot


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Rig:
    """The robot with a head, at home."""
    return rig_with(robot=str(head_robot(tmp_path_factory.mktemp("head"))), seed=1)


@pytest.mark.slow
def test_head_finds_picks_and_places_an_object(rig: Rig) -> None:
    for primitive in (
        MoveTo(place="table_a"),
        LookFor(object="parcel_1"),
        Pick(object="parcel_1", to="table_a"),
        PlaceObject(surface="table_a"),
    ):
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
    scene = scene_of(rig)
    parcel = scene.thing_named("object parcel_1").pose
    assert abs(parcel[2, 3] - 0.6) < 1e-3 and parcel[2, 2] > 0.999
    assert {contact.body for contact in scene.contacts} == {"load"}  # touched down


def test_head_turns_to_a_point_and_the_arm_keeps_its_posture(rig: Rig) -> None:
    robot, point = rig.robot, np.array([0.6, 0.5, 0.5])
    found = aimed_joints(robot, CollisionModel(robot.arm_model), point, [])
    assert found is not None
    joints, base_T_camera = found
    x, y, z = apply(inverse(base_T_camera), point[None])[0]
    assert np.hypot(x, y) < 1e-3 * z
    assert np.array_equal(joints[2:], robot.arm.command()[2:])


def test_view_that_the_held_object_hides_is_not_taken(rig: Rig) -> None:
    robot, point, here = rig.robot, np.array([0.6, 0.5, 0.5]), rig.robot.arm.command()
    middle = 0.4 * robot.base_T("camera")[:3, 3] + 0.6 * point
    pose = np.asarray(inverse(robot.base_T("hand")) @ transform(middle.tolist()))
    board = Box(pose, (0.1, 0.1, 0.02), "board")
    loaded = CollisionModel(robot.arm_model, held=board)
    assert not loaded.in_collision(here)
    free = aimed_joints(robot, CollisionModel(robot.arm_model), point, [])
    assert free is not None and np.array_equal(free[0][2:], here[2:])
    past = aimed_joints(robot, loaded, point, [])
    assert past is None or not np.array_equal(past[0][2:], here[2:])


def test_hand_moves_out_of_sight_where_no_joint_turns_it_aside(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(aimed_view, "ASIDE_TURNS_RAD", ())
    robot, point, base_T_hand = rig.robot, np.array([0.6, 0.5, 0.5]), rig.robot.base_T("hand")
    middle = 0.4 * robot.base_T("camera")[:3, 3] + 0.6 * point
    board = Box(np.asarray(inverse(base_T_hand) @ transform(middle.tolist())), (0.1, 0.1, 0.02), "board")
    found = aimed_joints(robot, CollisionModel(robot.arm_model, held=board), point, [])
    assert found is not None
    moved = robot.arm_model.forward(found[0])
    np.testing.assert_allclose(moved[:3, :3], base_T_hand[:3, :3], atol=1e-3)
    assert np.linalg.norm(moved[:3, 3] - base_T_hand[:3, 3]) > 0.05


def test_inverse_kinematics_keep_the_head_where_it_is(rig: Rig) -> None:
    arm, near = rig.robot.arm_model, np.array([0.4, 0.3, *rig.robot.spec.posture("home")[2:]])
    assert arm.moves_tip.tolist() == [False, False, *[True] * 6]
    pose = arm.forward(np.array(rig.robot.spec.posture("search_ready")))
    found = list(arm.solutions(pose, near, restarts=10))
    assert found and all(np.array_equal(array[:2], near[:2]) for array in found)


def test_primitives_that_need_the_hand_camera_refuse_a_head(rig: Rig) -> None:
    from handcart.backends.capabilities.camera import AnyCamera, Camera

    robot: Robot = rig.robot
    assert robot.get(AnyCamera) is robot.view_camera
    with pytest.raises(MissingCapability):
        robot.get(Camera)  # type: ignore[type-abstract]
    assert isinstance(rig.backend, KinematicBackend)
    task = load_task(TASK.parent / "stack_blocks" / "task.yaml")
    with pytest.raises(FileError, match="needs what the robot doesn't have: Camera"):
        task.check_capabilities(rig.backend)
    load_task(TASK / "task.yaml").check_capabilities(rig.backend)


def test_floor_before_the_robot_is_seen_past_a_bulky_object() -> None:
    """A packet in Fetch's hand, in the posture in which it is carried, hides the floor from the head."""
    if find_spec("mani_skill") is None:  # its own dependencies are not needed
        pytest.skip("the package mani_skill is not installed")
    spec = load_robot("fetch")
    carried = np.array([0.353, -0.025, 1.018, 0.189, 0.744, -3.07, -2.188, 0.054, 1.363, -1.441])
    camera = next(iter(spec.all_of(CameraSpec).values()))
    robot = SimpleNamespace(
        spec=spec,
        view_camera=known_camera(camera, mount_of(spec, camera, spec.arm_model())),
        arm=SimpleNamespace(command=lambda: carried),
        arm_model=spec.arm_model(),
    )
    held = transform((0.21, 0.0, 0.0))
    held[:3, :3] = [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
    packet = Box(held @ transform((0.0, 0.0, 0.055)), (0.06, 0.16, 0.11), "packet")
    loaded = CollisionModel(robot.arm_model, held=packet)
    assert not loaded.in_collision(carried)
    for point in ((0.66, 0.10, 0.0), (0.55, 0.18, 0.0), (0.6, -0.15, 0.0)):
        assert aimed_joints(robot, loaded, np.array(point), []) is not None  # type: ignore[arg-type]
