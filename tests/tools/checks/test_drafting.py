"""Robot files that are drafted from URDFs: their contents and gaps, and where they can be written."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.files.extras import is_there
from tests.tools.conftest import Said

BOX = '<collision><geometry><box size="0.1 0.02 0.02"/></geometry></collision>'
BASE = '<collision><origin xyz="0 0 0.1"/><geometry><box size="0.4 0.3 0.1"/></geometry></collision>'
ROLLER = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
LIMIT = '<limit lower="{}" upper="{}" effort="5" velocity="1"/>'


def link(name: str, body: str = "") -> str:
    return f'<link name="{name}">{body}</link>\n'


def joint(
    name: str, kind: str, ends: str, xyz: str = "0 0 0", axis: str = "0 0 1", limit: str = "-1 1"
) -> str:
    parent, child = ends.split()
    limits = LIMIT.format(*limit.split()) if kind in ("revolute", "prismatic") else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>{limits}</joint>\n'
    )


WHEELS = (
    link("wl", ROLLER) + link("wr", ROLLER)
    + joint("left_wheel", "continuous", "base_link wl", "0 0.2 0.1", "0 1 0")
    + joint("right_wheel", "continuous", "base_link wr", "0 -0.2 0.1", "0 1 0")
)  # fmt: skip
ARM = (
    link("upper", BOX) + link("tool0", BOX)
    + joint("shoulder", "revolute", "base_link upper", "0 0 0.5")
    + joint("elbow", "revolute", "upper tool0", "0.2 0 0.2")
)  # fmt: skip
HEAD = (
    link("head") + link("head_camera_link") + link("head_camera_rgb_optical_frame")
    + joint("pan", "revolute", "base_link head", "0 0 0.9")
    + joint("on_head", "fixed", "head head_camera_link")
    + joint("optics", "fixed", "head_camera_link head_camera_rgb_optical_frame")
)  # fmt: skip
WRIST = (
    link("wrist_camera_link") + link("wrist_camera_depth_optical_frame")
    + link("wrist_camera_color_optical_frame")
    + joint("w1", "fixed", "tool0 wrist_camera_link")
    + joint("w2", "fixed", "wrist_camera_link wrist_camera_depth_optical_frame")
    + joint("w3", "fixed", "wrist_camera_link wrist_camera_color_optical_frame")
)  # fmt: skip
LASER = (
    link("rgbd_laser_link") + link("laser_mount") + link("base_laser_link")
    + joint("l0", "fixed", "base_link rgbd_laser_link", "-0.9 0 0")
    + joint("l1", "fixed", "base_link laser_mount", "0.2 0 0.2")
    + joint("l2", "fixed", "laser_mount base_laser_link")
)  # fmt: skip
TURNING = (
    link("f1", BOX) + link("f2", BOX)
    + joint("finger_1", "revolute", "tool0 f1") + joint("finger_2", "revolute", "tool0 f2")
)  # fmt: skip


def sliding(body: str) -> str:
    return (
        link("fl", body)
        + link("fr", body)
        + joint("finger_left", "prismatic", "tool0 fl", "0.1 0.0 0", "0 1 0", "0 0.04")
        + joint("finger_right", "prismatic", "tool0 fr", "0.1 0.0 0", "0 -1 0", "0 0.04")
    )


@pytest.fixture
def drafted(handcart: Callable[..., Said], tmp_path: Path) -> Callable[..., str]:
    """Drafts a robot from parts of a URDF; gives the draft, which is in `robot.yaml`."""

    def draft(*parts: str) -> str:
        text = f'<robot name="r">\n{link("base_link", BASE)}{"".join(parts)}</robot>\n'
        (tmp_path / "r.urdf").write_text(text, encoding="utf-8")
        (tmp_path / "robot.yaml").unlink(missing_ok=True)
        said = handcart("check", tmp_path / "r.urdf", "--draft", tmp_path / "robot.yaml")
        assert said.status == 0, said.err
        return (tmp_path / "robot.yaml").read_text(encoding="utf-8")

    return draft


def test_head_camera_is_left_out_with_the_reason(drafted: Callable[..., str], tmp_path: Path) -> None:
    text = drafted(WHEELS, ARM, HEAD, LASER)
    assert "# camera: head_camera_rgb_optical_frame moves against the hand" in text
    assert 'range_sensor: "base_laser_link"' in text
    robot = load_robot(str(tmp_path / "robot.yaml"))
    assert (robot.localizer, robot.camera) == ("scan", None)


MASTS = (
    link("mast", BOX) + joint("m", "fixed", "base_link mast", "-0.2 0 0.2")
    + link("pole", BOX) + joint("p", "fixed", "base_link pole", "0.2 0.3 0.2")
)  # fmt: skip


def test_lidar_that_sees_the_robot_itself_is_masked(drafted: Callable[..., str], tmp_path: Path) -> None:
    text = drafted(WHEELS, LASER, MASTS)
    assert (
        "  masked_deg: [[178, -178], [80, 100]]     # by the URDF it sees the robot itself: mast, pole"
        in text
    )
    lidar = load_robot(str(tmp_path / "robot.yaml")).range_sensor
    assert lidar is not None
    degrees = np.array([0.0, 75.0, 90.0, 105.0, 170.0, 180.0, -170.0])
    assert lidar.masked(np.radians(degrees)).tolist() == [False, False, True, False, False, True, False]
    assert "masked_deg" not in drafted(WHEELS, LASER)


def test_optical_frame_on_the_hand_comes_first(drafted: Callable[..., str], tmp_path: Path) -> None:
    assert 'camera: "wrist_camera_color_optical_frame"' in drafted(WHEELS, ARM, HEAD, WRIST)
    assert load_robot(str(tmp_path / "robot.yaml")).camera is not None


def test_bare_arm_gets_no_wheels(
    drafted: Callable[..., str], handcart: Callable[..., Said], tmp_path: Path
) -> None:
    text = drafted(ARM)
    assert "wheel_radius_m" not in text
    assert '#   - {urdf: "r.urdf", onto: base' in text
    assert "the key 'drive' is missing" in handcart("check", tmp_path / "robot.yaml").err


@pytest.mark.parametrize(
    ("fingers", "words"),
    [
        (TURNING, "# gripper: finger_1, finger_2: they turn; only two fingers that slide can be used"),
        (sliding(""), "# gripper: the link 'left_finger' has no collision box"),
        (sliding(BOX), 'gripper: {left: "finger_left", right: "finger_right", opening_mm: 80'),
    ],
    ids=["turning", "without boxes", "sliding"],
)
def test_gripper_is_drafted_or_its_reason_is_told(
    drafted: Callable[..., str], tmp_path: Path, fingers: str, words: str
) -> None:
    assert f"\n{words}" in drafted(WHEELS, ARM, fingers)
    robot = load_robot(str(tmp_path / "robot.yaml"))
    assert (robot.gripper is None) is words.startswith("#")


def test_home_is_free_and_within_the_footprint(
    drafted: Callable[..., str], handcart: Callable[..., Said], tmp_path: Path
) -> None:
    """A link that always overlaps another is allowed to, and that is marked."""
    overlapping = BASE.replace("0 0 0.1", "0 0 0.5").replace("0.4 0.3 0.1", "0.4 0.3 1.2")
    text = drafted(WHEELS, link("mast", overlapping), joint("m", "fixed", "base_link mast"), ARM)
    assert "allowed_contacts:     # their hulls touch however the arm is" in text
    said = handcart("check", tmp_path / "robot.yaml")
    assert said.status == 0
    assert "touches itself" not in said.out
    assert "within the footprint" not in said.out


def test_base_is_the_frame_on_the_floor(drafted: Callable[..., str]) -> None:
    raised = WHEELS.replace("0.2 0.1", "0.2 -0.05")
    assert 'base: "base_link"     # 0.150 m above the floor' in drafted(raised)
    foot = link("foot") + joint("down", "fixed", "base_link foot", "0 0 -0.15")
    assert 'base: "foot"\n' in drafted(raised, foot)


def test_draft_names_a_urdf_of_a_package(
    handcart: Callable[..., Said], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, mine = tmp_path / "ws" / "share" / "my_robot" / "urdf", tmp_path / "mine"
    folder.mkdir(parents=True)
    mine.mkdir()
    (folder / "r.urdf").write_text(
        f'<robot name="r">{link("base_link", BASE)}{WHEELS}</robot>', encoding="utf-8"
    )
    refused = handcart("check", folder / "r.urdf", "--draft", mine / "robot.yaml")
    assert (refused.status, "or a URDF in a package" in refused.err) == (2, True)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "ws"))
    assert handcart("check", folder / "r.urdf", "--draft", mine / "robot.yaml").status == 0
    assert load_robot(str(mine / "robot.yaml")).urdf == "package://my_robot/urdf/r.urdf"


XACRO = (
    '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n<xacro:property name="h" value="0.1"/>\n'
    f"{link('base_link', BASE)}"
    f"{WHEELS.replace('0.2 0.1', '${2*h} ${h}')}</robot>\n"
)


def xacro_draft(handcart: Callable[..., Said], folder: Path, text: str = XACRO) -> Said:
    (folder / "r.urdf.xacro").write_text(text, encoding="utf-8")
    return handcart("check", folder / "r.urdf.xacro", "--draft", folder / "robot.yaml")


@pytest.mark.skipif(is_there("xacrodoc"), reason="xacrodoc is installed")
def test_xacro_file_without_the_library_is_told_how(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = xacro_draft(handcart, tmp_path)
    assert said.status == 2
    assert "r.urdf.xacro:1:1: a xacro file needs xacrodoc, not installed" in said.err
    assert "pip install 'handcart[xacro]'; or write a URDF: xacro FILE > robot.urdf" in said.err
    assert [path.name for path in tmp_path.iterdir()] == ["r.urdf.xacro"]


@pytest.mark.skipif(not is_there("xacrodoc"), reason="xacrodoc is not installed")
@pytest.mark.parametrize(
    ("bad", "words"),
    [("", ""), ("${no_such}", "xacro can't expand it"), ("$(find no_such)", "unknown package 'no_such'")],
)
def test_xacro_file_is_expanded_beside_the_draft(
    handcart: Callable[..., Said], tmp_path: Path, bad: str, words: str
) -> None:
    said = xacro_draft(handcart, tmp_path, XACRO.replace('value="0.1"', f'value="{bad or 0.1}"'))
    assert words in said.err
    files: Sequence[str] = sorted(path.name for path in tmp_path.iterdir())
    assert files == (["r.urdf.xacro"] if bad else ["r.urdf", "r.urdf.xacro", "robot.yaml"])
    if not bad:
        assert load_robot(str(tmp_path / "robot.yaml")).drive.tread_m == pytest.approx(0.4)
