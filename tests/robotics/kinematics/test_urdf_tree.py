"""Joints that follow others, that have no end, or that no library takes as they are."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.coal_bodies import hull_of_mesh, shape_of
from handcart.robotics.kinematics.shapes import Hull
from handcart.robotics.kinematics.urdf_assembly import with_names
from handcart.robotics.kinematics.urdf_contents import bodies_of, link_names
from handcart.robotics.kinematics.urdf_reading import read_urdf
from handcart.robotics.kinematics.urdf_tree import urdf_of_arm

LIMIT = '<limit lower="0" upper="1" effort="1" velocity="1"/>'


def joint(name: str, kind: str, parent: str, child: str, inside: str = LIMIT) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.1 0 0"/><axis xyz="0 0 1"/>{inside}</joint>'
    )


LINKS = "".join(f'<link name="{name}"/>' for name in ("base", "a", "b", "hand"))
SECOND = LIMIT + '<mimic joint="first" multiplier="0.5" offset="0.2"/>'
THIRD = LIMIT + '<mimic joint="second" multiplier="-2"/>'
TELESCOPE = (
    f'<robot name="r">{LINKS}{joint("first", "prismatic", "base", "a")}'
    f"{joint('second', 'prismatic', 'a', 'b', SECOND)}"
    f"{joint('third', 'prismatic', 'b', 'hand', THIRD)}</robot>"
)


def test_joints_that_mimic_one_of_the_arms_follow_it() -> None:
    arm = ArmModel(TELESCOPE, ["first"])
    assert arm.dof == 1
    # first + (first / 2 + 0.2) - 2 (first / 2 + 0.2)
    assert np.allclose(arm.forward(np.array([0.4]))[:3, 3], (0.3, 0.0, 0.4 * 0.5 - 0.2))
    assert np.allclose(arm.jacobian(np.array([0.4]))[:, 0], (0.0, 0.0, 0.5, 0.0, 0.0, 0.0))


def test_joints_that_mimic_one_that_stands_stand_where_it_has_them() -> None:
    model = ArmModel(TELESCOPE, (), others={"first": 0.4})
    assert np.allclose(model.forward(np.empty(0))[:3, 3], (0.3, 0.0, 0.0))
    assert np.allclose(ArmModel(TELESCOPE, ()).forward(np.empty(0))[:3, 3], (0.3, 0.0, -0.2))


def test_a_joint_that_follows_cannot_be_one_of_the_arm() -> None:
    with pytest.raises(ValueError, match="'third' follows 'first' and can't be moved by itself"):
        ArmModel(TELESCOPE, ["first", "third"])


def test_one_that_mimics_what_is_not_there_is_free() -> None:
    arm = ArmModel(TELESCOPE.replace('mimic joint="first"', 'mimic joint="nobody"'), ["first", "second"])
    assert np.allclose(arm.forward(np.array([0.4, 0.1]))[2, 3], 0.4 + 0.1 - 2 * 0.1)


def test_a_continuous_joint_is_one_number_within_a_turn() -> None:
    arm = ArmModel(
        TELESCOPE.replace('name="first" type="prismatic"', 'name="first" type="continuous"'), ["first"]
    )
    assert (arm.lower[0], arm.upper[0]) == (-np.pi, np.pi)


def test_a_joint_that_floats_is_fixed_and_what_is_seen_left_out() -> None:
    seen = '<link name="base"><visual><geometry><mesh filename="nowhere.xyz"/></geometry></visual>'
    text = TELESCOPE.replace('<link name="base"/>', seen + "</link>").replace(
        'name="first" type="prismatic"', 'name="first" type="floating"'
    )
    robot = read_urdf(urdf_of_arm(text, ["second"], {}))
    assert [match.get("type") for match in robot.findall("joint")][:2] == ["fixed", "prismatic"]
    assert robot.find(".//visual") is None
    assert ArmModel(text, ["second"]).dof == 1


def test_numbers_too_small_for_a_parser_are_none() -> None:
    tiny = TELESCOPE.replace('xyz="0 0 1"', 'xyz="1e-310 0 1"')
    assert 'xyz="0.0 0.0 1.0"' in urdf_of_arm(tiny, ["first"], {})


def test_links_and_joints_are_named_anew() -> None:
    text, links, joints = with_names(TELESCOPE, [("a", "tray"), ("a", "imu")], [("second", "left_wheel")])
    assert link_names(text) == ["base", "tray", "left_wheel", "hand", "imu"]
    assert (links, joints) == ({"b": "left_wheel", "a": "tray"}, {"second": "left_wheel"})
    # The mimic of `third` leads to the joint under its new name still.
    arm = ArmModel(text, ["first"])
    assert np.allclose(arm.forward(np.array([0.4]))[2, 3], 0.0)
    assert np.allclose(arm.forward(np.array([0.4]), "imu"), arm.forward(np.array([0.4]), "tray"))


def test_who_has_a_name_already_makes_room() -> None:
    text, links, _ = with_names(TELESCOPE, [("a", "base")], [])
    assert link_names(text) == ["base_", "base", "b", "hand"]
    assert links == {"base": "base_", "a": "base"}


@pytest.mark.parametrize("tip", [[], [[0.0, 0.0, 2.0]]])
def test_round_meshes_of_many_corners_have_a_hull(tip: list[list[float]]) -> None:
    """The collision library takes no corner with 256 neighbours: a fine disc, the tip of a fine cone."""
    angles = np.linspace(0.0, 2.0 * np.pi, 600, endpoint=False)
    rings = [
        np.c_[np.cos(angles), np.sin(angles), np.full(600, z)] for z in ((0.0, 1.0) if not tip else (0.0,))
    ]
    corners = np.vstack([*rings, *([np.array(tip)] if tip else [])])

    class Mesh:
        def vertices(self) -> np.ndarray:
            return corners

    hull = shape_of(hull_of_mesh(Mesh(), "disc"), np.eye(4), "disc")
    assert isinstance(hull, Hull)
    assert np.allclose(np.ptp(hull.points, axis=0), np.ptp(corners, axis=0), atol=0.02)
    assert (len(hull.points) == len(corners)) == (not tip)  # a disc needs no thinning


def test_a_limit_of_an_endless_joint_need_not_tell_all() -> None:
    old = '<joint name="first" type="prismatic"><parent link="base"/><child link="a"/>'
    assert old in TELESCOPE
    half = TELESCOPE.replace(old, old.replace("prismatic", "continuous")).replace(
        LIMIT, '<limit effort="1"/>', 1
    )
    assert bodies_of(half) == []
    assert ArmModel(half, ["first"]).velocity.tolist() == [0.0]
