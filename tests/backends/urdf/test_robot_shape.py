"""Sizes of fingers and trays, whatever way their links are turned."""

from __future__ import annotations

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.urdf.robot_shape import FingerShape, MissingShape, finger_shape
from handcart.robotics.kinematics.arm_model import ArmModel

ORIGIN, SIZE = "0.095 0.00075 0", "0.11 0.0015 0.04"
BOX = f'<collision><origin xyz="{ORIGIN}"/><geometry><box size="{SIZE}"/></geometry></collision>'


def shape_with(collision: str) -> FingerShape:
    """Return the librarian's fingers with another collision box."""
    robot = load_robot("librarian")
    assert robot.arm is not None
    text = robot.urdf_text()
    assert BOX in text
    return finger_shape(ArmModel(text.replace(BOX, collision), robot.arm.joints))


@pytest.mark.parametrize(
    ("rpy", "size"),
    [
        ("0 0 0", "0.11 0.0015 0.04"),
        ("0 1.5708 0", "0.04 0.0015 0.11"),
        ("0 -1.5708 0", "0.04 0.0015 0.11"),
        ("0 0 1.57", "0.0015 0.11 0.04"),
        ("1.5707963 0 1.5707963", "0.0015 0.04 0.11"),
        ("3.1416 0 0", "0.11 0.0015 0.04"),
    ],
)
def test_a_finger_turned_by_right_angles_has_the_same_size(rpy: str, size: str) -> None:
    turned = BOX.replace("/><geometry>", f' rpy="{rpy}"/><geometry>').replace(SIZE, size)
    assert shape_with(turned) == pytest.approx(shape_with(BOX), abs=1e-9)


def test_a_tilted_finger_is_refused_in_words_of_the_hand() -> None:
    with pytest.raises(MissingShape, match="sides along the axes of the frame `hand`, whose x axis is"):
        shape_with(BOX.replace("/><geometry>", ' rpy="0 0.1 0"/><geometry>'))
