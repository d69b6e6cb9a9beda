"""A robot that leans on springs and turns on its tyres."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.physics.urdf.sprung import CHASSIS_LINK, sprung
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.robotics.numerics.arrays import FloatArray

EMPTY = world_model().model_validate({"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}})

Build = Callable[..., PhysicsBackend]


@pytest.fixture
def build(physics: type[PhysicsBackend]) -> Iterator[Build]:
    made: list[PhysicsBackend] = []

    def make(**errors: float) -> PhysicsBackend:
        made.append(physics(toyama(**errors), EMPTY, 0))
        return made[-1]

    yield make
    for backend in made:
        backend.close()


def toyama(**errors: float) -> RobotFile:
    """The robot of that name, which errs in nothing else."""
    robot = load_robot("toyama").without_errors()
    return robot.model_copy(update={"errors": robot.errors.model_copy(update=errors)})


def part(backend: PhysicsBackend, name: str) -> Any:
    return next(
        capability for capability in backend.capabilities() if type(capability).__name__.endswith(name)
    )


def go(backend: PhysicsBackend, joints: FloatArray, seconds: float = 2.0) -> None:
    """Move the joints and wait until all is at rest."""
    arm = part(backend, "Arm")
    start = arm.command()
    for share in np.linspace(0.0, 1.0, round(seconds / backend.period) + 1)[1:]:
        arm.move(start + share * (joints - start))
        backend.step()
    for _ in range(20):
        backend.step()


def masses(urdf: str) -> float:
    found = ElementTree.fromstring(urdf).iterfind("link/inertial/mass")
    return sum(float(item.get("value", "nan")) for item in found)


def test_a_chassis_takes_its_mass_and_wheels_from_the_base() -> None:
    urdf = toyama().urdf_text()
    changed = sprung(urdf, 0.15, ("left_wheel",))
    assert masses(changed) == pytest.approx(masses(urdf))
    joints = ElementTree.fromstring(changed).iterfind("joint")
    parents = {}
    for joint in joints:
        parent = joint.find("parent")
        assert parent is not None
        parents[joint.get("name")] = parent.get("link")
    assert parents["left_wheel"] == CHASSIS_LINK
    assert parents["right_wheel"] == parents["column_mount"] == "base"


@pytest.mark.slow
def test_the_body_leans_to_where_the_arm_is_about_as_the_file_says(build: Build) -> None:
    backend: Any = build(lean_mrad_per_m=8.0, lean_pivot_m=0.15)
    home = part(backend, "Arm").command()
    reaches, leans = [], []
    for joint_1 in (0.0, 0.8, 1.57):
        for joint_2 in (-1.4, -0.8):
            go(backend, np.array([joint_1, joint_2, 2.2, 0.0, 0.6, home[5]]))
            reaches.append(backend.scene.arm.forward(backend.scene.joints)[:2, 3])
            leans.append(backend.scene.lean)
    reach, lean = np.array(reaches), 1e3 * np.array(leans)
    assert np.abs(lean - 8.0 * reach[:, ::-1] * (-1.0, 1.0)).max() < 1.5
    assert np.ptp(lean[:, 0]) > 2.0
    standing = backend._body.standing_pose()
    pivot = backend.scene.world_T_base @ (0.0, 0.0, 0.15, 1.0)
    assert np.abs(pivot - standing @ (0.0, 0.0, 0.15, 1.0)).max() < 1e-6
    assert backend.scene.tilted_base[2, 0] == pytest.approx(-leans[-1][1], abs=3e-4)


def test_a_base_without_springs_doesnt_lean(build: Build) -> None:
    backend = build()
    assert not backend._body.sprung
    assert backend.scene.lean == (0.0, 0.0)


def test_what_falls_does_not_shake_on_its_springs(build: Build) -> None:
    backend: Any = build(lean_mrad_per_m=8.0, lean_pivot_m=0.15)
    if backend.name == "pybullet":
        pytest.skip("PyBullet takes a damper's torque for a whole chunk: a chassis in the air shakes")
    for _ in range(10):
        backend.step()
    backend._body.put(backend.scene.base, 0.03)
    leans = []
    for _ in range(40):
        backend.step()
        leans.append(backend.scene.lean)
    assert np.abs(leans).max() < 0.05
    assert np.ptp(leans[-10:], axis=0).max() < 1e-4


@pytest.mark.slow
def test_a_swing_turns_the_base_and_no_encoder_sees_it_but_the_gyro(build: Build) -> None:
    backend = build(swing_yaw_mrad=-2.0)
    go(backend, part(backend, "Arm").command())
    before, wheels = backend.scene.base, part(backend, "Base").wheel_travel()
    imu, turned = part(backend, "Imu"), 0.0
    start = part(backend, "Arm").command()
    for number in range(60):
        if number < 20:
            part(backend, "Arm").move(start + 0.01 * (number + 1))
        backend.step()
        turned += imu.rates()[2] * backend.period
    assert backend.scene.base.theta - before.theta == pytest.approx(-2e-3, abs=2e-4)
    assert turned == pytest.approx(backend.scene.base.theta - before.theta, abs=1e-4)
    assert before.distance(backend.scene.base) < 3e-4
    after = part(backend, "Base").wheel_travel()
    assert np.abs(np.array(after) - np.array(wheels)).max() < 5e-5


def test_the_accelerometers_feel_gravity_and_how_the_base_speeds_up(build: Build) -> None:
    backend = build()
    base, imu = part(backend, "Base"), part(backend, "Imu")
    backend.step()
    assert imu.accelerations() == pytest.approx([0.0, 0.0, 9.81], abs=0.05)
    felt = []
    for number in range(1, 21):
        base.drive(0.015 * number, 0.0)
        backend.step()
        felt.append(imu.accelerations()[0])
    assert np.mean(felt[2:]) == pytest.approx(0.3, abs=0.03)
