"""Pictures of MuJoCo's renderer, compared with the scene and with the scene's painter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.backends.mujoco.mujoco_backend import VIEW_SIZE
from handcart.backends.mujoco.rendering import gl_context
from handcart.backends.mujoco.rendering.gl_context import NoPictures
from handcart.backends.mujoco.rendering.mujoco_camera import MujocoCamera
from handcart.backends.physics.onlooker import looking
from handcart.backends.saved_state import pack
from handcart.backends.simulation.rendering.renderer import Renderer
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray

from .conftest import Make

EYE, AT = np.array([-0.05, 0.35, 0.95]), np.array([0.05, 0.5, 0.4])
TOP = 209  # grey of the block's top


def engine_camera(backend: Any) -> MujocoCamera:
    """The robot's camera, drawn by MuJoCo whatever the world's file says."""
    robot = backend._robot
    parts = backend._body, backend._world, backend._engine, 3
    return MujocoCamera(robot, robot.camera, backend.scene.arm, *parts)


def drawn_twice(backend: Any, pose: Transform) -> tuple[ByteArray, ByteArray]:
    """Return both ideal grey pictures: of the scene's painter, and of MuJoCo."""
    camera = engine_camera(backend)
    try:
        painted = Renderer(camera._true.model, backend._robot.errors, 3).ideal(backend.scene, pose)
        return painted, camera.ideal(pose)
    finally:
        camera.close()


def middle(lit: BoolArray) -> FloatArray:
    """Column and row of what is lit."""
    return np.asarray(np.argwhere(lit).mean(axis=0)[::-1])


@pytest.mark.slow
@pytest.mark.usefixtures("gl")
def test_two_renderers_see_the_same_places(make: Make) -> None:
    painted, drawn = drawn_twice(make(), looking(EYE, AT))
    assert drawn.shape == painted.shape
    # The block is at the right, the landmark, whose edges are as grey here and there, at the left.
    tops = [middle(np.abs(item[:, 400:].astype(int) - TOP) < 4) for item in (painted, drawn)]
    assert np.abs(tops[0] - tops[1]).max() < 0.5  # [px]
    papers = [middle(item > 235) for item in (painted, drawn)]
    assert np.abs(papers[0] - papers[1]).max() < 0.5  # the landmark's paper
    inks = [middle(item < 40) for item in (painted, drawn)]
    assert np.abs(inks[0] - inks[1]).max() < 1.0


@pytest.mark.slow
@pytest.mark.usefixtures("gl")
def test_what_moves_moves_in_the_picture_as_well(make: Make) -> None:
    backend, pose = make(), looking(EYE, AT)
    camera = engine_camera(backend)
    before = camera.ideal(pose)
    body = backend._world.bodies["block 1"]
    backend._engine.set_pose(body, transform((0.05, 0.0, 0.0)) @ backend._engine.pose(body))
    after = camera.ideal(pose)
    camera.close()
    was, comes = (middle(np.abs(item.astype(int) - TOP) < 4) for item in (before, after))
    assert np.hypot(*(comes - was)) > 30.0


@pytest.mark.slow
@pytest.mark.usefixtures("gl")
def test_people_see_colours_and_shadows(make: Make) -> None:
    backend = make()
    picture = backend.view().astype(int)
    assert picture.shape == (VIEW_SIZE[1], VIEW_SIZE[0], 3)
    red, green, blue = np.moveaxis(picture, 2, 0)
    assert ((red > 1.5 * green) & (red > 80)).sum() > 100  # the block of brick
    oak = (red > green) & (green > blue) & (red - blue > 30)
    floor = red[oak]
    assert np.percentile(floor, 95) > 1.4 * np.percentile(floor, 2)  # in the light, and under the table


@pytest.mark.slow
@pytest.mark.usefixtures("gl")
def test_looking_on_changes_nothing(make: Make) -> None:
    ended = []
    for looks_on in (False, True):
        backend = make()
        base = backend._base
        for number in range(10):
            base.drive(0.1, 0.2)
            backend.step()
            if looks_on and number % 3 == 0:
                backend.view()
        ended.append(pack(backend.state()))
    assert ended[0] == ended[1]


@pytest.mark.usefixtures("gl")
def test_what_stands_still_is_drawn_once(make: Make) -> None:
    backend = make()
    first = backend.view()
    assert backend.view() is first
    backend._base.drive(0.2, 0.0)
    backend.step()
    assert backend.view() is not first


@pytest.mark.slow
@pytest.mark.usefixtures("gl")
def test_who_draws_what_the_camera_sees_stands_in_the_worlds_file(make: Make) -> None:
    pictures: list[Any] = [make(more)._sensors["camera"] for more in ("", "camera: engine\n")]
    greys = [picture.image().astype(int) for picture in pictures if picture is not None]
    assert len(greys) == 2
    assert (greys[0] != greys[1]).any()
    assert np.median(np.abs(greys[0] - greys[1])) < 60


def test_without_opengl_it_says_what_to_install(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(gl_context, "find_library", lambda _: None)
    with pytest.raises(NoPictures, match=r"apt install libegl1 .*, or: apt install libosmesa6"):
        make().view()
