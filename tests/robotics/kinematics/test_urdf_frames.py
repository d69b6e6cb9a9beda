"""Frames by a URDF's origins alone, and bodies by its own words: held against Pinocchio's."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.urdf_contents import bodies_of
from handcart.robotics.kinematics.urdf_frames import base_T_frame, link_poses
from handcart.robotics.kinematics.urdf_tree import urdf_of_arm
from tests.makers import every_robot

UPSIDE_DOWN = """<robot name="r"><link name="tip"/><link name="base"/><link name="root"/>
<joint name="b" type="revolute"><parent link="base"/><child link="tip"/>
<origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 2"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="a" type="fixed"><parent link="root"/><child link="base"/>
<origin xyz="1 0 0" rpy="3 1 0"/></joint>
</robot>"""


@pytest.mark.parametrize("text", [UPSIDE_DOWN, *every_robot()])
def test_links_stand_where_pinocchio_has_them(text: str) -> None:
    urdf = text if text.startswith("<") else load_robot(text).urdf_text()
    model = pin.buildModelFromXML(urdf_of_arm(urdf, (), {}))
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    theirs = {
        frame.name: data.oMf[number].homogeneous
        for number, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY
    }
    ours = link_poses(urdf)
    assert ours.keys() == theirs.keys()
    for name, pose in ours.items():
        assert np.allclose(pose, theirs[name], rtol=0.0, atol=1e-12)
        seen = np.linalg.inv(theirs["base"]) @ theirs[name]
        assert np.allclose(base_T_frame(urdf, name), seen, rtol=0.0, atol=1e-12)


def test_a_link_that_is_not_there_is_told() -> None:
    for names in (("nose",), ("tip", "nose")):
        with pytest.raises(ValueError, match="the URDF has no link 'nose'"):
            base_T_frame(UPSIDE_DOWN, *names)


@pytest.mark.parametrize("name", ["cart", "el_verde", "librarian", "toyama"])
def test_bodies_are_those_of_pinocchio(name: str) -> None:
    urdf = load_robot(name).urdf_text()
    theirs = sorted(ArmModel(urdf, (), tip="base").link_shapes(np.empty(0)), key=lambda shape: shape.name)
    ours = sorted(bodies_of(urdf), key=lambda item: item.name)
    assert len(ours) > 3
    for here, there in zip(ours, theirs, strict=True):
        assert (type(here), here.name) == (type(there), there.name)
        assert np.allclose(base_T_frame(urdf, here.name) @ here.pose, there.pose, rtol=0.0, atol=1e-12)
        for size in ("size", "radius", "length"):
            assert getattr(here, size, None) == pytest.approx(getattr(there, size, None), abs=1e-12)
