"""Properties guessed from a URDF alone, and the robot's file drafted from them."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.robot_report.drafting.draft import draft_text
from handcart.evaluation.robot_report.outline import Outline, outline_of
from handcart.evaluation.robot_report.remark import Remark, grouped, grouped_findings
from handcart.files.errors import Finding

LIMIT = '<limit lower="{}" upper="{}" effort="5" velocity="1"/>'


def link(name: str, solid: str = "") -> str:
    body = f"<collision><geometry>{solid}</geometry></collision>" if solid else ""
    return f'<link name="{name}">{body}</link>'


def joint(name: str, kind: str, parent: str, child: str, xyz: str = "0 0 0", axis: str = "0 0 1") -> str:
    limits = LIMIT.format(0.2, 0.4) if kind in ("revolute", "prismatic") else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>{limits}</joint>'
    )


WHEEL = '<cylinder radius="0.1" length="0.05"/>'
PARTS = [
    link("base_footprint"),
    link("base_link"),
    joint("up", "fixed", "base_footprint", "base_link"),
    *(link(name, WHEEL) for name in ("l_wheel", "r_wheel", "caster_wheel")),
    joint("l_wheel_joint", "continuous", "base_link", "l_wheel", "0 0.25 0.1", "0 1 0"),
    joint("r_wheel_joint", "continuous", "base_link", "r_wheel", "0 -0.25 0.1", "0 1 0"),
    joint("caster_wheel_joint", "continuous", "base_link", "caster_wheel", "-0.2 0.3 0.05", "0 1 0"),
    *(link(name) for name in ("carriage", "upper", "tool0", "finger_l", "finger_r", "head", "laser_link")),
    joint("lift", "prismatic", "base_link", "carriage"),
    joint("turn", "revolute", "carriage", "upper"),
    joint("roll", "continuous", "upper", "tool0"),
    joint("l_finger", "prismatic", "tool0", "finger_l"),
    joint("r_finger", "prismatic", "tool0", "finger_r"),
    joint("nod", "revolute", "base_link", "head"),
    joint("eye", "fixed", "base_link", "laser_link", "0.1 0 0.2"),
]
URDF = f"<robot name='r'>{''.join(PARTS)}</robot>"


@pytest.fixture(scope="module")
def outline() -> Outline:
    return outline_of(URDF)


def test_wheels_arm_fingers_and_frames_are_found(outline: Outline) -> None:
    assert outline.root == "base_footprint"
    wheels = outline.wheels
    assert wheels is not None
    assert (wheels.left, wheels.right) == (("l_wheel_joint",), ("r_wheel_joint",))
    assert (wheels.tread, wheels.radius) == pytest.approx((0.5, 0.1), rel=0.02)
    assert outline.arm == ("lift", "turn", "roll")
    assert outline.chains == [("lift", "turn", "roll"), ("nod",)]
    assert (outline.hand, outline.fingers) == ("tool0", ("l_finger", "r_finger"))
    assert outline.frames == {"range_sensor": "laser_link"}


@pytest.mark.parametrize("own", ["grasp_link", "tcp"])
def test_a_tool_frame_of_the_gripper_comes_before_those_of_the_arm(own: str) -> None:
    gripper = [link("ee_link"), link("gripper_body"), link(own)]
    gripper += [
        joint("flange", "fixed", "tool0", "ee_link"),
        joint("mount", "fixed", "tool0", "gripper_body"),
        joint("grasp", "fixed", "gripper_body", own),
    ]
    urdf = URDF.replace(
        '<parent link="tool0"/><child link="finger', '<parent link="gripper_body"/><child link="finger'
    )
    assert outline_of(urdf.replace("</robot>", "".join(gripper) + "</robot>")).hand == own


def test_wheels_nearer_to_the_middle_are_not_driven() -> None:
    inner = [
        link("l_inner", WHEEL),
        link("r_inner", WHEEL),
        joint("l_inner_wheel", "continuous", "base_link", "l_inner", "0.2 0.1 0.1", "0 1 0"),
        joint("r_inner_wheel", "continuous", "base_link", "r_inner", "0.2 -0.1 0.1", "0 1 0"),
    ]
    wheels = outline_of(f"<robot name='r'>{''.join([*PARTS, *inner])}</robot>").wheels
    assert wheels is not None
    assert (wheels.left, wheels.right) == (("l_wheel_joint",), ("r_wheel_joint",))


def test_a_draft_is_a_robots_file(outline: Outline, tmp_path: Path) -> None:
    (tmp_path / "it's.urdf").write_text(URDF, encoding="utf-8")
    file = tmp_path / "robot.yaml"
    file.write_text(draft_text(outline, URDF, "it's.urdf", {"gripper": "no boxes"}), encoding="utf-8")
    robot = load_robot(str(file))
    assert robot.posture("home") == pytest.approx((0.3, 0.3, 0.0), abs=2e-3)
    assert robot.drive.tread_m == 0.5
    assert robot.arm_model().joint_names == ("lift", "turn", "roll")
    assert (robot.localizer, robot.range_sensor is not None) == ("scan", True)


def test_a_draft_of_a_mecanum_base_drives_sideways(tmp_path: Path) -> None:
    text = robot_path("cart/mecanum").with_name("mecanum.urdf").read_text(encoding="utf-8")
    (tmp_path / "robot.urdf").write_text(text, encoding="utf-8")
    file = tmp_path / "robot.yaml"
    file.write_text(draft_text(outline_of(text), text, "robot.urdf", {}), encoding="utf-8")
    drive = load_robot(str(file)).drive
    assert (drive.kind, drive.wheel_radius_m) == ("holonomic", 0.08)
    assert drive.tread_m == pytest.approx(0.7)
    assert "sideways" not in draft_text(outline_of(URDF), URDF, "robot.urdf", {})


def test_the_librarian_is_guessed_from_its_urdf() -> None:
    text = robot_path("librarian").with_name("librarian.urdf").read_text(encoding="utf-8")
    found = outline_of(text)
    assert found.arm == tuple(f"joint_{n}" for n in range(1, 7))
    assert (found.root, found.hand, found.fingers) == ("base", "hand", ("left_finger", "right_finger"))
    assert {"range_sensor", "camera"} <= set(found.frames)


def test_remarks_that_are_alike_are_told_in_one_line() -> None:
    at = [Finding("r.urdf", line, 3, "") for line in (4, 9, 12)]
    alike = [
        Remark(f"link {name!r}", f"a mass of {mass} kg", place)
        for name, mass, place in zip("abc", (0, -1, 2.5), at, strict=True)
    ]
    postures = [Remark("", f"no posture {name!r}: return_book needs it") for name in ("look", "carry")]
    lines = grouped([*alike, Remark("link 'a'", "no mass", at[0]), Remark("", "no wheels"), *postures])
    assert lines == [
        "r.urdf:4:3: link 'a': a mass of 0 kg (and 2 more links: b, c)",
        "r.urdf:4:3: link 'a': no mass",
        "no wheels",
        "no posture 'look': return_book needs it",
        "no posture 'carry': return_book needs it",
    ]


def test_findings_that_are_alike_are_told_in_one_line() -> None:
    alike = [Finding("r.urdf", n, 1, f"link 'l{n}': it isn't there") for n in range(1, 8)]
    (line,) = grouped_findings(alike)
    assert line == "r.urdf:1:1: link 'l1': it isn't there (and 6 more lines: 2, 3, 4, 5, ...)"
